/* raw_ping: Cyclone's threads run the two listeners, which take, stamp and (in the echo) write at once: these writers
 * keep the last, so that they never wait. At most one ping is under way, and is known by its step. */
#include "raw_ping.h"

#include "wire/wire.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_qos.h"

#include <collided.h>
#include <dds/dds.h>
#include <errno.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

struct raw_ping {
    dds_entity_t domain, participant, writer, reader;
    collided_PoseBatch out; /* its arrays are ours */
    sem_t answered;
    atomic_int_least64_t step, arrived_ns;
};

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static dds_entity_t join(uint32_t domain, dds_entity_t *made)
{
    char config[4096];
    if (!wire_dds_config(config, sizeof config, "", WIRE_DDS_ANYBODY)) return -1;
    *made = dds_create_domain(domain, config);
    return dds_create_participant(domain, NULL, NULL);
}

static dds_entity_t topic(dds_entity_t participant, wire_kind kind)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    return dds_create_topic(participant, wire_dds_descriptor(kind), name, NULL, NULL);
}

static dds_entity_t writer(dds_entity_t participant, wire_kind kind)
{
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_WRITER, NULL, 0);
    dds_entity_t e = dds_create_writer(participant, topic(participant, kind), qos, NULL);
    dds_delete_qos(qos);
    return e;
}

static dds_entity_t reader(dds_entity_t participant, wire_kind kind, dds_on_data_available_fn on_data, void *context)
{
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_data_available_arg(listener, on_data, context, true);
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_READER, NULL, 0);
    dds_entity_t e = dds_create_reader(participant, topic(participant, kind), qos, listener);
    dds_delete_qos(qos);
    dds_delete_listener(listener);
    return e;
}

/* ---- the echo ---- */

static void answer(dds_entity_t from, void *to)
{
    void *sample = NULL;
    dds_sample_info_t info;
    while (dds_take(from, &sample, &info, 1, 1) == 1) {
        const collided_PoseBatch *ping = sample;
        collided_EventBatch pong = {.version = WIRE_VERSION, .stream = (char *)(uintptr_t) ""};
        if (info.valid_data && ping->stamp_ns >= 0) { /* below: one of a flood, that wants no answer */
            pong.step = ping->step;
            pong.latest_pose_ns = ping->stamp_ns;
            dds_write(*(const dds_entity_t *)to, &pong);
        }
        dds_return_loan(from, &sample, 1);
        sample = NULL;
    }
}

int raw_echo(uint32_t domain)
{
    dds_entity_t made, participant = join(domain, &made), out = writer(participant, WIRE_EVENT_BATCH);
    if (out <= 0 || reader(participant, WIRE_POSE_BATCH, answer, &out) <= 0) return 1;
    for (;;) pause();
}

/* ---- the ping ---- */

static void receive(dds_entity_t from, void *context)
{
    raw_ping *r = context;
    void *sample = NULL;
    dds_sample_info_t info;
    int64_t arrived_ns = now_ns();
    while (dds_take(from, &sample, &info, 1, 1) == 1) {
        if (info.valid_data && ((const collided_EventBatch *)sample)->step == atomic_load(&r->step)) {
            atomic_store(&r->arrived_ns, arrived_ns);
            sem_post(&r->answered);
        }
        dds_return_loan(from, &sample, 1);
        sample = NULL;
    }
}

static bool matched(const raw_ping *r)
{
    dds_publication_matched_status_t out = {0};
    dds_subscription_matched_status_t in = {0};
    for (int i = 0; i < 2000 && !(out.current_count && in.current_count); i++) {
        usleep(5000);
        if (dds_get_publication_matched_status(r->writer, &out) || dds_get_subscription_matched_status(r->reader, &in))
            return false;
    }
    return out.current_count && in.current_count;
}

static dds_sequence_double doubles(uint32_t count)
{
    return (dds_sequence_double){count, count, calloc(count, sizeof(double)), false};
}

raw_ping *raw_open(uint32_t domain, uint32_t poses)
{
    raw_ping *r = calloc(1, sizeof *r);
    if (!r) return NULL;
    sem_init(&r->answered, 0, 0);
    r->out = (collided_PoseBatch){.version = WIRE_VERSION,
        .client_id = 1,
        .bodies = {poses, poses, calloc(poses, sizeof(int32_t)), false},
        .positions = doubles(3 * poses),
        .orientations = doubles(4 * poses)};
    r->participant = join(domain, &r->domain);
    r->writer = writer(r->participant, WIRE_POSE_BATCH);
    r->reader = reader(r->participant, WIRE_EVENT_BATCH, receive, r);
    bool complete = r->out.bodies._buffer && r->out.positions._buffer && r->out.orientations._buffer;
    if (complete && matched(r)) return r;
    fprintf(stderr, "raw DDS: no echo was found\n");
    raw_close(r);
    return NULL;
}

int64_t raw_round_ns(raw_ping *r, int64_t timeout_ns)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    int64_t end_ns = (int64_t)until.tv_sec * 1000000000 + until.tv_nsec + timeout_ns;
    until = (struct timespec){end_ns / 1000000000, end_ns % 1000000000};
    while (sem_trywait(&r->answered) == 0) continue; /* one that came too late */
    r->out.step = atomic_fetch_add(&r->step, 1) + 1;
    int64_t began_ns = now_ns();
    if (dds_write(r->writer, &r->out) != DDS_RETCODE_OK) return -1;
    while (sem_timedwait(&r->answered, &until) != 0)
        if (errno != EINTR) return -1;
    return atomic_load(&r->arrived_ns) - began_ns;
}

/* Writes batches, of which the last of each group is answered, and waits for that, so that nothing is lost. */
int64_t raw_flood(raw_ping *r, double seconds, unsigned every)
{
    int64_t batches = 0, end_ns = now_ns() + (int64_t)(1e9 * seconds);
    while (sem_trywait(&r->answered) == 0) continue;
    while (now_ns() < end_ns) {
        for (unsigned i = 1; i <= every; i++, batches++) {
            r->out.stamp_ns = i < every ? -1 : 0;
            if (i == every) r->out.step = atomic_fetch_add(&r->step, 1) + 1;
            if (dds_write(r->writer, &r->out) != DDS_RETCODE_OK) return -1;
        }
        struct timespec until;
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_sec += 5;
        if (sem_timedwait(&r->answered, &until) != 0) return -1;
    }
    r->out.stamp_ns = 0;
    return batches;
}

void raw_close(raw_ping *r)
{
    if (!r) return;
    dds_delete(r->participant);
    if (r->domain > 0) dds_delete(r->domain);
    sem_destroy(&r->answered);
    free(r->out.bodies._buffer);
    free(r->out.positions._buffer);
    free(r->out.orientations._buffer);
    free(r);
}
