/* What one client may send that once cost the daemon seconds of its processor, in one tick: each costs little now.
 * Measured is the time that the tick thread had of a processor, since the machine may have other things to do. */
#include "cell.h"

#include "service/builds.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

enum { ALICE = 1, SENT_AT_ONCE = 128 };

typedef struct room {
    cell *cell;
    memory_end *end;
    wire_memory *memory;
    int64_t sequence;
    int sent;
} room;

static void room_open(room *r)
{
    config c = cell_config();
    *r = (room){.cell = cell_start(&c), .memory = wire_memory_create()};
    r->end = cell_client(r->cell);
    cell_hello(r->end, ALICE, ++r->sequence, 600, WIRE_LOST_REMOVE);
}

static void room_close(room *r)
{
    memory_disconnect(r->end);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

/* Not all at once: how much is received in a round is not what this is about. What came meanwhile is dropped. */
static void pause_after_some(room *r)
{
    wire_message m;
    if (++r->sent % SENT_AT_ONCE) return;
    usleep(1000);
    do wire_memory_reset(r->memory);
    while (memory_receive(r->end, r->memory, &m));
}

static void settle(room *r)
{
    cell_settle(r->end, r->memory, ALICE, ++r->sequence);
}

/* Within which nothing took that long: a sanitizer is some ten times as slow. */
static void assert_cheap(const room *r, double began_s, double most_s)
{
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    most_s *= 20;
#endif
    double took_s = cell_processor_s(r->cell) - began_s;
    if (took_s > most_s) fail_msg("%.3f s of a processor, and not %.3f s at most", took_s, most_s);
}

static void take_back(room *r, int64_t client, int64_t hash)
{
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .removed = 1,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .pieces = 1}};
    memory_send(r->end, &m);
    pause_after_some(r);
}

/* A client's session remembers some thousands of them, against late copies, and a participant may be many clients. */
static void what_was_taken_back_by_many_costs_nobody(void **state)
{
    (void)state;
    enum { CLIENTS = 40, KEPT = 4000, MORE = 4000 };
    room r;
    room_open(&r);
    for (int c = 1; c <= CLIENTS; c++)
        for (int i = 1; i <= KEPT; i++) take_back(&r, 10 * ALICE + c, i);
    settle(&r);
    double began_s = cell_processor_s(r.cell);
    for (int i = 1; i <= MORE; i++) take_back(&r, ALICE, i);
    settle(&r);
    assert_cheap(&r, began_s, 0.5);
    room_close(&r);
}

/* ---- bodies that wait ---- */

enum { CLOUD = 200 };

/* Points on a sphere: so many that their hull is built beside the tick. */
static int64_t send_hull(room *r)
{
    double at[3 * CLOUD];
    uint64_t random = 88172645463325252u;
    for (int i = 0; i < 3 * CLOUD; i++) {
        random ^= random << 13, random ^= random >> 7, random ^= random << 17;
        at[i] = (double)(random >> 11) * 0x1p-53;
    }
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_HULL,
            .vertex_numbers = 3 * CLOUD,
            .pieces = 1,
            .vertices = {3 * CLOUD, at}}};
    m.geometry.hash = wire_geometry_hash(m.geometry.kind, m.geometry.vertices, m.geometry.indices);
    memory_send(r->end, &m);
    return m.geometry.hash;
}

static void send_body(room *r, int32_t body, int64_t hash)
{
    char name[32];
    snprintf(name, sizeof name, "body %d", (int)body);
    cell_body_of(r->end, ALICE, ++r->sequence, body, name, WIRE_SHAPE_HULL, hash, 3.0 * body);
    pause_after_some(r);
}

static void hold(void *context, int64_t id)
{
    (void)id;
    for (const atomic_bool *held = context; atomic_load(held);) usleep(1000);
}

