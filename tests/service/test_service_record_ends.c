/* How recordings end that nobody ends, and how one begins in a large world: a limit is named, what is there replays,
 * and no tick waits. */
#include "cell.h"
#include "service/recordings.h"

#include "service/server.h"
#include "service/service.h"
#include "service/shares.h"

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <time.h>
#include <unistd.h>

enum { ALICE = 11, BOB = 12, MANY = 6000 };

static char folder[] = "/tmp/collided-ends-XXXXXX";
static int64_t sequence;

static wire_answer wish(memory_end *e, wire_memory *memory, int64_t client, const char *name)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++sequence,
            .kind = WIRE_QUERY_RECORD,
            .name_a = name,
            .name_b = ""}};
    memory_send(e, &q);
    return cell_await(e, memory, WIRE_ANSWER).answer;
}

static void announce(memory_end *e, int count)
{
    cell_hello(e, ALICE, ++sequence, 60, WIRE_LOST_REMOVE);
    for (int i = 0; i < count; i++) {
        char name[16];
        snprintf(name, sizeof name, "ball%d", i);
        cell_sphere(e, ALICE, ++sequence, i, name, 1.5 * i);
    }
    cell_touches(e, ALICE, ++sequence, 0);
}

static config recording_config(void)
{
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    c.record_keep_free = 0;
    return c;
}

static int replay_and_remove(const char *name)
{
    char path[sizeof folder + 64];
    snprintf(path, sizeof path, "%s/%s.lcmlog", folder, name);
    int status = cell_replay(path, 1, true);
    assert_int_equal(unlink(path), 0);
    return status;
}

/* A Status whose limits name that option. */
static void await_limit(memory_end *e, wire_memory *memory, const char *option, int64_t failures)
{
    for (int tries = 0; tries < 600; tries++) {
        wire_status s = cell_await(e, memory, WIRE_STATUS).status;
        if (!strstr(s.limits, option)) continue;
        assert_int_equal(s.health, WIRE_HEALTH_DEGRADED);
        assert_int_equal(cell_counter(&s, "record_failures"), failures);
        return;
    }
    fail_msg("Status names no %s", option);
}

typedef struct scene { /* bodies of ALICE's, and a recording of hers */
    cell *daemon;
    memory_end *end;
    wire_memory *memory;
    const char *name;
} scene;

static scene begin_scene(const config *c, int bodies, const char *name)
{
    scene h = {.daemon = cell_start(c), .memory = wire_memory_create(), .name = name};
    h.end = cell_client(h.daemon);
    announce(h.end, bodies);
    assert_int_equal(wish(h.end, h.memory, ALICE, name).status, WIRE_ANSWER_OK);
    return h;
}

static void end_scene(scene *h)
{
    memory_disconnect(h->end);
    wire_memory_destroy(h->memory);
    assert_int_equal(cell_stop(h->daemon), 0);
    assert_int_equal(replay_and_remove(h->name), EX_OK);
}

static void a_recording_that_is_too_large_ends_behind_a_tick(void **state)
{
    (void)state;
    config c = recording_config();
    c.record_max_size = 1;
    scene h = begin_scene(&c, 50, "large");
    for (int i = 0; i < 8000; i++) {
        cell_pose(h.end, ALICE, ++sequence, i % 50, 1.5 * (i % 50) + 0.6 * sin(i));
        if (i % 20 == 0) cell_settle(h.end, h.memory, ALICE, ++sequence);
    }
    await_limit(h.end, h.memory, "record_max_size", 1);
    end_scene(&h);
}

static void a_recording_that_a_client_began_ends_in_time(void **state)
{
    (void)state;
    config c = recording_config();
    c.record_max_time = 0.3;
    scene h = begin_scene(&c, 3, "long");
    assert_int_equal(wish(h.end, h.memory, BOB, "").status, WIRE_ANSWER_UNSUPPORTED);
    await_limit(h.end, h.memory, "record_max_time", 0);
    assert_int_equal(wish(h.end, h.memory, BOB, "").status, WIRE_ANSWER_UNSUPPORTED); /* there is none any more */
    end_scene(&h);
}

static void only_so_many_are_begun_and_only_where_there_is_room(void **state)
{
    (void)state;
    config c = recording_config();
    c.record_max_files = 1;
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    announce(e, 3);
    assert_int_equal(wish(e, memory, ALICE, "first").status, WIRE_ANSWER_OK);
    cell_settle(e, memory, ALICE, ++sequence);
    assert_int_equal(wish(e, memory, ALICE, "").status, WIRE_ANSWER_OK);
    wire_answer a = wish(e, memory, ALICE, "second");
    assert_int_equal(a.status, WIRE_ANSWER_UNSUPPORTED);
    assert_non_null(strstr(a.text, "record_max_files"));
    assert_int_equal(wish(e, memory, ALICE, "..").status, WIRE_ANSWER_UNSUPPORTED);
    assert_int_equal(wish(e, memory, ALICE, "a/b").status, WIRE_ANSWER_UNSUPPORTED);
    memory_disconnect(e);
    assert_int_equal(cell_stop(daemon), 0);
    assert_int_equal(replay_and_remove("first"), EX_OK);
    c.record_keep_free = 100;
    daemon = cell_start(&c);
    e = cell_client(daemon);
    a = wish(e, memory, ALICE, "third");
    assert_int_equal(a.status, WIRE_ANSWER_UNSUPPORTED);
    assert_non_null(strstr(a.text, "record_keep_free"));
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(daemon), 0);
}

