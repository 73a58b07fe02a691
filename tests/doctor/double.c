/* double: what a real daemon of this release never is: of another wire, with another clock, of another release. As a
 * daemon it goes by the name "collided" among the processes and takes the same --links; what is wrong with it stands in
 * the environment:
 *
 *   DOUBLE_VERSION=2    of the wire        DOUBLE_CLOCK=S       ahead by so many seconds, until SIGUSR1
 *   DOUBLE_TYPE=1       another DDS type   DOUBLE_FINGERPRINT=1 another LCM fingerprint
 *   DOUBLE_RELEASE=TEXT                    DOUBLE_STARTING=1    not ready until SIGUSR1
 *
 * "double bad URI" is a client that moves bodies that it never announced; "double holder URI LOSS" one that has a body
 * and waits. Two threads over LCM (liblcm's), otherwise Cyclone's beside the one that polls. */
#include <collided.h>

#include "wire/wire_lcm.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <lcm/lcm.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

enum { STATUS_EVERY = 40, POLL_US = 5000 };

typedef struct costume {
    int version;
    double clock_s;
    const char *release;
    bool type, fingerprint, starting;
    int64_t epoch;
    char name[128];
} costume;

static atomic_bool mended; /* SIGUSR1 has come */

static void on_usr1(int number)
{
    (void)number;
    atomic_store(&mended, true);
}

static int64_t wall_ns(const costume *c)
{
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    double ahead = atomic_load(&mended) ? 0 : c->clock_s;
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec + (int64_t)(ahead * 1e9);
}

static wire_message status_of(const costume *c)
{
    return (wire_message){.kind = WIRE_STATUS,
        .status = {.version = c->version,
            .epoch = c->epoch,
            .health = c->starting && !atomic_load(&mended) ? WIRE_HEALTH_STARTING : WIRE_HEALTH_READY,
            .daemon = c->name,
            .release = c->release,
            .links = "a double",
            .limits = "",
            .stamp_ns = wall_ns(c),
            .started_ns = c->epoch}};
}

static wire_message answer_to(const costume *c, const wire_query *q)
{
    return (wire_message){.kind = WIRE_ANSWER,
        .answer = {.version = c->version,
            .client = q->client,
            .sequence = q->sequence,
            .epoch = c->epoch,
            .stamp_ns = wall_ns(c),
            .kind = q->kind,
            .text = ""}};
}

/* ---- over DDS ---- */

static dds_entity_t endpoint(dds_entity_t participant, wire_kind kind, wire_kind type, wire_dds_side side)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    dds_entity_t topic = dds_create_topic(participant, wire_dds_descriptor(type), name, NULL, NULL);
    dds_qos_t *qos = wire_dds_qos(kind, side, NULL, 0);
    dds_entity_t made = side == WIRE_DDS_WRITER ? dds_create_writer(participant, topic, qos, NULL)
                                                : dds_create_reader(participant, topic, qos, NULL);
    dds_delete_qos(qos);
    return made;
}

static void dds_write_message(dds_entity_t writer, const wire_message *m)
{
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    wire_dds_encode(m, sample);
    dds_write(writer, sample);
    free(sample);
}

static void dds_answer(const costume *c, dds_entity_t queries, dds_entity_t answers)
{
    void *samples[1] = {NULL};
    dds_sample_info_t infos[1];
    while (dds_take(queries, samples, infos, 1, 1) == 1) {
        wire_message m;
        wire_refusal why;
        bool asked = infos[0].valid_data && wire_dds_decode(WIRE_QUERY, samples[0], &m, &why) == WIRE_OK;
        wire_message a = answer_to(c, &m.query);
        dds_return_loan(queries, samples, 1);
        if (asked) dds_write_message(answers, &a);
    }
}

static _Noreturn void serve_dds(const costume *c, unsigned domain)
{
    char config[4096];
    wire_dds_config(config, sizeof config, NULL, WIRE_DDS_ANYBODY);
    dds_create_domain(domain, config);
    dds_entity_t p = dds_create_participant(domain, NULL, NULL);
    dds_entity_t statuses = endpoint(p, WIRE_STATUS, c->type ? WIRE_REJECT : WIRE_STATUS, WIRE_DDS_WRITER);
    dds_entity_t answers = endpoint(p, WIRE_ANSWER, WIRE_ANSWER, WIRE_DDS_WRITER);
    dds_entity_t queries = endpoint(p, WIRE_QUERY, WIRE_QUERY, WIRE_DDS_READER);
    for (unsigned round = 0;; round++) {
        wire_message m = status_of(c);
        if (round % STATUS_EVERY == 0 && !c->type) dds_write_message(statuses, &m);
        dds_answer(c, queries, answers);
        usleep(POLL_US);
    }
}

