#include "cell.h"

#include "base/log.h"
#include "service/server.h"
#include "service/service.h"
#include "wire/one_shape.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

struct cell {
    server *server;
    pthread_t thread;
    int status;
};

static void *run(void *context)
{
    cell *c = context;
    c->status = server_run(c->server);
    return NULL;
}

config cell_config(void)
{
    config c;
    config_default(&c);
    c.workers = 1;
    c.status_period = 0.05;
    c.settle = 0;
    c.heartbeat = 3600; /* a test that waits long for nothing hears nothing */
    strcpy(c.links, "memory://cell");
    return c;
}

cell *cell_start(const config *options)
{
    char why[512] = "";
    cell *c = calloc(1, sizeof *c);
    log_setup(LOG_ERROR, 0);
    c->server = server_create(options, why, sizeof why);
    if (!c->server) fail_msg("%s", why);
    assert_int_equal(pthread_create(&c->thread, NULL, run, c), 0);
    return c;
}

int cell_stop(cell *c)
{
    server_stop(c->server);
    pthread_join(c->thread, NULL);
    int status = c->status;
    server_destroy(c->server);
    free(c);
    return status;
}

const struct measures *cell_measures(const cell *c)
{
    return &server_service(c->server)->measures;
}

double cell_processor_s(const cell *c)
{
    clockid_t clock;
    struct timespec t = {0};
    assert_int_equal(pthread_getcpuclockid(c->thread, &clock), 0);
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void cell_end_recording(cell *c)
{
    server_end_recording(c->server);
}

struct builds *cell_builds(const cell *c)
{
    return server_service(c->server)->builds;
}

int cell_replay(const char *path, long workers, bool caches)
{
    config c = cell_config();
    c.workers = workers;
    c.caches = caches;
    return cell_replay_as(path, c);
}

int cell_replay_as(const char *path, config c)
{
    char why[512] = "";
    snprintf(c.replay, sizeof c.replay, "%s", path);
    c.json = true;
    server *s = server_create(&c, why, sizeof why);
    if (!s) fail_msg("%s", why);
    int status = server_run(s);
    server_destroy(s);
    return status;
}

int cell_read(const char *path, void (*look)(void *context, const wire_log_entry *e), void *context)
{
    char why[256] = "";
    int ticks = 0;
    wire_log_entry e;
    wire_log_reader *r = wire_log_open(path, why, sizeof why);
    if (!r) fail_msg("%s", why);
    while (wire_log_next(r, &e, NULL, why, sizeof why) == 1) {
        ticks += e.kind == WIRE_LOG_TICK;
        look(context, &e);
    }
    wire_log_end(r);
    assert_string_equal(why, "");
    return ticks;
}

memory_end *cell_client(const cell *c)
{
    (void)c;
    memory_end *e = memory_connect("cell");
    assert_non_null(e);
    return e;
}

enum { PATIENCE_MS = 30000 };

bool cell_next(memory_end *e, wire_memory *memory, wire_kind kind, int ms, wire_message *out)
{
    for (int waited = 0; waited <= ms;) {
        wire_memory_reset(memory);
        if (!memory_receive(e, memory, out)) {
            nanosleep(&(struct timespec){0, 1000000}, NULL);
            waited++;
        } else if (out->kind == kind) {
            return true;
        }
    }
    return false;
}

wire_message cell_await(memory_end *e, wire_memory *memory, wire_kind kind)
{
    wire_message m;
    while (kind == WIRE_STATUS && memory_receive(e, memory, &m)) wire_memory_reset(memory);
    if (!cell_next(e, memory, kind, PATIENCE_MS, &m)) fail_msg("no %s within 30 s", wire_kind_name(kind));
    return m;
}

bool cell_hears(memory_end *e, wire_memory *memory, wire_kind kind, int ms)
{
    wire_message m;
    return cell_next(e, memory, kind, ms, &m);
}

void cell_settle(memory_end *e, wire_memory *memory, int64_t client, int64_t sequence)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .kind = WIRE_QUERY_BODIES,
            .name_a = "*",
            .name_b = ""}};
    memory_send(e, &q);
    cell_await(e, memory, WIRE_ANSWER);
}

void cell_hello(memory_end *e, int64_t client, int64_t sequence, double lease_s, uint8_t on_loss)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .on_loss = on_loss,
            .lease_ns = (int64_t)(lease_s * 1e9),
            .name = "test"}};
    memory_send(e, &m);
}

void cell_sphere(memory_end *e, int64_t client, int64_t sequence, int32_t body, const char *name, double x)
{
    one_shape s = one_shape_at(WIRE_SHAPE_SPHERE, x);
    s.radius[0] = 1;
    wire_message m = one_shape_body(&s, client, sequence, body, name);
    memory_send(e, &m);
}

void cell_body_of(memory_end *e, int64_t client, int64_t sequence, int32_t body, const char *name, uint8_t type,
    int64_t hash, double x)
{
    one_shape s = one_shape_at(type, x);
    s.geometry[0] = hash;
    wire_message m = one_shape_body(&s, client, sequence, body, name);
    memory_send(e, &m);
}

void cell_pose(memory_end *e, int64_t client, int64_t sequence, int32_t body, double x)
{
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(e, &m);
}

void cell_touches(memory_end *e, int64_t client, int64_t sequence, int32_t subscription)
{
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .subscription = subscription,
            .facts = WIRE_FACT_TOUCH,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-9}};
    memory_send(e, &m);
}

int64_t cell_counter(const wire_status *s, const char *name)
{
    for (uint32_t i = 0; i < s->counter_names.count; i++)
        if (strcmp(s->counter_names.at[i], name) == 0) return s->counter_values.at[i];
    fail_msg("status has no counter \"%s\"", name);
    return -1;
}
