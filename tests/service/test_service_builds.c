/* Geometry is built beside the tick: what waits for it waits alone, keeps its order, and is there in one tick; a replay
 * does the same, however long the build took. A gate before each build makes them as slow as a test needs. */
#include "cell.h"

#include "service/builds.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { SLOW = 11, OTHER = 22, SIDE = 12, NUMBERS = WIRE_FIELD_HEAD + SIDE * SIDE };

static char folder[] = "/tmp/collided-builds-XXXXXX";

/* ---- the gate ---- */

static struct {
    pthread_mutex_t lock;
    pthread_cond_t moved;
    bool open;
    int64_t ids[64]; /* of the builds that have come to it */
    size_t count;
} gate = {.lock = PTHREAD_MUTEX_INITIALIZER, .moved = PTHREAD_COND_INITIALIZER};

static void at_gate(void *context, int64_t id)
{
    (void)context;
    pthread_mutex_lock(&gate.lock);
    if (gate.count < 64) gate.ids[gate.count++] = id;
    while (!gate.open) pthread_cond_wait(&gate.moved, &gate.lock);
    pthread_mutex_unlock(&gate.lock);
}

static void set_gate(bool open)
{
    pthread_mutex_lock(&gate.lock);
    gate.open = open;
    pthread_cond_broadcast(&gate.moved);
    pthread_mutex_unlock(&gate.lock);
}

/* ---- the room ---- */

typedef struct room {
    cell *cell;
    memory_end *slow, *other;
    wire_memory *memory;
    int64_t sequence;
    char path[64];
} room;

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    if (!mkdtemp(strcpy(folder, "/tmp/collided-builds-XXXXXX"))) return -1;
    r = (room){.memory = wire_memory_create(), .sequence = 10};
    snprintf(r.path, sizeof r.path, "%s/all.lcmlog", folder);
    snprintf(c.record, sizeof c.record, "%s", r.path);
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    c.max_client_bodies = 40;
    gate.open = false;
    gate.count = 0;
    r.cell = cell_start(&c);
    builds_hold(cell_builds(r.cell), at_gate, NULL);
    r.slow = cell_client(r.cell);
    r.other = cell_client(r.cell);
    cell_hello(r.slow, SLOW, 1, 60, WIRE_LOST_REMOVE);
    cell_hello(r.other, OTHER, 1, 60, WIRE_LOST_REMOVE);
    *state = &r;
    return 0;
}

/* And each session replays with the same events: there, what was slow is built within the tick. */
static int close_room(void **state)
{
    room *r = *state;
    char command[128];
    set_gate(true);
    memory_disconnect(r->slow);
    memory_disconnect(r->other);
    int status = cell_stop(r->cell);
    for (long workers = 1; workers <= 2 && !status; workers++) status = cell_replay(r->path, workers, workers == 1);
    wire_memory_destroy(r->memory);
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command) ? -1 : status;
}

static memory_end *end_of(room *r, int64_t client)
{
    return client == SLOW ? r->slow : r->other;
}

/* Ground with its surface about z = 0, too large to be built at once; another one for each seed. */
static int64_t ground_of(double numbers[NUMBERS], int seed)
{
    static const int32_t sizes[2] = {SIDE, SIDE};
    numbers[0] = numbers[1] = 1;
    numbers[2] = 0.5;
    for (int i = WIRE_FIELD_HEAD; i < NUMBERS; i++) numbers[i] = 0.001 * seed + 0.01 * sin(i);
    return wire_geometry_hash(WIRE_GEOMETRY_HEIGHT_FIELD, (wire_f64s){NUMBERS, numbers}, (wire_i32s){2, sizes});
}

static int64_t send_numbers(room *r, int64_t client, const double *numbers, int64_t hash)
{
    static const int32_t sizes[2] = {SIDE, SIDE};
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_HEIGHT_FIELD,
            .hash = hash,
            .vertex_numbers = NUMBERS,
            .index_numbers = 2,
            .pieces = 1,
            .vertices = {NUMBERS, numbers},
            .indices = {2, sizes}}};
    memory_send(end_of(r, client), &m);
    return r->sequence;
}

static int64_t send_ground(room *r, int64_t client, int seed)
{
    double numbers[NUMBERS];
    int64_t hash = ground_of(numbers, seed);
    send_numbers(r, client, numbers, hash);
    return hash;
}

