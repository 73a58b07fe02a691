/* Whose geometry is it? What one client sends under a hash neither changes nor hinders what another means by it,
 * although two different hulls below have the same hash. Clients over the memory link. */
#include "cell.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { VICTIM = 11, STRANGER = 22 };

/* Two hulls of four points with one FNV-1a hash, found by a search for a collision of 3e9 hulls. */
static const double LOW[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0x1.e5ceed43p+0, 0x1.36e7a321p+0};
static const double HIGH[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0x1.8e2a310fp+0, 0x1.53a20b52p+0};

typedef struct room {
    cell *cell;
    memory_end *victim, *stranger;
    wire_memory *memory;
    int64_t sequence;
} room;

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    r = (room){.cell = cell_start(&c), .memory = wire_memory_create(), .sequence = 1};
    r.victim = cell_client(r.cell);
    r.stranger = cell_client(r.cell);
    cell_hello(r.victim, VICTIM, 1, 60, WIRE_LOST_REMOVE);
    cell_hello(r.stranger, STRANGER, 1, 60, WIRE_LOST_REMOVE);
    *state = &r;
    return 0;
}

static int close_room(void **state)
{
    room *r = *state;
    memory_disconnect(r->victim);
    memory_disconnect(r->stranger);
    int status = cell_stop(r->cell);
    wire_memory_destroy(r->memory);
    return status;
}

static int64_t hash_of(const double hull[12])
{
    return wire_geometry_hash(WIRE_GEOMETRY_HULL, (wire_f64s){12, hull}, (wire_i32s){0, NULL});
}

static memory_end *end_of(room *r, int64_t client)
{
    return client == VICTIM ? r->victim : r->stranger;
}

static wire_message hull_message(room *r, int64_t client, const double hull[12], int64_t hash)
{
    return (wire_message){.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .vertex_numbers = 12,
            .pieces = 1,
            .vertices = {12, hull}}};
}

static void send_hull(room *r, int64_t client, const double hull[12])
{
    wire_message m = hull_message(r, client, hull, hash_of(hull));
    memory_send(end_of(r, client), &m);
    cell_settle(end_of(r, client), r->memory, client, ++r->sequence);
}

static void send_body(room *r, int64_t client, int32_t body, const char *name, int64_t hash, double x)
{
    cell_body_of(end_of(r, client), client, ++r->sequence, body, name, WIRE_SHAPE_HULL, hash, x);
}

/* How high the body's highest point stands, found by a ray from above through its top. */
static double height_of(room *r, const double hull[12], double x)
{
    const double from[3] = {x, hull[10], 10}, down[3] = {0, 0, -1};
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = VICTIM,
            .sequence = ++r->sequence,
            .kind = WIRE_QUERY_RAY,
            .name_a = "",
            .name_b = "",
            .origin = {3, from},
            .direction = {3, down},
            .length_m = 20,
            .tolerance_m = 1e-9}};
    memory_send(r->victim, &q);
    for (;;) {
        wire_answer a = cell_await(r->victim, r->memory, WIRE_ANSWER).answer;
        if (a.sequence != q.query.sequence) continue;
        return a.lo.count ? 10 - a.lo.at[0] : -INFINITY; /* it grazes: that it touches is not proven */
    }
}

