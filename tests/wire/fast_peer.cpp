/* A peer of Fast DDS that speaks the wire without any of our code, nor Cyclone's: fast_peer DOMAIN reads a Status, and
 * publishes a PoseBatch with an extension until it is ended. It prints the bytes of extensions in the Status. CDR is
 * read and written by hand, by the order of fields of v1/collided.idl. */
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

int main(int argc, char **argv)
{
    if (argc != 2) return 2;
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    auto domain = static_cast<DomainId_t>(std::strtoul(argv[1], nullptr, 10));
    DomainParticipant *p =
        DomainParticipantFactory::get_instance()->create_participant(domain, PARTICIPANT_QOS_DEFAULT);
    if (!p) return 2;
    TypeSupport status_type(new raw("collided::Status", true)), pose_type(new raw("collided::PoseBatch", false));
    status_type.register_type(p);
    pose_type.register_type(p);
    Topic *status_topic = p->create_topic("collided_Status", "collided::Status", TOPIC_QOS_DEFAULT);
    Topic *pose_topic = p->create_topic("collided_PoseBatch", "collided::PoseBatch", TOPIC_QOS_DEFAULT);
    DataReaderQos in;
    in.reliability().kind = RELIABLE_RELIABILITY_QOS;
    in.durability().kind = TRANSIENT_LOCAL_DURABILITY_QOS;
    in.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    DataReader *reader = p->create_subscriber(SUBSCRIBER_QOS_DEFAULT)->create_datareader(status_topic, in);
    DataWriterQos out;
    out.reliability().kind = RELIABLE_RELIABILITY_QOS;
    out.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    DataWriter *writer = p->create_publisher(PUBLISHER_QOS_DEFAULT)->create_datawriter(pose_topic, out);
    if (!reader || !writer) return 2;
    for (int64_t sequence = 1;; sequence++) {
        bytes status, poses = pose_batch(sequence);
        SampleInfo info;
        while (reader->take_next_sample(&status, &info) == ReturnCode_t::RETCODE_OK)
            if (info.valid_data) std::printf("extensions %ld\n", extensions_of_status(status));
        writer->write(&poses);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
}
