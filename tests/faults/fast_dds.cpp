/* A participant of Fast DDS as it comes, without initial peers: how long until it has found a daemon, and the daemon's
 * writer of Status? fast_dds DOMAIN SECONDS prints that in seconds; its exit status is 1 if it was not within SECONDS.
 */
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>

using namespace eprosima::fastdds::dds;

class listener : public DomainParticipantListener
{
  public:
    void on_publisher_discovery(DomainParticipant *, eprosima::fastrtps::rtps::WriterDiscoveryInfo &&found) override
    {
        std::lock_guard<std::mutex> guard(lock);
        has_found |= std::strcmp(found.info.topicName().c_str(), "collided_Status") == 0;
        news.notify_one();
    }

    bool wait(double seconds)
    {
        std::unique_lock<std::mutex> guard(lock);
        return news.wait_for(guard, std::chrono::duration<double>(seconds), [this] { return has_found; });
    }

  private:
    std::mutex lock;
    std::condition_variable news;
    bool has_found = false;
};

int main(int argc, char **argv)
{
    if (argc != 3) return 2;
    listener l;
    auto began = std::chrono::steady_clock::now();
    auto factory = DomainParticipantFactory::get_instance();
    auto domain = static_cast<DomainId_t>(std::strtoul(argv[1], nullptr, 10));
    DomainParticipant *p = factory->create_participant(domain, PARTICIPANT_QOS_DEFAULT, &l);
    if (!p) return 2;
    bool found = l.wait(std::strtod(argv[2], nullptr));
    std::printf("%.3f\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
    p->set_listener(nullptr);
    factory->delete_participant(p);
    return found ? 0 : 1;
}
