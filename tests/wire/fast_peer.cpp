/* A peer of Fast DDS that speaks the wire without any of our code, nor Cyclone's: fast_peer DOMAIN PROFILES waits until
 * an end of each topic, made by its profile, has found the daemon's; then it reads a Status, and publishes a PoseBatch
 * with an extension until it is ended. It prints the bytes of extensions in the Status. CDR is read and written by
 * hand, by the order of fields of v1/collided.idl. */
#include <fastcdr/Cdr.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

typedef std::vector<char> bytes; // with the header of 4 bytes

/* Samples as they travel. */
class raw : public TopicDataType
{
  public:
    raw(const char *name, bool keyed)
    {
        setName(name);
        m_typeSize = 1 << 20;
        m_isGetKeyDefined = keyed;
    }
    bool serialize(void *data, SerializedPayload_t *payload) override
    {
        const bytes &b = *static_cast<bytes *>(data);
        std::memcpy(payload->data, b.data(), b.size());
        payload->length = static_cast<uint32_t>(b.size());
        payload->encapsulation = CDR_LE;
        return true;
    }
    bool deserialize(SerializedPayload_t *payload, void *data) override
    {
        const char *from = reinterpret_cast<char *>(payload->data);
        static_cast<bytes *>(data)->assign(from, from + payload->length);
        return true;
    }
    std::function<uint32_t()> getSerializedSizeProvider(void *data) override
    {
        return [data] { return static_cast<uint32_t>(static_cast<bytes *>(data)->size()); };
    }
    void *createData() override { return new bytes; }
    void deleteData(void *data) override { delete static_cast<bytes *>(data); }
    bool getKey(void *, InstanceHandle_t *handle, bool) override
    {
        *handle = InstanceHandle_t(); /* of one daemon all are one instance */
        handle->value[0] = 1;
        return true;
    }
};

/* The number of bytes in its extensions, or -1: not a Status. */
static long extensions_of_status(bytes &b)
{
    FastBuffer buffer(b.data(), b.size());
    Cdr in(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    int32_t version;
    int64_t epoch, stamp, started, tick;
    uint8_t health;
    std::string daemon, release, links, limits;
    std::vector<std::string> names;
    std::vector<int64_t> values;
    std::vector<uint8_t> extensions;
    try {
        in.read_encapsulation();
        in >> version >> epoch >> health >> daemon >> release >> links >> limits >> stamp >> started >> tick >> names >>
            values >> extensions;
    } catch (const std::exception &e) {
        std::printf("%s\n", e.what());
        return -1;
    }
    return version == 1 && epoch && names.size() == values.size() && !names.empty() ? long(extensions.size()) : -1;
}

static bytes pose_batch(int64_t sequence)
{
    const std::vector<uint8_t> extensions = {77, 0, 0, 0, 2, 0, 0, 0, 'h', 'i'}, teleports;
    const std::vector<int32_t> bodies = {1};
    const std::vector<double> position = {1, 2, 3}, orientation = {1, 0, 0, 0}, none;
    const int64_t zero = 0, client = 0xfa57;
    bytes b(1024);
    FastBuffer buffer(b.data(), b.size());
    Cdr out(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    out.serialize_encapsulation();
    out << int32_t(1) << client << sequence << zero << zero << zero << bodies << position << orientation << none << none
        << teleports << extensions;
    b.resize(out.getSerializedDataLength());
    return b;
}

static std::string profile_of(const char *name)
{
    return std::string("collided_") + name;
}

static Topic *topic_of(DomainParticipant *p, const char *name)
{
    static const std::set<std::string> keyed = {"Client", "Geometry", "Body", "Subscription", "Status"};
    TypeSupport type(new raw((std::string("collided::") + name).c_str(), keyed.count(name) > 0));
    type.register_type(p);
    return p->create_topic(profile_of(name), type.get_type_name(), TOPIC_QOS_DEFAULT);
}

/* Has the daemon an end for each? With `tell` the first that it has none for is named. */
static bool all_found(
    const std::map<std::string, DataWriter *> &writers, const std::map<std::string, DataReader *> &readers, bool tell)
{
    std::string missing;
    for (const auto &w : writers) {
        PublicationMatchedStatus found;
        if (!w.second || w.second->get_publication_matched_status(found) != ReturnCode_t::RETCODE_OK ||
            found.current_count < 1)
            missing = w.first;
    }
    for (const auto &r : readers) {
        SubscriptionMatchedStatus found;
        if (!r.second || r.second->get_subscription_matched_status(found) != ReturnCode_t::RETCODE_OK ||
            found.current_count < 1)
            missing = r.first;
    }
    if (tell && !missing.empty()) std::printf("the daemon is not found by the profile of %s\n", missing.c_str());
    return missing.empty();
}

int main(int argc, char **argv)
{
    if (argc != 3) return 2;
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    auto domain = static_cast<DomainId_t>(std::strtoul(argv[1], nullptr, 10));
    if (DomainParticipantFactory::get_instance()->load_XML_profiles_file(argv[2]) != ReturnCode_t::RETCODE_OK) return 2;
    DomainParticipant *p =
        DomainParticipantFactory::get_instance()->create_participant(domain, PARTICIPANT_QOS_DEFAULT);
    if (!p) return 2;
    Publisher *publisher = p->create_publisher(PUBLISHER_QOS_DEFAULT);
    Subscriber *subscriber = p->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
    std::map<std::string, DataWriter *> writers;
    std::map<std::string, DataReader *> readers;
    for (const char *name :
        {"Client", "Geometry", "Body", "Subscription", "PoseBatch", "VertexBatch", "Query", "Receipt"})
        writers[name] = publisher->create_datawriter_with_profile(topic_of(p, name), profile_of(name));
    for (const char *name : {"Status", "Answer", "Reject", "Ack"})
        readers[name] = subscriber->create_datareader_with_profile(topic_of(p, name), profile_of(name));
    if (!subscriber->create_datareader_with_profile(topic_of(p, "EventBatch"), profile_of("EventBatch"))) return 2;
    for (int tries = 0; !all_found(writers, readers, tries > 400); tries++) {
        if (tries > 400) return 1;
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    DataReader *reader = readers["Status"];
    DataWriter *writer = writers["PoseBatch"];
    for (int64_t sequence = 1;; sequence++) {
        bytes status, poses = pose_batch(sequence);
        SampleInfo info;
        while (reader->take_next_sample(&status, &info) == ReturnCode_t::RETCODE_OK)
            if (info.valid_data) std::printf("extensions %ld\n", extensions_of_status(status));
        writer->write(&poses);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}