static void take_back(room *r, int64_t client, int64_t hash)
{
    const wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .removed = 1,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .pieces = 1}};
    memory_send(end_of(r, client), &m);
}

/* Its sequence; hash 0: its removal. */
static int64_t send_shape(room *r, int64_t client, int32_t body, const char *name, uint8_t type, int64_t hash, double x)
{
    const wire_message gone = {
        .kind = WIRE_BODY, .body = {WIRE_VERSION, client, ++r->sequence, body, .removed = 1, .name = "", .group = ""}};
    if (hash)
        cell_body_of(end_of(r, client), client, r->sequence, body, name, type, hash, x);
    else
        memory_send(end_of(r, client), &gone);
    return r->sequence;
}

static int64_t send_body(room *r, int64_t client, int32_t body, const char *name, int64_t hash, double x)
{
    return send_shape(r, client, body, name, WIRE_SHAPE_HEIGHT_FIELD, hash, x);
}

static int64_t send_hull_body(room *r, int64_t client, int32_t body, const char *name, int64_t hash)
{
    return send_shape(r, client, body, name, WIRE_SHAPE_HULL, hash, 0);
}

/* Where that body is; NAN: it is not in the world. */
static double x_of(room *r, const char *name)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = OTHER,
            .sequence = ++r->sequence,
            .kind = WIRE_QUERY_BODIES,
            .name_a = name,
            .name_b = ""}};
    memory_send(r->other, &q);
    for (;;) {
        wire_answer a = cell_await(r->other, r->memory, WIRE_ANSWER).answer;
        if (a.sequence == q.query.sequence) return a.names_a.count ? a.points_a.at[0] : NAN;
    }
}

static void settle(room *r, int64_t client)
{
    cell_settle(end_of(r, client), r->memory, client, ++r->sequence);
}

static int64_t counter(room *r, const char *name)
{
    cell_await(r->other, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->other, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static void await_counter(room *r, const char *name, int64_t value)
{
    for (int tries = 0; tries < 200; tries++)
        if (counter(r, name) == value) return;
    fail_msg("%s is never %d", name, (int)value);
}

static bool acked(const wire_message *m, int64_t sequence)
{
    for (uint32_t i = 0; i < m->ack.sequences.count; i++)
        if (m->ack.sequences.at[i] == sequence) return true;
    return false;
}

/* Of both, in whatever order. */
static void await_acks(room *r, int64_t client, int64_t one, int64_t two)
{
    for (bool has[2] = {false, false}; !has[0] || !has[1];) {
        wire_message m = cell_await(end_of(r, client), r->memory, WIRE_ACK);
        has[0] |= acked(&m, one);
        has[1] |= acked(&m, two);
    }
}

static void await_ack(room *r, int64_t client, int64_t sequence)
{
    wire_message m = {.kind = WIRE_NOTHING};
    while (!acked(&m, sequence)) m = cell_await(end_of(r, client), r->memory, WIRE_ACK);
}

static void expect_reject(room *r, int64_t client, int64_t sequence, wire_reason reason)
{
    for (;;) {
        wire_reject j = cell_await(end_of(r, client), r->memory, WIRE_REJECT).reject;
        if (j.sequence != sequence) continue;
        assert_int_equal(j.reason, reason);
        return;
    }
}

/* In whatever order. */
static void expect_rejects(room *r, int64_t client, int count, const int64_t *sequences, const wire_reason *reasons)
{
    for (int found = 0; found < count;) {
        wire_reject j = cell_await(end_of(r, client), r->memory, WIRE_REJECT).reject;
        for (int i = 0; i < count; i++) {
            if (j.sequence != sequences[i]) continue;
            assert_int_equal(j.reason, reasons[i]);
            found++;
        }
    }
}

static void open_gate_and_wait(room *r)
{
    set_gate(true);
    await_counter(r, "pending_geometries", 0);
}

/* ---- tests ---- */

static void a_neighbour_goes_on_while_a_body_waits_and_both_meet_in_one_tick(void **state)
{
    room *r = *state;
    cell_touches(r->other, OTHER, ++r->sequence, 0);
    cell_sphere(r->other, OTHER, ++r->sequence, 0, "ball", 0);
    int64_t hash = send_ground(r, SLOW, 1), came = r->sequence;
    int64_t body = send_body(r, SLOW, 0, "ground", hash, 0);
    send_body(r, SLOW, 1, "more", hash, 30);
    settle(r, SLOW);
    for (int i = 0; i < 20; i++) assert_true(x_of(r, "ball") == 0 && isnan(x_of(r, "ground")));
    wire_message m;
    cell_await(r->other, r->memory, WIRE_STATUS);
    m = cell_await(r->other, r->memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&m.status, "pending_bodies"), 2);
    assert_int_equal(cell_counter(&m.status, "pending_geometries"), 1);
    assert_int_equal(cell_counter(&m.status, "client_pending_000000000000000b"), 2);
    assert_true(cell_counter(&m.status, "pending_body_ns_ground") > 0);
    assert_true(cell_counter(&m.status, "pending_build_work") > 0);
    while (memory_receive(r->slow, r->memory, &m)) /* neither is done */
        assert_false(m.kind == WIRE_ACK && (acked(&m, came) || acked(&m, body)));
    set_gate(true);
    await_acks(r, SLOW, came, body);
    assert_true(x_of(r, "ground") == 0 && x_of(r, "more") == 30);
    open_gate_and_wait(r);
    assert_int_equal(counter(r, "contacts"), 1);
}

/* Longer than what has not come is waited for. */
static void what_is_being_built_is_waited_for_without_end(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1), came = r->sequence;
    int64_t body = send_body(r, SLOW, 0, "ground", hash, 0);
    for (int i = 0; i < 13; i++) { /* over LCM they are repeated */
        double numbers[NUMBERS];
        ground_of(numbers, 1);
        usleep(100000);
        r->sequence = came - 1;
        send_numbers(r, SLOW, numbers, hash);
        send_body(r, SLOW, 0, "ground", hash, 0);
        assert_int_equal(r->sequence, body);
        r->sequence += 50;
    }
    assert_int_equal(counter(r, "pending_bodies"), 1);
    assert_int_equal(counter(r, "reject_unknown_geometry"), 0);
    set_gate(true);
    await_acks(r, SLOW, came, body);
    assert_int_equal(counter(r, "geometries"), 1);
}

