/* One thread, polling: simple rather than quick. */
#include "dds_client.h"

#include "harness.h"
#include "wire/dds/wire_dds.h"
#include "wire/dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <unistd.h>

static dds_entity_t participant;

__attribute__((format(printf, 1, 2))) static void say(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vprintf(format, arguments);
    va_end(arguments);
    printf("\n");
    fflush(stdout);
}

static void must(bool ok, const char *what)
{
    if (ok) return;
    say("failed: %s", what);
    exit(EXIT_FAILURE);
}

static dds_entity_t endpoint(wire_kind kind, wire_dds_side side, const char *stream, int64_t lease_ns)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    dds_entity_t topic = dds_create_topic(participant, wire_dds_descriptor(kind), name, NULL, NULL);
    dds_qos_t *qos = wire_dds_qos(kind, side, stream, lease_ns);
    dds_entity_t e = side == WIRE_DDS_WRITER ? dds_create_writer(participant, topic, qos, NULL)
                                             : dds_create_reader(participant, topic, qos, NULL);
    dds_delete_qos(qos);
    must(e > 0, name);
    return e;
}

static void wait_matched(dds_entity_t e, wire_dds_side side)
{
    dds_publication_matched_status_t p = {0};
    dds_subscription_matched_status_t s = {0};
    for (int i = 0; i < 6000 && p.current_count == 0 && s.current_count == 0; i++) {
        if (side == WIRE_DDS_WRITER)
            dds_get_publication_matched_status(e, &p);
        else
            dds_get_subscription_matched_status(e, &s);
        usleep(5000);
    }
    must(p.current_count > 0 || s.current_count > 0, "nobody matched");
}

static dds_entity_t matched_writer(wire_kind kind, int64_t lease_ns)
{
    dds_entity_t w = endpoint(kind, WIRE_DDS_WRITER, NULL, lease_ns);
    wait_matched(w, WIRE_DDS_WRITER);
    return w;
}

static void put(dds_entity_t writer, const wire_message *m, bool disposing)
{
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    wire_dds_encode(m, sample);
    dds_return_t r = disposing ? dds_writedispose(writer, sample) : dds_write(writer, sample);
    free(sample);
    must(r == DDS_RETCODE_OK, wire_kind_name(m->kind));
}

static void dispose(dds_entity_t writer, const wire_message *m)
{
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    wire_dds_encode(m, sample);
    must(dds_dispose(writer, sample) == DDS_RETCODE_OK, "dispose");
    free(sample);
}

static bool get(dds_entity_t reader, wire_kind kind, void (*use)(const wire_message *m))
{
    void *samples[1] = {NULL};
    dds_sample_info_t infos[1];
    if (dds_take(reader, samples, infos, 1, 1) != 1) return false;
    wire_message m;
    wire_refusal why;
    bool valid = infos[0].valid_data;
    if (valid) must(wire_dds_decode(kind, samples[0], &m, &why) == WIRE_OK, why.text);
    if (valid) use(&m);
    dds_return_loan(reader, samples, 1);
    return valid;
}

static void compare(const wire_message *m)
{
    wire_message expected = sample_message(m->kind);
    say("%s %s", wire_kind_name(m->kind), same_message(m, &expected) ? "same" : "different");
}

static void tell_batch(const wire_message *m)
{
    say("%s batch %lld", m->event_batch.stream, (long long)m->event_batch.batch);
}

static void talk(void)
{
    dds_entity_t readers[WIRE_KIND_COUNT] = {0};
    for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++)
        readers[k] = endpoint(k, WIRE_DDS_READER, k == WIRE_EVENT_BATCH ? "cell" : NULL, 0);
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) {
        wire_message m = sample_message(k);
        put(matched_writer(k, 0), &m, false);
    }
    for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++) wait_matched(readers[k], WIRE_DDS_READER);
    say("sent");
    for (;; usleep(2000))
        for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++) get(readers[k], k, compare);
}

static void live(bool removing, bool disposing)
{
    wire_message client = sample_message(WIRE_CLIENT), body = sample_message(WIRE_BODY);
    dds_entity_t bodies = matched_writer(WIRE_BODY, 0);
    put(matched_writer(WIRE_CLIENT, client.client.lease_ns), &client, false);
    put(bodies, &body, false);
    say("sent");
    usleep(100000);
    body.body.removed = 1;
    body.body.sequence++;
    if (removing) put(bodies, &body, true);
    if (disposing) dispose(bodies, &body);
    for (;;) pause();
}