/* Its state is larger than what is written within the tick of the query. */
static void a_large_world_is_recorded_from_its_middle(void **state)
{
    (void)state;
    config c = recording_config();
    c.max_client_messages = 100000000;
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    announce(e, MANY);
    cell_settle(e, memory, ALICE, ++sequence);
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < MANY; i += 3) cell_pose(e, ALICE, ++sequence, i, 1.5 * i + 0.7 * (1 - round));
        if (round == 0) assert_int_equal(wish(e, memory, ALICE, "middle").status, WIRE_ANSWER_OK);
        cell_settle(e, memory, ALICE, ++sequence);
    }
    assert_int_equal(wish(e, memory, ALICE, "").status, WIRE_ANSWER_OK);
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(replay_and_remove("middle"), EX_OK); /* whole, although the daemon still runs */
    assert_int_equal(cell_stop(daemon), 0);
}

/* ---- what a tick spends on it ---- */

static double spent_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

static void tell(server *v, const wire_message *m)
{
    link_sink sink = server_sink(v);
    sink.message(sink.context, server_service(v)->links[0], m);
}

/* Spheres in rows, each of which touches the one before it. */
static void fill(server *v, int count)
{
    const uint8_t type = WIRE_SHAPE_SPHERE;
    const double none[3] = {0}, half = 0.5, here[7] = {0, 0, 0, 1, 0, 0, 0};
    const int64_t geometry = 0;
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++sequence,
            .facts = WIRE_FACT_TOUCH,
            .stream = "all",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-3}};
    tell(v, &m);
    for (int i = 0; i < count; i++) {
        char name[32];
        const double at[7] = {0.99 * (i % 100), 1.5 * (i / 100 % 100), 1.5 * (i / 10000), 1, 0, 0, 0};
        snprintf(name, sizeof name, "ball%d", i);
        m = (wire_message){.kind = WIRE_BODY,
            .body = {.version = WIRE_VERSION,
                .client = ALICE,
                .sequence = ++sequence,
                .body = i,
                .motion = WIRE_MOTION_MOVING,
                .name = name,
                .group = "",
                .category = 1,
                .mask = -1,
                .pose = {7, at},
                .shape_types = {1, &type},
                .shape_sizes = {3, none},
                .shape_radii = {1, &half},
                .shape_deviations = {1, none},
                .shape_poses = {7, here},
                .shape_geometries = {1, &geometry}}};
        tell(v, &m);
        service *s = server_service(v);
        if (i % 1000 == 999 || i == count - 1) s->tick++, service_tick(s);
    }
}

/* By the time of the processor, so that what else the machine has to do does not count. *telling: of those in which
 * what is there is told, before the one that takes the state. */
static double dearest_tick_ms(service *s, const char *path, double *telling)
{
    char why[512] = "";
    const int64_t alice = ALICE;
    double began = spent_ms(), most, took;
    if (record_start(s, path, &alice, why, sizeof why) != 0) fail_msg("%s", why);
    most = *telling = spent_ms() - began;
    for (int i = 0; i < 100000 && (i == 0 || record_wants_tick(s)); i++) {
        if (s->record_next) nanosleep(&(struct timespec){0, 1000000}, NULL);
        began = spent_ms();
        record_tick(s);
        took = spent_ms() - began;
        most = fmax(most, took);
        if (record_wants_tick(s)) *telling = fmax(*telling, took);
    }
    assert_false(record_wants_tick(s));
    record_stop_now(s);
    return most;
}

static void no_tick_is_held_by_the_beginning(void **state)
{
    (void)state;
    char why[512] = "", path[sizeof folder + 32];
    bool nightly = getenv("COLLIDED_NIGHTLY") != NULL;
    config c = recording_config();
    server *v = server_create(&c, why, sizeof why);
    if (!v) fail_msg("%s", why);
    snprintf(path, sizeof path, "%s/held.lcmlog", folder);
    service *s = server_service(v);
    fill(v, nightly ? 100000 : 40000);
    size_t bodies = nightly ? 100000 : 40000;
    for (int i = 0; i < 10000 && (world_get_figures(s->world).bodies < bodies || service_is_behind(s)); i++) {
        s->monotonic_ns += 1000000; /* what has to wait for its share of work comes, and what pairs have to wait */
        shares_release(s);
        s->tick++;
        service_tick(s);
    }
    assert_true(world_get_figures(s->world).contacts > 9000);
    double least = INFINITY, least_telling = INFINITY, telling; /* of three: caches are shared with others, too */
    for (int i = 0; i < 3; i++) {
        least = fmin(least, dearest_tick_ms(s, path, &telling));
        least_telling = fmin(least_telling, telling);
        assert_int_equal(cell_replay(path, 1, true), EX_OK);
        assert_int_equal(unlink(path), 0);
    }
    printf("%g ms of a tick, at most; telling %g ms\n", least, least_telling);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    assert_true(least < (nightly ? 50 : 20));
    assert_true(least_telling < 12);
#endif
    server_destroy(v);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_recording_that_is_too_large_ends_behind_a_tick),
        cmocka_unit_test(a_recording_that_a_client_began_ends_in_time),
        cmocka_unit_test(only_so_many_are_begun_and_only_where_there_is_room),
        cmocka_unit_test(a_large_world_is_recorded_from_its_middle),
        cmocka_unit_test(no_tick_is_held_by_the_beginning),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