/* ---- over LCM ---- */

typedef struct lcm_side {
    const costume *costume;
    lcm_t *lcm;
} lcm_side;

static void lcm_write_message(const lcm_side *s, const wire_message *m)
{
    unsigned char bytes[8192];
    char channel[WIRE_CHANNEL_MAX];
    size_t size = wire_lcm_encode(m, bytes, sizeof bytes);
    if (s->costume->fingerprint) bytes[0] ^= 1;
    wire_lcm_channel(m, channel);
    lcm_publish(s->lcm, channel, bytes, (unsigned)size);
}

static void on_query(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    const lcm_side *s = context;
    wire_memory *memory = wire_memory_create();
    wire_message m;
    wire_refusal why;
    (void)channel;
    if (wire_lcm_decode(buffer->data, buffer->data_size, memory, &m, &why) == WIRE_OK) {
        wire_message a = answer_to(s->costume, &m.query);
        lcm_write_message(s, &a);
    }
    wire_memory_destroy(memory);
}

static _Noreturn void serve_lcm(const costume *c)
{
    lcm_side s = {c, lcm_create("udpm://239.255.76.67:7667?ttl=0")};
    lcm_subscribe(s.lcm, "collided\\.in\\.Query", on_query, &s);
    for (unsigned round = 0;; round++) {
        wire_message m = status_of(c);
        if (round % STATUS_EVERY == 0) lcm_write_message(&s, &m);
        lcm_handle_timeout(s.lcm, POLL_US / 1000);
    }
}

/* ---- clients ---- */

static collided_body box(collided *c, const char *name)
{
    collided_shape shape = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &shape;
    def.shape_count = 1;
    return collided_create_body(c, &def);
}

static int hold(const char *uri, const char *loss)
{
    collided_def def = collided_def_default();
    def.on_loss = strcmp(loss, "keep") == 0 ? COLLIDED_KEEP : COLLIDED_HOLD;
    def.lease_s = 0.3;
    def.connect_timeout_s = 30;
    collided *c = collided_connect(uri, &def);
    if (!c || box(c, "held").id == COLLIDED_NONE || collided_sync(c, 30) != COLLIDED_OK) return 1;
    puts("here");
    fflush(stdout);
    for (;;) collided_poll(c, 1);
}

static int behave_badly(const char *uri)
{
    collided_def def = collided_def_default();
    def.connect_timeout_s = 30;
    collided *c = collided_connect(uri, &def);
    if (!c) return 1;
    puts("here");
    fflush(stdout);
    for (collided_body nobody = collided_adopt_body(c, 7);;) {
        collided_move(c, nobody, collided_pose_identity());
        collided_poll(c, 0.02);
    }
}

/* ---- which ---- */

static const char *said(const char *name, const char *otherwise)
{
    const char *value = getenv(name);
    return value ? value : otherwise;
}

int main(int argc, char **argv)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (argc == 3 && strcmp(argv[1], "bad") == 0) return behave_badly(argv[2]);
    if (argc == 4 && strcmp(argv[1], "holder") == 0) return hold(argv[2], argv[3]);
    if (argc != 3 || strcmp(argv[1], "--links") != 0) return 64;
    costume c = {.version = atoi(said("DOUBLE_VERSION", "1")),
        .clock_s = atof(said("DOUBLE_CLOCK", "0")),
        .release = said("DOUBLE_RELEASE", collided_version()),
        .type = getenv("DOUBLE_TYPE") != NULL,
        .fingerprint = getenv("DOUBLE_FINGERPRINT") != NULL,
        .starting = getenv("DOUBLE_STARTING") != NULL};
    char host[64] = "";
    gethostname(host, sizeof host - 1);
    snprintf(c.name, sizeof c.name, "%s:%d", host, (int)getpid());
    c.epoch = wall_ns(&(costume){0});
    signal(SIGUSR1, on_usr1);
    prctl(PR_SET_NAME, "collided");
    puts("here");
    fflush(stdout);
    if (strncmp(argv[2], "dds://", 6) == 0) serve_dds(&c, (unsigned)atoi(argv[2] + 6));
    serve_lcm(&c);
}