static void the_newest_word_on_a_body_stands(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "ground", hash, 0);
    send_body(r, SLOW, 0, "ground", hash, 100);
    send_body(r, SLOW, 1, "gone", hash, 0);
    send_body(r, SLOW, 1, "", 0, 0);
    send_body(r, SLOW, 2, "ball", hash, 0);
    settle(r, SLOW);
    cell_sphere(r->slow, SLOW, ++r->sequence, 2, "ball", 7); /* needs nothing */
    await_ack(r, SLOW, r->sequence);
    assert_true(x_of(r, "ball") == 7);
    assert_int_equal(counter(r, "pending_bodies"), 1);
    open_gate_and_wait(r);
    assert_true(x_of(r, "ground") == 100 && isnan(x_of(r, "gone")) && x_of(r, "ball") == 7);
}

/* It has its old shape until the new one is there, and is told of by its poses all the while. */
static void a_body_that_is_there_keeps_its_shape_until_then(void **state)
{
    room *r = *state;
    cell_sphere(r->slow, SLOW, ++r->sequence, 0, "it", 3);
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "it", hash, 4);
    settle(r, SLOW);
    assert_true(x_of(r, "it") == 3);
    cell_pose(r->slow, SLOW, ++r->sequence, 0, 9);
    settle(r, SLOW);
    assert_true(x_of(r, "it") == 9);
    open_gate_and_wait(r);
    assert_true(x_of(r, "it") == 9);
}

static void the_newest_pose_is_kept(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1);
    cell_pose(r->slow, SLOW, ++r->sequence, 1, 77); /* older than its body */
    send_body(r, SLOW, 0, "ground", hash, 0);
    send_body(r, SLOW, 1, "second", hash, 200);
    settle(r, SLOW);
    cell_pose(r->slow, SLOW, r->sequence + 3, 0, 50);
    cell_pose(r->slow, SLOW, r->sequence + 2, 0, 40); /* overtaken */
    r->sequence += 3;
    settle(r, SLOW);
    send_body(r, SLOW, 2, "third", hash, 1);
    settle(r, SLOW);
    cell_pose(r->slow, SLOW, r->sequence + 5, 2, 60);
    settle(r, SLOW);
    send_body(r, SLOW, 2, "third", hash, 2); /* newer, but its pose is not */
    r->sequence += 10;
    open_gate_and_wait(r);
    assert_true(x_of(r, "ground") == 50 && x_of(r, "second") == 200 && x_of(r, "third") == 60);
}