static int64_t counter(room *r, const char *name)
{
    cell_await(r->victim, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->victim, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static void expect_reject(room *r, int64_t client, wire_reason reason, const char *says)
{
    for (;;) {
        wire_reject j = cell_await(end_of(r, client), r->memory, WIRE_REJECT).reject;
        if (j.client != client) continue;
        assert_int_equal(j.reason, reason);
        assert_non_null(strstr(j.text, says));
        return;
    }
}

static void the_hulls_differ_and_their_hashes_do_not(void **state)
{
    (void)state;
    assert_true(hash_of(LOW) == hash_of(HIGH));
    assert_true(fabs(LOW[11] - HIGH[11]) > 0.01 && fabs(LOW[10] - HIGH[10]) > 0.001);
}

/* In either order, each is asked about his own numbers. */
static void a_hash_that_somebody_else_used_first_changes_nothing(void **state)
{
    room *r = *state;
    send_hull(r, STRANGER, HIGH);
    send_hull(r, VICTIM, LOW);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    send_body(r, STRANGER, 0, "his", hash_of(HIGH), 5);
    cell_settle(r->stranger, r->memory, STRANGER, ++r->sequence);
    assert_int_equal(counter(r, "geometries"), 2);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
    assert_true(fabs(height_of(r, HIGH, 5) - HIGH[11]) < 1e-6);
}

static void a_first_piece_of_something_else_blocks_nobody(void **state)
{
    room *r = *state;
    static double numbers[WIRE_PIECE_MAX];
    wire_message m = hull_message(r, STRANGER, LOW, hash_of(LOW));
    m.geometry.vertex_numbers = 3 * (WIRE_PIECE_MAX / 3 + 1);
    m.geometry.pieces = 2;
    m.geometry.vertices = (wire_f64s){WIRE_PIECE_MAX, numbers};
    memory_send(r->stranger, &m);
    cell_settle(r->stranger, r->memory, STRANGER, ++r->sequence);
    send_hull(r, VICTIM, LOW);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    cell_settle(r->victim, r->memory, VICTIM, ++r->sequence);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
}

static void a_body_has_no_use_of_what_others_sent(void **state)
{
    room *r = *state;
    send_hull(r, STRANGER, LOW);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    expect_reject(r, VICTIM, WIRE_UNKNOWN_GEOMETRY, "shape_geometries[0]");
}

static void equal_numbers_are_kept_once_and_as_long_as_one_wants_them(void **state)
{
    room *r = *state;
    send_hull(r, STRANGER, LOW);
    send_hull(r, VICTIM, LOW);
    send_hull(r, VICTIM, LOW); /* again: nothing changes */
    assert_int_equal(counter(r, "geometries"), 1);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    cell_settle(r->victim, r->memory, VICTIM, ++r->sequence);
    for (int i = 0; i < 2; i++) {
        wire_message m = hull_message(r, i ? VICTIM : STRANGER, LOW, hash_of(LOW));
        m.geometry.removed = 1;
        memory_send(end_of(r, m.geometry.client), &m);
        cell_settle(end_of(r, m.geometry.client), r->memory, m.geometry.client, ++r->sequence);
    }
    assert_int_equal(counter(r, "geometries"), 1); /* the body holds it */
    send_hull(r, VICTIM, HIGH);                    /* the hash is free for other numbers */
    send_body(r, VICTIM, 1, "other", hash_of(HIGH), 5);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
    assert_true(fabs(height_of(r, HIGH, 5) - HIGH[11]) < 1e-6);
    assert_int_equal(counter(r, "geometries"), 2);
}

static void one_hash_stands_for_one_thing_of_a_client(void **state)
{
    room *r = *state;
    send_hull(r, VICTIM, LOW);
    wire_message m = hull_message(r, VICTIM, HIGH, hash_of(HIGH));
    memory_send(r->victim, &m);
    expect_reject(r, VICTIM, WIRE_BAD_HASH, "other content");
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
}

static wire_message taken_back(room *r, int64_t client, const double hull[12])
{
    wire_message m = hull_message(r, client, hull, hash_of(hull));
    m.geometry.removed = 1;
    return m;
}

static void send_and_settle(room *r, const wire_message *m)
{
    memory_send(r->victim, m);
    cell_settle(r->victim, r->memory, VICTIM, ++r->sequence);
}

/* Of two words on one hash the higher sequence stands, in whichever order they come, and however often. */
static void late_copies_neither_take_back_nor_bring_back(void **state)
{
    room *r = *state;
    wire_message first = hull_message(r, VICTIM, LOW, hash_of(LOW)), back = taken_back(r, VICTIM, LOW);
    wire_message again = hull_message(r, VICTIM, LOW, hash_of(LOW)), never = taken_back(r, VICTIM, HIGH);
    send_and_settle(r, &first);
    send_and_settle(r, &back);
    assert_int_equal(counter(r, "geometries"), 0);
    send_and_settle(r, &first);
    assert_int_equal(counter(r, "geometries"), 0);
    send_and_settle(r, &again);
    send_and_settle(r, &back);
    send_and_settle(r, &first);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
    never.geometry.sequence = ++r->sequence;
    send_and_settle(r, &never); /* nor does what was overtaken by its end */
    first.geometry.vertices.at = HIGH;
    send_and_settle(r, &first);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
}

/* DDS may tell of a disposal without a sample: the time stands in for its sequence. */
static void a_disposal_does_not_shut_out_what_is_sent_next(void **state)
{
    room *r = *state;
    wire_message first = hull_message(r, VICTIM, LOW, hash_of(LOW)), disposal = taken_back(r, VICTIM, LOW);
    disposal.geometry.sequence = 1795420829587079;
    send_and_settle(r, &first);
    send_and_settle(r, &disposal);
    send_and_settle(r, &first);
    assert_int_equal(counter(r, "geometries"), 0);
    send_hull(r, VICTIM, LOW);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
}

/* In one tick, in order: what a body was announced with is its own. */
static void what_is_taken_back_behind_its_body_was_there(void **state)
{
    room *r = *state;
    wire_message came = hull_message(r, VICTIM, LOW, hash_of(LOW));
    memory_send(r->victim, &came);
    send_body(r, VICTIM, 0, "mine", hash_of(LOW), 0);
    wire_message back = taken_back(r, VICTIM, LOW);
    send_and_settle(r, &back);
    assert_true(fabs(height_of(r, LOW, 0) - LOW[11]) < 1e-6);
}

static int open_slow_room(void **state)
{
    static room r;
    config c = cell_config();
    c.rate = 4; /* so that what is sent at once is of one tick */
    c.max_geometries = 1;
    r = (room){.cell = cell_start(&c), .memory = wire_memory_create(), .sequence = 1};
    r.victim = cell_client(r.cell);
    r.stranger = cell_client(r.cell);
    cell_hello(r.victim, VICTIM, 1, 60, WIRE_LOST_REMOVE);
    cell_settle(r.victim, r.memory, VICTIM, ++r.sequence);
    *state = &r;
    return 0;
}

static void one_that_goes_makes_room_for_the_next(void **state)
{
    room *r = *state;
    send_hull(r, VICTIM, LOW);
    wire_message back = taken_back(r, VICTIM, LOW), other = hull_message(r, VICTIM, HIGH, hash_of(HIGH));
    memory_send(r->victim, &back);
    send_and_settle(r, &other);
    send_body(r, VICTIM, 0, "mine", hash_of(HIGH), 0);
    cell_settle(r->victim, r->memory, VICTIM, ++r->sequence);
    assert_true(fabs(height_of(r, HIGH, 0) - HIGH[11]) < 1e-6);
}

int main(void)
{
#define IN_A_ROOM(test) cmocka_unit_test_setup_teardown(test, open_room, close_room)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_hulls_differ_and_their_hashes_do_not),
        IN_A_ROOM(a_hash_that_somebody_else_used_first_changes_nothing),
        IN_A_ROOM(a_first_piece_of_something_else_blocks_nobody),
        IN_A_ROOM(a_body_has_no_use_of_what_others_sent),
        IN_A_ROOM(equal_numbers_are_kept_once_and_as_long_as_one_wants_them),
        IN_A_ROOM(one_hash_stands_for_one_thing_of_a_client),
        IN_A_ROOM(late_copies_neither_take_back_nor_bring_back),
        IN_A_ROOM(a_disposal_does_not_shut_out_what_is_sent_next),
        cmocka_unit_test_setup_teardown(what_is_taken_back_behind_its_body_was_there, open_slow_room, close_room),
        cmocka_unit_test_setup_teardown(one_that_goes_makes_room_for_the_next, open_slow_room, close_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
