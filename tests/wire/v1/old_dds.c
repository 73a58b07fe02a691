/* old_dds DOMAIN: a client of Cyclone's calls and of what idlc makes of the collided.idl beside it. See old.h. */
#include "old.h"

#include "collided.h"

#include <dds/dds.h>
#include <string.h>
#include <unistd.h>

#define ON_LOOPBACK                                                                                                    \
    "<General><Interfaces><NetworkInterface address=\"127.0.0.1\"/></Interfaces><AllowMulticast>false"                 \
    "</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>60"       \
    "</MaxAutoParticipantIndex><Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery>"

static dds_entity_t participant;
static dds_entity_t clients, geometries, bodies, poses, vertices, subscriptions, queries, receipts; /* writers */
static dds_entity_t answers, events, statuses, rejects, acks;                                       /* readers */

typedef enum keeping { IS_KEPT, IS_NOT } keeping;

static dds_qos_t *quality(keeping k)
{
    dds_qos_t *q = dds_create_qos();
    dds_qset_reliability(q, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(q, DDS_HISTORY_KEEP_LAST, k == IS_KEPT ? 1 : 256);
    dds_qset_durability(q, k == IS_KEPT ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
    dds_qset_writer_data_lifecycle(q, false);
    return q;
}

static dds_entity_t endpoint(
    const dds_topic_descriptor_t *type, const char *name, keeping k, bool writes, const char *partition)
{
    dds_entity_t topic = dds_create_topic(participant, type, name, NULL, NULL);
    dds_qos_t *q = quality(k);
    if (partition) dds_qset_partition1(q, partition);
    if (writes && strcmp(name, "collided_Client") == 0) dds_qset_liveliness(q, DDS_LIVELINESS_AUTOMATIC, DDS_SECS(10));
    dds_entity_t e =
        writes ? dds_create_writer(participant, topic, q, NULL) : dds_create_reader(participant, topic, q, NULL);
    dds_delete_qos(q);
    if (e > 0) return e;
    printf("%s: %s\n", name, dds_strretcode(e));
    exit(1);
}

#define WRITER(type, k) endpoint(&collided_##type##_desc, "collided_" #type, k, true, NULL)
#define READER(type, k) endpoint(&collided_##type##_desc, "collided_" #type, k, false, NULL)

static void open_all(uint32_t domain)
{
    if (dds_create_domain(domain, ON_LOOPBACK) < 0) exit(1);
    participant = dds_create_participant(domain, NULL, NULL);
    clients = WRITER(Client, IS_KEPT);
    geometries = WRITER(Geometry, IS_KEPT);
    bodies = WRITER(Body, IS_KEPT);
    poses = WRITER(PoseBatch, IS_NOT);
    vertices = WRITER(VertexBatch, IS_NOT);
    subscriptions = WRITER(Subscription, IS_KEPT);
    queries = WRITER(Query, IS_NOT);
    receipts = WRITER(Receipt, IS_NOT);
    answers = READER(Answer, IS_NOT);
    events = endpoint(&collided_EventBatch_desc, "collided_EventBatch", IS_NOT, false, "stream:" OLD_STREAM);
    statuses = READER(Status, IS_KEPT);
    rejects = READER(Reject, IS_NOT);
    acks = READER(Ack, IS_NOT);
}

/* ---- hearing ---- */

static void on_ack(const void *sample)
{
    const collided_Ack *m = sample;
    heard.extensions += m->extensions._length > 0;
    for (uint32_t i = 0; m->client_id == OLD_CLIENT && i < m->sequences._length; i++) take_ack(m->sequences._buffer[i]);
}

static void on_events(const void *sample)
{
    const collided_EventBatch *m = sample;
    if (m->client_id != OLD_CLIENT) return;
    heard.extensions += m->extensions._length > 0;
    for (uint32_t i = 0; i < m->kinds._length; i++)
        take_event(m->kinds._buffer[i], collided_EVENT_BEGIN, collided_EVENT_END, collided_EVENT_AVERTED);
}

static void on_answer(const void *sample)
{
    const collided_Answer *m = sample;
    if (m->client_id != OLD_CLIENT || m->sequence != SAY_QUERY || m->lo._length != 1) return;
    heard.answers++;
    heard.lo = m->lo._buffer[0];
    heard.hi = m->hi._buffer[0];
}

static void on_reject(const void *sample)
{
    const collided_Reject *m = sample;
    heard.rejects += m->client_id == OLD_CLIENT && m->sequence == SAY_BAD_BODY &&
                     m->reason == collided_REASON_BAD_SIZE && m->kind == collided_MESSAGE_BODY;
}

static void on_status(const void *sample)
{
    const collided_Status *m = sample;
    heard.statuses += m->version == collided_WIRE_VERSION && m->epoch != 0;
}

static void take(dds_entity_t reader, void (*on_sample)(const void *))
{
    void *samples[8] = {NULL};
    dds_sample_info_t infos[8];
    int n = dds_take(reader, samples, infos, 8, 8);
    for (int i = 0; i < n; i++)
        if (infos[i].valid_data) on_sample(samples[i]);
    if (n > 0) dds_return_loan(reader, samples, n);
}

static void receive(void)
{
    usleep(2000);
    take(acks, on_ack);
    take(events, on_events);
    take(answers, on_answer);
    take(rejects, on_reject);
    take(statuses, on_status);
}

/* ---- saying ---- */

static void say(dds_entity_t writer, const void *sample)
{
    if (dds_write(writer, sample) != DDS_RETCODE_OK) exit(1);
}

static void say_client(bool leaves)
{
    collided_Client m = {collided_WIRE_VERSION, OLD_CLIENT, leaves ? next_sequence++ : SAY_CLIENT, .removed = leaves,
        .lease_ns = INT64_C(10000000000), .name = "old client"};
    say(clients, &m);
}

static void say_body(int32_t id, int64_t sequence, const char *name, double x, double radius)
{
    double pose[7] = {x, 0, 0, 1, 0, 0, 0}, size[3] = {0}, in_body[7] = {0, 0, 0, 1, 0, 0, 0};
    uint8_t type = collided_SHAPE_SPHERE;
    int64_t geometry = 0;
    collided_Body m = {collided_WIRE_VERSION, OLD_CLIENT, sequence, id, .name = (char *)(uintptr_t)name, .group = "",
        .category = -1, .mask = -1, .pose = {7, 7, pose, false}, .shape_types = {1, 1, &type, false},
        .shape_sizes = {3, 3, size, false}, .shape_radii = {1, 1, &radius, false},
        .shape_poses = {7, 7, in_body, false}, .shape_geometries = {1, 1, &geometry, false}};
    say(bodies, &m);
}

static void say_subscription(void)
{
    collided_Subscription m = {collided_WIRE_VERSION, OLD_CLIENT, SAY_SUBSCRIPTION, OLD_SUBSCRIPTION,
        .facts = collided_FACT_TOUCH, .stream = OLD_STREAM, .select_a = "old_a", .select_b = "old_b"};
    say(subscriptions, &m);
}

static void say_pose(double x)
{
    int32_t body = OLD_BODY_B;
    double at[3] = {x, 0, 0}, turn[4] = {1, 0, 0, 0};
    collided_PoseBatch m = {collided_WIRE_VERSION, OLD_CLIENT, next_sequence++, .bodies = {1, 1, &body, false},
        .positions = {3, 3, at, false}, .orientations = {4, 4, turn, false}};
    say(poses, &m);
}

static void say_query(void)
{
    collided_Query m = {collided_WIRE_VERSION, OLD_CLIENT, SAY_QUERY, collided_QUERY_DISTANCE, .name_a = "old_a",
        .name_b = "old_b", .tolerance_m = 1e-9};
    say(queries, &m);
}

static uint32_t readers_of(dds_entity_t writer)
{
    dds_publication_matched_status_t s = {0};
    dds_get_publication_matched_status(writer, &s);
    return s.current_count;
}

/* Another definition would not match. */
static bool all_match(void)
{
    return readers_of(clients) && readers_of(geometries) && readers_of(bodies) && readers_of(poses) &&
           readers_of(vertices) && readers_of(subscriptions) && readers_of(queries) && readers_of(receipts);
}

int main(int argc, char **argv)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    if (argc != 2) return 2;
    open_all((uint32_t)strtoul(argv[1], NULL, 10));
    UNTIL((void)0, all_match() && heard.statuses);
    UNTIL(say_client(false), heard.acks[SAY_CLIENT]);
    UNTIL(say_body(OLD_BODY_A, SAY_BODY_A, "old_a", 0, 0.5), heard.acks[SAY_BODY_A]);
    UNTIL(say_body(OLD_BODY_B, SAY_BODY_B, "old_b", 3, 0.5), heard.acks[SAY_BODY_B]);
    UNTIL(say_subscription(), heard.acks[SAY_SUBSCRIPTION]);
    UNTIL(say_pose(0.9), heard.begins);
    UNTIL(say_query(), heard.answers);
    UNTIL(say_body(OLD_BAD_BODY, SAY_BAD_BODY, "old_bad", 9, -1), heard.rejects);
    UNTIL(say_pose(3), heard.ends);
    say_client(true);
    dds_delete(participant);
    return summary();
}