/* The step is done without that body, and says so; its pose stands when it is there. */
static void a_step_is_done_without_a_body_that_waits(void **state)
{
    room *r = *state;
    const int32_t body = 0;
    const double position[3] = {60, 0, 0}, orientation[4] = {1, 0, 0, 0};
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "ground", hash, 0);
    cell_touches(r->slow, SLOW, ++r->sequence, 0);
    settle(r, SLOW);
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = SLOW,
            .sequence = ++r->sequence,
            .step = 4,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(r->slow, &m);
    wire_event_batch b = {.step = 0};
    while (b.step != 4) b = cell_await(r->slow, r->memory, WIRE_EVENT_BATCH).event_batch;
    assert_int_equal(b.refused, 1);
    assert_int_equal(b.refusal, WIRE_UNKNOWN_BODY);
    open_gate_and_wait(r);
    assert_true(x_of(r, "ground") == 60);
}

/* What the lost client leaves is a body that waits. */
static void lose(room *r, uint8_t on_loss)
{
    cell_hello(r->slow, SLOW, ++r->sequence, 0.2, on_loss);
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "ground", hash, 5);
    await_counter(r, "pending_bodies", 1);
    await_counter(r, "clients_lost", 1);
}

static void what_a_lost_client_waited_for_is_nobodys(void **state)
{
    room *r = *state;
    lose(r, WIRE_LOST_REMOVE);
    assert_int_equal(counter(r, "pending_bodies"), 0);
    assert_int_equal(counter(r, "pending_geometries"), 0);
    open_gate_and_wait(r);
    assert_true(isnan(x_of(r, "ground")));
    assert_int_equal(counter(r, "geometries"), 0);
}

static void what_a_lost_client_keeps_comes_all_the_same(void **state)
{
    room *r = *state;
    lose(r, WIRE_LOST_HOLD);
    assert_int_equal(counter(r, "pending_bodies"), 1);
    open_gate_and_wait(r);
    assert_true(x_of(r, "ground") == 5);
}

static void what_is_taken_back_stays_for_a_body_that_waits(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "ground", hash, 5);
    settle(r, SLOW);
    take_back(r, SLOW, hash);
    settle(r, SLOW);
    open_gate_and_wait(r);
    assert_true(x_of(r, "ground") == 5);
    send_body(r, SLOW, 0, "", 0, 0);
    settle(r, SLOW);
    await_counter(r, "geometries", 0); /* and it was taken back */
}

static void what_nobody_waits_for_is_not_built(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1), more = send_ground(r, SLOW, 2);
    settle(r, SLOW);
    take_back(r, SLOW, hash);
    take_back(r, SLOW, more);
    await_counter(r, "pending_geometries", 0);
    await_counter(r, "geometries", 0);
    set_gate(true);
}

/* A hull whose points lie in a plane, and one, in two pieces, whose hash is another one's. */
static void what_cannot_be_built_is_refused_when_that_is_known(void **state)
{
    enum { POINTS_MANY = WIRE_PIECE_MAX / 3 + 10 };
    room *r = *state;
    static double points[3 * POINTS_MANY];
    for (int i = 0; i < 3 * POINTS_MANY; i++) points[i] = i % 3 == 2 && i < 600 ? 0 : sin(i);
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = SLOW,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_HULL,
            .vertex_numbers = 600,
            .pieces = 1,
            .vertices = {600, points}}};
    m.geometry.hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, m.geometry.vertices, m.geometry.indices);
    memory_send(r->slow, &m);
    int64_t flat = r->sequence, wrong = m.geometry.hash + 1;
    m.geometry.vertex_numbers = 3 * POINTS_MANY;
    m.geometry.hash = wrong;
    m.geometry.pieces = 2;
    for (int32_t piece = 0; piece < 2; piece++) {
        m.geometry.piece = piece;
        m.geometry.sequence = ++r->sequence;
        m.geometry.vertices = (wire_f64s){
            piece ? 3 * POINTS_MANY - WIRE_PIECE_MAX : WIRE_PIECE_MAX, points + (size_t)piece * WIRE_PIECE_MAX};
        memory_send(r->slow, &m);
    }
    int64_t false_hash = r->sequence;
    int64_t body = send_hull_body(r, SLOW, 0, "hull", wrong);
    settle(r, SLOW);
    assert_int_equal(counter(r, "pending_geometries"), 2);
    assert_int_equal(counter(r, "pending_bodies"), 1);
    set_gate(true);
    int64_t sequences[3] = {flat, false_hash, body};
    wire_reason reasons[3] = {WIRE_FLAT_HULL, WIRE_BAD_HASH, WIRE_UNKNOWN_GEOMETRY};
    expect_rejects(r, SLOW, 3, sequences, reasons);
    await_counter(r, "geometries", 0);
    assert_int_equal(counter(r, "pending_bodies"), 0);
}

