/* What one client may have, and how fast it may talk: at the limit, and one beyond it. */
#include "cell.h"

#include "base/clock.h"

#include <stdio.h>

enum { ALICE = 11, BOB = 22 };

typedef struct room {
    cell *cell;
    memory_end *end, *bobs; /* each a participant of its own; what is told comes to both */
    wire_memory *memory;
    int64_t sequence; /* of both clients */
} room;

static void room_open(room *r, const config *c)
{
    *r = (room){.cell = cell_start(c), .memory = wire_memory_create()};
    r->end = cell_client(r->cell);
    r->bobs = cell_client(r->cell);
    cell_hello(r->end, ALICE, ++r->sequence, 60, WIRE_LOST_REMOVE);
    cell_hello(r->bobs, BOB, ++r->sequence, 60, WIRE_LOST_REMOVE);
    cell_settle(r->bobs, r->memory, BOB, ++r->sequence);
}

static void room_close(room *r)
{
    memory_disconnect(r->end);
    memory_disconnect(r->bobs);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

static memory_end *end_of(const room *r, int64_t client)
{
    return client == BOB ? r->bobs : r->end;
}

static void put(room *r, int64_t client, int32_t body)
{
    char name[32];
    snprintf(name, sizeof name, "%d.%d", (int)client, (int)body);
    cell_sphere(end_of(r, client), client, ++r->sequence, body, name, 5.0 * body);
}

static void removed(room *r, int32_t body)
{
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .body = body,
            .removed = 1,
            .name = "",
            .group = ""}};
    memory_send(r->end, &m);
}

static void check_limit(const wire_reject *why, const char *says)
{
    assert_int_equal(why->reason, WIRE_LIMIT);
    assert_int_equal(why->client, ALICE);
    if (!strstr(why->text, says)) fail_msg("\"%s\", not \"%s\"", why->text, says);
}

/* Has anything been refused since the last Reject was looked at, for that limit ("": for none)? The answer comes behind
 * all of them. */
static bool is_limited(room *r, const char *says)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = ++r->sequence,
            .kind = WIRE_QUERY_BODIES,
            .name_a = "*",
            .name_b = ""}};
    bool limited = false;
    memory_send(r->bobs, &q);
    for (;;) {
        wire_message m;
        wire_memory_reset(r->memory);
        if (!memory_receive(r->end, r->memory, &m)) continue;
        if (m.kind == WIRE_REJECT && *says) check_limit(&m.reject, says);
        if (m.kind == WIRE_REJECT && !*says) fail_msg("refused: %s", m.reject.text);
        limited |= m.kind == WIRE_REJECT;
        if (m.kind == WIRE_ANSWER && m.answer.sequence == r->sequence) return limited;
    }
}

static void assert_nothing_refused(room *r)
{
    (void)is_limited(r, "");
}

static void expect_limit(room *r, const char *says)
{
    wire_message m = cell_await(r->end, r->memory, WIRE_REJECT);
    check_limit(&m.reject, says);
}

static void bodies_a_client(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_bodies = 2;
    room_open(&r, &c);
    put(&r, ALICE, 0);
    put(&r, ALICE, 1);
    put(&r, ALICE, 1); /* changed, not one more */
    put(&r, BOB, 0);
    assert_nothing_refused(&r);
    put(&r, ALICE, 2);
    expect_limit(&r, "max_client_bodies = 2");
    removed(&r, 0);
    put(&r, ALICE, 3); /* there is room again */
    assert_nothing_refused(&r);
    put(&r, ALICE, 4);
    expect_limit(&r, "max_client_bodies = 2");
    room_close(&r);
}

static void shapes_a_client(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_shapes = 3;
    room_open(&r, &c);
    for (int32_t i = 0; i < 3; i++) put(&r, ALICE, i);
    for (int32_t i = 0; i < 3; i++) put(&r, ALICE, i);
    put(&r, BOB, 0);
    assert_nothing_refused(&r);
    put(&r, ALICE, 3);
    expect_limit(&r, "max_client_shapes = 3");
    room_close(&r);
}

