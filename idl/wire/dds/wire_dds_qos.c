/* The quality-of-service table and the configuration that it rests on. Nothing is kept between calls; any thread. */
#include "wire_dds_qos.h"

#include <dds/dds.h>

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* State: the last sample of each instance, kept for late joiners. Flows: as much history as bridges about two seconds
 * of a peer that stalls, at 100 Hz. The daemon's readers hold the flows of many clients, hence their greater depth. */
static const wire_dds_profile profiles[WIRE_KIND_COUNT] = {
    [WIRE_CLIENT] = {.late_joiners = true, .writer_depth = 1, .reader_depth = 1},
    [WIRE_GEOMETRY] = {.late_joiners = true, .writer_depth = 1, .reader_depth = 1},
    [WIRE_BODY] = {.late_joiners = true, .writer_depth = 1, .reader_depth = 1},
    [WIRE_POSE_BATCH] = {.writer_depth = 256, .reader_depth = 1024},
    [WIRE_VERTEX_BATCH] = {.writer_depth = 64, .reader_depth = 256},
    [WIRE_SUBSCRIPTION] = {.late_joiners = true, .writer_depth = 1, .reader_depth = 1},
    [WIRE_QUERY] = {.writer_depth = 256, .reader_depth = 1024},
    [WIRE_RECEIPT] = {.writer_depth = 256, .reader_depth = 1024},
    [WIRE_ANSWER] = {.writer_depth = 1024, .reader_depth = 1024},
    [WIRE_EVENT_BATCH] = {.by_partition = true, .writer_depth = 256, .reader_depth = 256},
    [WIRE_STATUS] = {.late_joiners = true, .writer_depth = 1, .reader_depth = 1},
    [WIRE_REJECT] = {.writer_depth = 1024, .reader_depth = 1024},
    [WIRE_ACK] = {.writer_depth = 1024, .reader_depth = 1024},
};

const wire_dds_profile *wire_dds_profile_of(wire_kind kind)
{
    bool known = (unsigned)kind > WIRE_NOTHING && (unsigned)kind < WIRE_KIND_COUNT;
    return known ? &profiles[kind] : NULL;
}

void wire_dds_topic(wire_kind kind, char name[WIRE_DDS_TOPIC_MAX])
{
    snprintf(name, WIRE_DDS_TOPIC_MAX, "collided_%s", wire_kind_name(kind));
}

void wire_dds_partition(const char *stream, char partition[WIRE_DDS_PARTITION_MAX])
{
    static const char prefix[] = "stream:";
    memcpy(partition, prefix, sizeof prefix);
    size_t at = sizeof prefix - 1;
    for (; *stream && at + 4 <= WIRE_DDS_PARTITION_MAX; stream++) {
        unsigned char c = (unsigned char)*stream;
        bool plain = isascii(c) && (isalnum(c) || c == '.' || c == '-' || c == '_' || c == '/');
        if (plain)
            partition[at++] = (char)c;
        else
            at += (size_t)snprintf(partition + at, 4, "%%%02X", c);
    }
    partition[at] = '\0';
}