/* Both are sent before either is built. */
static void the_same_of_two_clients_is_built_once(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1), first = r->sequence;
    settle(r, SLOW);
    send_ground(r, OTHER, 1);
    int64_t second = r->sequence, body = send_body(r, OTHER, 0, "theirs", hash, 8);
    settle(r, OTHER);
    assert_int_equal(counter(r, "geometries"), 2);
    set_gate(true);
    await_ack(r, SLOW, first);
    await_acks(r, OTHER, second, body);
    assert_int_equal(counter(r, "geometries"), 1);
    assert_true(x_of(r, "theirs") == 8);
}

/* The one with many waits for nobody, and nobody waits for all of his. */
static void builds_go_round_the_clients(void **state)
{
    room *r = *state;
    for (int i = 0; i < 8; i++) send_ground(r, SLOW, i);
    settle(r, SLOW);
    send_ground(r, OTHER, 100); /* the ninth */
    settle(r, OTHER);
    open_gate_and_wait(r);
    size_t place = 0;
    while (place < gate.count && gate.ids[place] != 9) place++;
    assert_in_range(place, 1, 3); /* two threads had begun before it came */
}

/* Bodies that wait count among those that a client may have. */
static void what_waits_has_limits(void **state)
{
    room *r = *state;
    int64_t hash = send_ground(r, SLOW, 1);
    for (int i = 0; i < 40; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", i);
        send_body(r, SLOW, i, name, hash, i);
    }
    settle(r, SLOW);
    int64_t beyond = send_body(r, SLOW, 40, "b40", hash, 0);
    expect_reject(r, SLOW, beyond, WIRE_LIMIT);
    send_body(r, SLOW, 3, "b3", hash, 500); /* instead of one */
    settle(r, SLOW);
    assert_int_equal(counter(r, "pending_bodies"), 40);
    open_gate_and_wait(r);
    assert_int_equal(counter(r, "bodies"), 40);
    assert_true(x_of(r, "b3") == 500);
}

/* It begins while some are being built and others wait, and goes on from there. */
static void a_recording_may_begin_while_a_build_is_under_way(void **state)
{
    room *r = *state;
    char path[sizeof folder + 32];
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    cell_touches(r->other, OTHER, ++r->sequence, 0);
    cell_sphere(r->other, OTHER, ++r->sequence, 0, "ball", 0);
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "ground", hash, 50);
    settle(r, SLOW);
    cell_pose(r->slow, SLOW, ++r->sequence, 0, 0);
    settle(r, SLOW);
    cell_end_recording(r->cell); /* the one from the start */
    wire_message q = {.kind = WIRE_QUERY,
        .query = {
            .version = WIRE_VERSION, .client = OTHER, .kind = WIRE_QUERY_RECORD, .name_a = "middle", .name_b = ""}};
    wire_answer a;
    do { /* until that one has ended */
        q.query.sequence = ++r->sequence;
        memory_send(r->other, &q);
        do a = cell_await(r->other, r->memory, WIRE_ANSWER).answer;
        while (a.kind != WIRE_QUERY_RECORD);
    } while (strncmp(a.text, "already", strlen("already")) == 0);
    assert_string_equal(a.text, path);
    settle(r, OTHER);
    open_gate_and_wait(r);
    assert_int_equal(counter(r, "contacts"), 1);
    cell_pose(r->other, OTHER, ++r->sequence, 0, 100);
    settle(r, OTHER);
    await_counter(r, "contacts", 0);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    memory_disconnect(r->other);
    memory_disconnect(r->slow);
    assert_int_equal(cell_stop(r->cell), 0);
    assert_int_equal(cell_replay(path, 1, true), EX_OK);
    config c = cell_config(); /* for the end of this test */
    snprintf(c.record, sizeof c.record, "%s/last.lcmlog", folder);
    snprintf(r->path, sizeof r->path, "%s/last.lcmlog", folder);
    r->cell = cell_start(&c);
    r->slow = cell_client(r->cell);
    r->other = cell_client(r->cell);
}