static void subscriptions_a_client(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_subscriptions = 2;
    room_open(&r, &c);
    cell_touches(r.end, ALICE, ++r.sequence, 0);
    cell_touches(r.end, ALICE, ++r.sequence, 1);
    cell_touches(r.end, ALICE, ++r.sequence, 1);
    cell_touches(r.bobs, BOB, ++r.sequence, 0);
    assert_nothing_refused(&r);
    cell_touches(r.end, ALICE, ++r.sequence, 2);
    expect_limit(&r, "max_client_subscriptions = 2");
    room_close(&r);
}

/* The last piece of a height field, of three: it is charged as a whole with whichever piece comes first. */
static void send_field_of(room *r, int64_t client, int32_t columns, int32_t rows, uint8_t remove)
{
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .removed = remove,
            .kind = WIRE_GEOMETRY_HEIGHT_FIELD,
            .hash = 5 + columns,
            .vertex_numbers = 3 + columns * rows,
            .index_numbers = 2,
            .piece = 2,
            .pieces = 3,
            .indices = {1, &rows}}};
    memory_send(end_of(r, client), &m);
}

static void send_field(room *r, int32_t columns, int32_t rows, uint8_t remove)
{
    send_field_of(r, ALICE, columns, rows, remove);
}

static void geometry_a_client(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_geometry = 1; /* MiB: 131,071 numbers of 8 bytes, two of 4 */
    room_open(&r, &c);
    send_field(&r, 4, 32767, 0);
    assert_nothing_refused(&r);
    send_field(&r, 2, 65534, 0); /* as much again */
    expect_limit(&r, "max_client_geometry = 1");
    send_field(&r, 4, 32767, 1);
    assert_nothing_refused(&r);
    send_field(&r, 2, 65534, 0);
    assert_nothing_refused(&r);
    room_close(&r);
}

/* All within one second: more than that would make room again. */
/* What she had announced before, and somebody else held, is not paid back to her when that lets it go. */
static void who_comes_back_is_paid_nothing_back(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_geometry = 1;
    room_open(&r, &c);
    send_field(&r, 4, 32767, 0);
    assert_nothing_refused(&r);
    send_field_of(&r, BOB, 4, 32767, 0);
    wire_message leave = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION, .client = ALICE, .sequence = ++r.sequence, .removed = 1, .name = ""}};
    memory_send(r.end, &leave);
    assert_nothing_refused(&r);
    cell_hello(r.end, ALICE, ++r.sequence, 60, WIRE_LOST_REMOVE);
    send_field(&r, 2, 65534, 0);
    send_field_of(&r, BOB, 4, 32767, 1);
    assert_nothing_refused(&r);
    send_field(&r, 28, 4681, 0);
    expect_limit(&r, "max_client_geometry = 1");
    room_close(&r);
}

static void messages_a_second(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_messages = 50;
    for (bool again = true; again;) { /* until the machine finds the time for all of it within a second */
        room_open(&r, &c);
        int64_t began_ns = clock_monotonic_ns();
        put(&r, ALICE, 0); /* the first message counted is that of a session which is there */
        for (int i = 1; i < 50; i++) cell_pose(r.end, ALICE, ++r.sequence, 0, i);
        assert_nothing_refused(&r);
        cell_pose(r.end, ALICE, ++r.sequence, 0, 50);
        bool refused = is_limited(&r, "max_client_messages = 50");
        again = !refused && clock_monotonic_ns() - began_ns > INT64_C(900000000);
        assert_true(refused || again);
        if (again) room_close(&r);
    }
    put(&r, BOB, 0); /* is not concerned */
    assert_nothing_refused(&r);
    room_close(&r);
}