static void many(void)
{
    wire_message client = sample_message(WIRE_CLIENT), body = sample_message(WIRE_BODY);
    dds_entity_t bodies = matched_writer(WIRE_BODY, 0);
    put(matched_writer(WIRE_CLIENT, client.client.lease_ns), &client, false);
    for (body.body.body = 0; body.body.body < MANY_BODIES; body.body.body++) put(bodies, &body, false);
    (void)dds_wait_for_acks(bodies, DDS_SECS(30));
    say("sent");
    for (;;) pause();
}

static void listen_to(const char *stream)
{
    dds_entity_t r = endpoint(WIRE_EVENT_BATCH, WIRE_DDS_READER, stream, 0);
    wait_matched(r, WIRE_DDS_READER);
    say("matched");
    for (;; usleep(2000))
        while (get(r, WIRE_EVENT_BATCH, tell_batch)) continue;
}

static void flood(void)
{
    dds_entity_t w = matched_writer(WIRE_POSE_BATCH, 0);
    for (int64_t i = 1; i <= FLOOD_BATCHES; i++) {
        wire_message m = sample_poses(1000, i);
        put(w, &m, false);
    }
    (void)dds_wait_for_acks(w, DDS_SECS(30));
    say("sent");
    for (;;) pause();
}

/* Too many for one part; each number tells of which body it is. */
static void large(void)
{
    static int32_t bodies[LARGE_POSES];
    static double positions[3 * LARGE_POSES], turns[4 * LARGE_POSES], linear[3 * LARGE_POSES], angular[3 * LARGE_POSES];
    static uint8_t teleports[LARGE_POSES];
    wire_message m = sample_poses(1, 1);
    for (int32_t i = 0; i < LARGE_POSES; i++) {
        bodies[i] = i;
        for (int k = 0; k < 3; k++) positions[3 * i + k] = 3.0 * i + k;
        for (int k = 0; k < 3; k++) linear[3 * i + k] = -3.0 * i - k;
        for (int k = 0; k < 3; k++) angular[3 * i + k] = 0.5 * i + k;
        turns[4 * i + i % 4] = 1;
        teleports[i] = i % 3 == 0;
    }
    m.pose_batch.bodies = (wire_i32s){LARGE_POSES, bodies};
    m.pose_batch.positions = (wire_f64s){3 * LARGE_POSES, positions};
    m.pose_batch.orientations = (wire_f64s){4 * LARGE_POSES, turns};
    m.pose_batch.linear = (wire_f64s){3 * LARGE_POSES, linear};
    m.pose_batch.angular = (wire_f64s){3 * LARGE_POSES, angular};
    m.pose_batch.teleports = (wire_u8s){LARGE_POSES, teleports};
    m.pose_batch.step = 0;
    dds_entity_t w = matched_writer(WIRE_POSE_BATCH, 0);
    put(w, &m, false);
    m.pose_batch.step = m.pose_batch.sequence = LARGE_STEP;
    put(w, &m, false);
    say("sent");
    for (;;) pause();
}

/* Beside such a one, as another client. */
static void aside(void)
{
    dds_entity_t w = matched_writer(WIRE_POSE_BATCH, 0);
    wire_message m = sample_poses(3, ASIDE_SEQUENCE);
    m.pose_batch.client = CLIENT_ID + 1;
    put(w, &m, false);
    (void)dds_wait_for_acks(w, DDS_SECS(30));
    say("sent");
    for (;;) pause();
}

static void bad(void)
{
    double positions[3] = {INFINITY, 0, 0};
    wire_message m = sample_poses(1, 12);
    m.pose_batch.positions.at = positions;
    put(matched_writer(WIRE_POSE_BATCH, 0), &m, false);
    for (;;) pause();
}

int dds_client(int argc, char **argv)
{
    char config[4096];
    const char *role = argv[2];
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that fails leaves nobody behind */
    must(wire_dds_config(config, sizeof config, "", WIRE_DDS_ANYBODY), "configuration");
    must(dds_create_domain(CLIENT_DOMAIN, config) > 0, "domain");
    participant = dds_create_participant(CLIENT_DOMAIN, NULL, NULL);
    must(participant > 0, "participant");
    if (strcmp(role, "talk") == 0) talk();
    if (strcmp(role, "live") == 0) live(false, false);
    if (strcmp(role, "remove") == 0) live(true, false);
    if (strcmp(role, "dispose") == 0) live(false, true);
    if (strcmp(role, "flood") == 0) flood();
    if (strcmp(role, "aside") == 0) aside();
    if (strcmp(role, "large") == 0) large();
    if (strcmp(role, "many") == 0) many();
    if (strcmp(role, "bad") == 0) bad();
    if (strcmp(role, "listen") == 0 && argc > 3) listen_to(argv[3]);
    return EXIT_FAILURE;
}