dds_qos_t *wire_dds_qos(wire_kind kind, wire_dds_side side, const char *stream, int64_t lease_ns)
{
    const wire_dds_profile *p = wire_dds_profile_of(kind);
    dds_qos_t *q = dds_create_qos();
    dds_qset_reliability(q, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(q, p->late_joiners ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_history(q, DDS_HISTORY_KEEP_LAST, side == WIRE_DDS_WRITER ? p->writer_depth : p->reader_depth);
    if (side == WIRE_DDS_WRITER) dds_qset_writer_data_lifecycle(q, false);
    if (side == WIRE_DDS_WRITER && lease_ns > 0) dds_qset_liveliness(q, DDS_LIVELINESS_AUTOMATIC, lease_ns);
    if (p->by_partition && stream) {
        char partition[WIRE_DDS_PARTITION_MAX];
        wire_dds_partition(stream, partition);
        dds_qset_partition1(q, partition);
    }
    return q;
}

void wire_dds_replies(unsigned group, char partition[WIRE_DDS_PARTITION_MAX])
{
    snprintf(partition, WIRE_DDS_PARTITION_MAX, "replies:%u", group % WIRE_DDS_REPLIES);
}

/* Fibonacci hashing: ids that count up are spread as evenly as those that are drawn. */
unsigned wire_dds_replies_of(int64_t client)
{
    return (unsigned)(((uint64_t)client * UINT64_C(0x9E3779B97F4A7C15)) >> 32) % WIRE_DDS_REPLIES;
}

void wire_dds_events(unsigned group, char partition[WIRE_DDS_PARTITION_MAX])
{
    snprintf(partition, WIRE_DDS_PARTITION_MAX, "events:%u", group % WIRE_DDS_EVENTS);
}

unsigned wire_dds_events_of(int64_t client)
{
    return (unsigned)(((uint64_t)client * UINT64_C(0x9E3779B97F4A7C15)) >> 40) % WIRE_DDS_EVENTS;
}

void wire_dds_user_data(unsigned replies, unsigned events, char text[WIRE_DDS_USER_DATA_MAX])
{
    snprintf(text, WIRE_DDS_USER_DATA_MAX, "replies:%u events:%u", replies, events);
}

static int group_in(const char *text, const char *prefix, unsigned most)
{
    const char *at = strstr(text, prefix);
    char *end;
    if (!at || (at != text && at[-1] != ' ') || !isdigit((unsigned char)at[strlen(prefix)])) return 0;
    unsigned long group = strtoul(at + strlen(prefix), &end, 10);
    return (*end == ' ' || !*end) && group < most ? (int)group + 1 : 0;
}

void wire_dds_user_data_read(const void *data, size_t size, int *replies, int *events)
{
    char text[WIRE_DDS_USER_DATA_MAX] = "";
    if (data && size < sizeof text) memcpy(text, data, size);
    *replies = group_in(text, "replies:", WIRE_DDS_REPLIES);
    *events = group_in(text, "events:", WIRE_DDS_EVENTS);
}

/* MaxMessageSize 65500B halves the time of large batches, but only loopback carries such datagrams unfragmented. All
 * that a newcomer learns of the daemon is, to Cyclone, sent again: MaxRexmitMessageSize (1,456 B by default) makes that
 * two datagrams instead of forty, or, where two newcomers ask at the same time, as many to everybody who is there.
 *
 * Without multicast, who is to be found must have one of the well-known ports (WIRE_DDS_INDICES of them a domain), and
 * announces itself to them. Clients have any port: they tell those ports of themselves, and only who sits there, the
 * daemons, answers them. So clients neither use up the well-known ports nor hear of each other, and a crowd costs what
 * its number does. Others (Fast DDS) announce themselves by multicast only, which loopback mostly lacks, and listen at
 * their well-known port: the daemon has to speak there often, so that they find it at once. Whenever it does, Cyclone
 * tells all participants that it knows, too: so not by SPDPInterval, but by link_dds_joiners.c, rarer in a crowd. */
#define LOOPBACK(index)                                                                                                \
    "<General><Interfaces><NetworkInterface name=\"lo\" multicast=\"false\"/></Interfaces>"                            \
    "<AllowMulticast>false</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize>"                                    \
    "<MaxRexmitMessageSize>65500B</MaxRexmitMessageSize><FragmentSize>60000B</FragmentSize></General>"                 \
    "<Discovery><ParticipantIndex>" index "</ParticipantIndex><MaxAutoParticipantIndex>63</MaxAutoParticipantIndex>"   \
    "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>"
_Static_assert(WIRE_DDS_INDICES == 64, "as LOOPBACK says");
static const char *const loopback[] = {
    [WIRE_DDS_ANYBODY] = LOOPBACK("auto"),
    [WIRE_DDS_DAEMON] = LOOPBACK("auto"),
    [WIRE_DDS_CLIENT_LIBRARY] = LOOPBACK("none"),
    [WIRE_DDS_CLIENT_OF_CROWD] = LOOPBACK("none"),
};

/* A room's participant of the daemon has an index beyond the well-known ones, and with it a port that a client can
 * name. Neither says anything to anybody else. */
static const char room_general[] =
    "<General><Interfaces><NetworkInterface name=\"lo\" multicast=\"false\"/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast><MaxMessageSize>65500B</MaxMessageSize>"
    "<MaxRexmitMessageSize>65500B</MaxRexmitMessageSize>"
    "<FragmentSize>60000B</FragmentSize></General>";
static const char room_of_daemon[] = "<Discovery><ExternalDomainId>%u</ExternalDomainId><Tag>collided:%u</Tag>"
                                     "<ParticipantIndex>%u</ParticipantIndex></Discovery>";
static const char room_of_client[] = "<Discovery><ExternalDomainId>%u</ExternalDomainId><Tag>collided:%u</Tag>"
                                     "<ParticipantIndex>none</ParticipantIndex>"
                                     "<Peers><Peer address=\"127.0.0.1:%u\"/></Peers></Discovery>";
enum { PORT_BASE = 7400, PORTS_A_DOMAIN = 250, PORT_OF_INDEX_0 = 10 };
_Static_assert(PORT_OF_INDEX_0 + 2 * (WIRE_DDS_INDICES + WIRE_DDS_ROOMS) + 1 < PORTS_A_DOMAIN, "within the domain");

/* On a network the same holds: a client of this library sends its announcement to the group of discovery, which daemons
 * and others have joined, and does not join it. What is for it comes to it alone. */
static const char network[] = "<General><Interfaces><NetworkInterface %s=\"%s\"/></Interfaces>%s</General>%s";
static const char apart[] = "<AllowMulticast>false</AllowMulticast>";
static const char group[] = "<Discovery><Peers><Peer address=\"239.255.0.1\"/></Peers></Discovery>";

/* The intervals keep the 99th percentile at 20 ms when 5 % of the packets are lost (300 ms by default). A sample beyond
 * MaxSampleSize is not assembled: the largest legal message, a full PoseBatch, has 7 MB. */
static const char tuning[] = "<Internal>%s<MaxSampleSize>16MB</MaxSampleSize><WriteBatch>%s</WriteBatch></Internal>";
static const char soon[] =
    "<HeartbeatInterval>5ms</HeartbeatInterval><NackDelay>1ms</NackDelay><AckDelay>1ms</AckDelay>";

/* On loopback packets are lost only when a process does not get to reading them, and the daemon is patient: a heartbeat
 * goes to all readers of a writer as long as two of them have not acknowledged, and is answered by all; of hundreds
 * that start at once most have not, for want of a processor. Every 100 ms, of each writer, that took all the time that
 * there was, and what was late came again instead of soon: of 400 clients at once 23 came in within a minute. Half a
 * second is soon enough, since each write has a heartbeat with it, and a stream's first and last words are reminded of
 * (link_dds_reminder.h, link_dds_await); a whole one left an answer that was lost twice unanswered for three. All that
 * is asked for is sent (200 messages by default: one newcomer asks for nearly as many, of discovery); what is
 * acknowledged is acknowledged before a client asks, 10 ms later, whether it has come. */
static const char patient[] = "<HeartbeatInterval min=\"100ms\" minsched=\"100ms\">500ms</HeartbeatInterval>"
                              "<NackDelay>1ms</NackDelay><AckDelay>2ms</AckDelay>"
                              "<MaxQueuedRexmitMessages>100000</MaxQueuedRexmitMessages>"
                              "<MaxQueuedRexmitBytes>64MB</MaxQueuedRexmitBytes>";

/* What a client says goes to daemons alone: it asks again after 10 ms (from the sixth time on less and less often), for
 * where another client floods the daemon's socket, one packet of ten is lost, whosever it is. It says at once that it
 * reads, since until then it is in its turn (wire_dds_turn.h), and drops what comes. */
static const char prompt[] = "<HeartbeatInterval min=\"5ms\" minsched=\"10ms\" max=\"4s\">10ms</HeartbeatInterval>"
                             "<NackDelay>20ms</NackDelay><AckDelay>10ms</AckDelay>"
                             "<PreEmptiveAckDelay>1ms</PreEmptiveAckDelay>";

/* What one of a crowd says waits for the daemon more often than it is lost: asked for again after 10 ms, by hundreds,
 * it keeps the daemon from reading it, whose socket overflows, so that all is asked for again (of 400 at once 62 had
 * not come in after a minute, and the daemon's two sockets had lost 200,000 of 590,000 packets). */
static const char of_crowd[] = "<HeartbeatInterval min=\"50ms\" minsched=\"100ms\" max=\"4s\">100ms</HeartbeatInterval>"
                               "<NackDelay>20ms</NackDelay><AckDelay>10ms</AckDelay>"
                               "<PreEmptiveAckDelay>1ms</PreEmptiveAckDelay>";

static const char *internal_of(wire_dds_role role, bool network_is_open, char *out, size_t size)
{
    const char *intervals = network_is_open || role == WIRE_DDS_ANYBODY ? soon
                            : role == WIRE_DDS_CLIENT_LIBRARY           ? prompt
                            : role == WIRE_DDS_CLIENT_OF_CROWD          ? of_crowd
                                                                        : patient;
    snprintf(out, size, tuning, intervals, role == WIRE_DDS_DAEMON ? "true" : "false");
    return out;
}

/* Names and addresses of interfaces have none of XML's special characters; anything else is no interface. */
static bool is_interface(const char *text)
{
    return text[strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789.:_-@%")] == '\0';
}

bool wire_dds_config(char *out, size_t size, const char *interface, wire_dds_role role)
{
    char general[512];
    bool open = interface && interface[0], library = role >= WIRE_DDS_CLIENT_LIBRARY,
         client = library && open && !strchr(interface, ':');
    if (open) {
        bool address = strspn(interface, "0123456789.") == strlen(interface) || strchr(interface, ':') != NULL;
        int n = snprintf(general, sizeof general, network, address ? "address" : "name", interface, client ? apart : "",
            client ? group : "");
        if (n < 0 || (size_t)n >= sizeof general || !is_interface(interface)) return false;
    }
    char internal[sizeof tuning + sizeof patient + sizeof prompt];
    internal_of(role, open, internal, sizeof internal);
    const char *user = getenv("CYCLONEDDS_URI");
    bool appended = user && user[0];
    int n = snprintf(out, size, "<CycloneDDS><Domain Id=\"any\">%s%s</Domain></CycloneDDS>%s%s",
        open ? general : loopback[role], internal, appended ? "," : "", appended ? user : "");
    return n >= 0 && (size_t)n < size;
}

uint32_t wire_dds_room_domain(uint32_t domain, unsigned room)
{
    enum { ROOM_DOMAINS = 0x10000 };
    return ROOM_DOMAINS + domain * (WIRE_DDS_ROOMS + 1) + room;
}

bool wire_dds_config_room(char *out, size_t size, uint32_t domain, unsigned room, wire_dds_role role)
{
    char internal[sizeof tuning + sizeof patient + sizeof prompt], discovery[512];
    unsigned index = WIRE_DDS_INDICES + room - 1;
    if (role == WIRE_DDS_DAEMON)
        snprintf(discovery, sizeof discovery, room_of_daemon, domain, room, index);
    else
        snprintf(discovery, sizeof discovery, room_of_client, domain, room,
            PORT_BASE + PORTS_A_DOMAIN * domain + PORT_OF_INDEX_0 + 2 * index);
    int n = snprintf(out, size, "<CycloneDDS><Domain Id=\"any\">%s%s%s</Domain></CycloneDDS>", room_general, discovery,
        internal_of(role, false, internal, sizeof internal));
    return n >= 0 && (size_t)n < size;
}

bool wire_dds_has_rooms(void)
{
    const char *user = getenv("CYCLONEDDS_URI");
    return !user || !user[0];
}