static int64_t counter(room *r, const char *name)
{
    cell_await(r->end, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->end, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static void until(room *r, const char *name, int64_t value)
{
    for (int i = 0; i < 600 && counter(r, name) != value; i++) {
    }
    assert_int_equal(counter(r, name), value);
}

static int64_t open_with_waiting(room *r, atomic_bool *held, int32_t bodies)
{
    room_open(r);
    atomic_store(held, true);
    builds_hold(cell_builds(r->cell), hold, held);
    int64_t hash = send_hull(r);
    for (int32_t i = 0; i < bodies; i++) send_body(r, i, hash);
    settle(r);
    until(r, "pending_bodies", bodies);
    return hash;
}

static void bodies_that_wait_are_announced_again(void **state)
{
    (void)state;
    enum { BODIES = 30000, AGAIN = 10000 };
    room r;
    atomic_bool held;
    int64_t hash = open_with_waiting(&r, &held, BODIES);
    double began_s = cell_processor_s(r.cell);
    for (int32_t i = 0; i < AGAIN; i++) send_body(&r, i, hash);
    settle(&r);
    assert_cheap(&r, began_s, 0.6);
    assert_int_equal(counter(&r, "pending_bodies"), BODIES);
    for (int i = 1; i < 1000; i++) take_back(&r, ALICE, i); /* what nobody knows, while they wait */
    settle(&r);
    assert_cheap(&r, began_s, 0.7);
    atomic_store(&held, false);
    until(&r, "bodies", BODIES);
    assert_int_equal(counter(&r, "pending_bodies"), 0);
    room_close(&r);
}

/* They come in some ticks, and not in one that takes as long as all of them do. */
static void many_bodies_of_one_geometry_come_in_slices(void **state)
{
    (void)state;
    enum { BODIES = 30000, LEAST_TICKS = 10 };
    room r;
    atomic_bool held;
    open_with_waiting(&r, &held, BODIES);
    int64_t ticks = counter(&r, "ticks");
    atomic_store(&held, false);
    until(&r, "bodies", BODIES);
    assert_true(counter(&r, "ticks") - ticks >= LEAST_TICKS);
    assert_int_equal(counter(&r, "pending_bodies"), 0);
    room_close(&r);
}

/* ---- words of a client ---- */

static void put_spheres(room *r, int32_t count)
{
    for (int32_t i = 0; i < count; i++) {
        char name[32];
        snprintf(name, sizeof name, "sphere %d", (int)i);
        cell_sphere(r->end, ALICE, ++r->sequence, i, name, 3.0 * i);
        pause_after_some(r);
    }
    settle(r);
    until(r, "bodies", count);
}

/* Each is answered by the newest number of all that the client has: they come in turns, as far as its purse goes. */
static void old_words_of_a_client_with_many_bodies(void **state)
{
    (void)state;
    enum { BODIES = 60000, WORDS = 4000, LEAST_TICKS = 40 }; /* 0.2 s at the least, 20 ms a tick at most */
    room r;
    room_open(&r);
    put_spheres(&r, BODIES);
    cell_hello(r.end, ALICE, ++r.sequence, 600, WIRE_LOST_REMOVE);
    settle(&r);
    int64_t ticks = counter(&r, "ticks"), waited = counter(&r, "commands_waited");
    for (int i = 0; i < WORDS; i++) {
        cell_hello(r.end, ALICE, 1, 600, WIRE_LOST_REMOVE);
        pause_after_some(&r);
    }
    settle(&r);
    assert_true(counter(&r, "commands_waited") > waited);
    assert_true(counter(&r, "ticks") - ticks >= LEAST_TICKS);
    room_close(&r);
}

/* ---- queries ---- */

static void ask(room *r, uint8_t kind, const char *name)
{
    const double linear[3] = {10, 1, 0.5}, angular[3] = {1, 20, 3};
    bool sweeps = kind == WIRE_QUERY_SWEEP;
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = kind,
            .name_a = name,
            .name_b = sweeps ? "" : name,
            .linear = {sweeps ? 3 : 0, linear},
            .angular = {sweeps ? 3 : 0, angular},
            .span_s = sweeps ? 3600 : 0,
            .tolerance_m = 1e-9}};
    memory_send(r->end, &q);
}

/* Now and then one takes all the time that answers have in a tick: those that come behind it are put back. */
static void queries_are_put_back_before_many_that_wait(void **state)
{
    (void)state;
    enum { QUERIES = 400000, ONE_IS_LONG = 2500 };
    room r;
    room_open(&r);
    for (int32_t i = 0; i < 1000; i++) {
        char name[32];
        snprintf(name, sizeof name, "sphere %d", (int)i);
        cell_sphere(r.end, ALICE, ++r.sequence, i, name, 1.5 * (i % 40));
    }
    settle(&r);
    double began_s = cell_processor_s(r.cell);
    for (int i = 1; i <= QUERIES; i++)
        ask(&r, i % ONE_IS_LONG ? WIRE_QUERY_DISTANCE : WIRE_QUERY_SWEEP, i % ONE_IS_LONG ? "nobody" : "sphere 0");
    until(&r, "waiting_messages", 0);
    if (counter(&r, "queries_deferred") < 50)
        print_message("few were put back: this machine is quick, or nothing else runs\n");
    assert_cheap(&r, began_s, 4.5);
    room_close(&r);
}

/* ---- recordings ---- */

static void begin_mesh(room *r, int64_t hash)
{
    static double piece[WIRE_PIECE_MAX];
    enum { VERTICES = 3 << 21, INDICES = 3 * 3000000, ALL = VERTICES + INDICES };
    const wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_MESH,
            .hash = hash,
            .vertex_numbers = VERTICES,
            .index_numbers = INDICES,
            .pieces = (ALL + WIRE_PIECE_MAX - 1) / WIRE_PIECE_MAX,
            .vertices = {WIRE_PIECE_MAX, piece}}};
    memory_send(r->end, &m);
}

/* The first pieces of meshes as large as they may be: what a recording that begins then holds of them is not copied in
 * a tick. It ends, since it is larger than it may be, before anything of it is written. */
static void a_recording_begins_while_large_meshes_come(void **state)
{
    (void)state;
    enum { MESHES = 8 };
    char folder[] = "/tmp/collided-hostile-XXXXXX", path[64];
    config c = cell_config();
    assert_non_null(mkdtemp(folder));
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    snprintf(path, sizeof path, "%s/large.lcmlog", folder);
    c.record_max_size = 64;
    c.record_keep_free = 0;
    room r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.end = cell_client(r.cell);
    cell_hello(r.end, ALICE, ++r.sequence, 600, WIRE_LOST_REMOVE);
    for (int i = 1; i <= MESHES; i++) begin_mesh(&r, i);
    settle(&r);
    assert_int_equal(counter(&r, "geometries"), MESHES);
    double began_s = cell_processor_s(r.cell);
    const wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r.sequence,
            .kind = WIRE_QUERY_RECORD,
            .name_a = "large",
            .name_b = ""}};
    memory_send(r.end, &q);
    until(&r, "record_failures", 1);
    assert_cheap(&r, began_s, 0.15);
    room_close(&r);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_taken_back_by_many_costs_nobody),
        cmocka_unit_test(bodies_that_wait_are_announced_again),
        cmocka_unit_test(many_bodies_of_one_geometry_come_in_slices),
        cmocka_unit_test(queries_are_put_back_before_many_that_wait),
        cmocka_unit_test(old_words_of_a_client_with_many_bodies),
        cmocka_unit_test(a_recording_begins_while_large_meshes_come),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