/* ---- recordings of before ---- */

typedef struct copy {
    wire_log_writer *to;
    int builds;
} copy;

/* All but the marks. */
static void copy_as_of_old(void *context, const wire_log_entry *e)
{
    copy *c = context;
    c->builds += e->kind == WIRE_LOG_BUILD;
    if (e->kind == WIRE_LOG_MESSAGE) assert_int_equal(wire_log_message(c->to, e->timestamp_us, &e->message), 0);
    if (e->kind == WIRE_LOG_TICK) assert_int_equal(wire_log_tick_end(c->to, e->timestamp_us, &e->tick), 0);
}

/* Without marks a geometry is there when its last piece has come. */
static void recordings_without_marks_are_built_at_once(void **state)
{
    room *r = *state;
    char path[sizeof folder + 32], why[128];
    int64_t hash = send_ground(r, SLOW, 1);
    send_body(r, SLOW, 0, "ground", hash, 0);
    open_gate_and_wait(r);
    cell_touches(r->other, OTHER, ++r->sequence, 0);
    cell_sphere(r->other, OTHER, ++r->sequence, 0, "ball", 0);
    settle(r, OTHER);
    await_counter(r, "contacts", 1);
    memory_disconnect(r->other);
    memory_disconnect(r->slow);
    assert_int_equal(cell_stop(r->cell), 0);
    snprintf(path, sizeof path, "%s/old.lcmlog", folder);
    copy c = {.to = wire_log_create(path, why, sizeof why)};
    assert_non_null(c.to);
    cell_read(r->path, copy_as_of_old, &c);
    assert_int_equal(wire_log_close(c.to), 0);
    assert_int_equal(c.builds, 2);
    assert_int_equal(cell_replay(path, 1, true), EX_OK);
    config again = cell_config(); /* for the end of this test */
    snprintf(again.record, sizeof again.record, "%s/last.lcmlog", folder);
    snprintf(r->path, sizeof r->path, "%s/last.lcmlog", folder);
    r->cell = cell_start(&again);
    r->slow = cell_client(r->cell);
    r->other = cell_client(r->cell);
}

/* A build that is under way is left to itself. */
static void a_daemon_ends_while_something_is_built(void **state)
{
    room *r = *state;
    for (int i = 0; i < 4; i++) send_body(r, SLOW, i, "ground", send_ground(r, SLOW, i), 0);
    settle(r, SLOW);
    await_counter(r, "pending_geometries", 4);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, open_room, close_room)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_neighbour_goes_on_while_a_body_waits_and_both_meet_in_one_tick),
        TEST(what_is_being_built_is_waited_for_without_end),
        TEST(the_newest_word_on_a_body_stands),
        TEST(a_body_that_is_there_keeps_its_shape_until_then),
        TEST(the_newest_pose_is_kept),
        TEST(a_step_is_done_without_a_body_that_waits),
        TEST(what_a_lost_client_waited_for_is_nobodys),
        TEST(what_a_lost_client_keeps_comes_all_the_same),
        TEST(what_is_taken_back_stays_for_a_body_that_waits),
        TEST(what_nobody_waits_for_is_not_built),
        TEST(what_cannot_be_built_is_refused_when_that_is_known),
        TEST(the_same_of_two_clients_is_built_once),
        TEST(builds_go_round_the_clients),
        TEST(what_waits_has_limits),
        TEST(a_recording_may_begin_while_a_build_is_under_way),
        TEST(recordings_without_marks_are_built_at_once),
        TEST(a_daemon_ends_while_something_is_built),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