static void send_poses(room *r, uint32_t count)
{
    static int32_t bodies[64];
    static double positions[3 * 64], orientations[4 * 64];
    for (uint32_t i = 0; i < count; i++) orientations[4 * i] = 1;
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .bodies = {count, bodies},
            .positions = {3 * count, positions},
            .orientations = {4 * count, orientations}}};
    memory_send(r->end, &m);
}

static void poses_a_second(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_poses = 100;
    for (bool again = true; again;) {
        room_open(&r, &c);
        int64_t began_ns = clock_monotonic_ns();
        put(&r, ALICE, 0);
        send_poses(&r, 40);
        send_poses(&r, 60);
        assert_nothing_refused(&r);
        send_poses(&r, 1);
        bool refused = is_limited(&r, "max_client_poses = 100");
        again = !refused && clock_monotonic_ns() - began_ns > INT64_C(900000000);
        assert_true(refused || again);
        room_close(&r);
    }
}

/* A flood is refused, counted to the last message, and not answered by a flood. */
static void refusals_are_counted_all_and_told_some(void **state)
{
    enum { FLOOD = 1000, TOLD = 100 };
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_bodies = 1;
    room_open(&r, &c);
    put(&r, ALICE, 0);
    assert_nothing_refused(&r);
    for (int i = 0; i < FLOOD; i++) put(&r, ALICE, 1 + i);
    wire_message m = {0};
    int told = 0;
    for (int64_t refused = 0; refused < FLOOD;) {
        wire_memory_reset(r.memory);
        if (!memory_receive(r.end, r.memory, &m)) continue;
        told += m.kind == WIRE_REJECT;
        if (m.kind == WIRE_STATUS) refused = cell_counter(&m.status, "reject_limit");
        assert_true(refused <= FLOOD);
    }
    assert_true(told >= TOLD);
    assert_true(told < FLOOD);
    assert_int_equal(told + cell_counter(&m.status, "rejects_untold"), FLOOD);
    assert_non_null(strstr(m.status.limits, "max_client_bodies"));
    assert_int_equal(m.status.health, WIRE_HEALTH_DEGRADED);
    room_close(&r);
}

/* No command can be refused for these: they are left out, and that is told. A quarter is kept for other owners. */
static void pairs_of_all(void **state)
{
    enum { BALLS = 12, MOST = 20, AND_KEPT = 26, LEFT_OUT = BALLS * (BALLS - 1) / 2 - MOST };
    (void)state;
    room r;
    wire_message m;
    char name[8];
    config c = cell_config();
    c.max_pairs = AND_KEPT;
    room_open(&r, &c);
    cell_touches(r.bobs, BOB, ++r.sequence, 1);
    for (int i = 0; i < BALLS; i++) {
        snprintf(name, sizeof name, "%d", i);
        cell_sphere(r.end, ALICE, ++r.sequence, i, name, 0.01 * i);
    }
    do {
        m = cell_await(r.end, r.memory, WIRE_EVENT_BATCH);
    } while (m.event_batch.undone != LEFT_OUT);
    do {
        m = cell_await(r.end, r.memory, WIRE_STATUS);
    } while (m.status.health != WIRE_HEALTH_DEGRADED);
    assert_non_null(strstr(m.status.limits, "max_pairs"));
    assert_int_equal(cell_counter(&m.status, "pairs"), MOST);
    assert_int_equal(cell_counter(&m.status, "pairs_left_out"), LEFT_OUT);
    for (int i = 2; i < BALLS; i++) removed(&r, i);
    do {
        m = cell_await(r.end, r.memory, WIRE_EVENT_BATCH);
    } while (m.event_batch.undone != 0);
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_a_client),
        cmocka_unit_test(shapes_a_client),
        cmocka_unit_test(subscriptions_a_client),
        cmocka_unit_test(geometry_a_client),
        cmocka_unit_test(who_comes_back_is_paid_nothing_back),
        cmocka_unit_test(messages_a_second),
        cmocka_unit_test(poses_a_second),
        cmocka_unit_test(refusals_are_counted_all_and_told_some),
        cmocka_unit_test(pairs_of_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
