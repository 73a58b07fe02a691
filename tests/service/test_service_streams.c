/* Streams as a subscriber sees them: silent but for heartbeats where nothing changes, and told where something does. */
#include "cell.h"

enum { ALICE = 11 };
static const double PERIOD_S = 0.05;

typedef struct room {
    cell *cell;
    memory_end *alice;
    wire_memory *memory;
    int64_t sequence;
} room;

static room enter(double heartbeat_s)
{
    config c = cell_config();
    c.heartbeat = heartbeat_s;
    room r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, ++r.sequence, 60, WIRE_LOST_REMOVE);
    cell_sphere(r.alice, ALICE, ++r.sequence, 0, "a", 0);
    cell_sphere(r.alice, ALICE, ++r.sequence, 1, "b", 1.5);
    cell_touches(r.alice, ALICE, ++r.sequence, 0);
    return r;
}

static void leave(room *r)
{
    memory_disconnect(r->alice);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

static wire_event_batch await_batch(room *r, bool heartbeat)
{
    for (;;) {
        wire_event_batch b = cell_await(r->alice, r->memory, WIRE_EVENT_BATCH).event_batch;
        if (b.heartbeat == heartbeat) return b;
    }
}

static void move(room *r, int64_t stamp_ns, double x)
{
    const int32_t body = 1;
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .stamp_ns = stamp_ns,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(r->alice, &m);
}

static void a_silent_stream_has_a_heartbeat_with_the_number_of_its_last_batch(void **state)
{
    (void)state;
    room r = enter(PERIOD_S);
    wire_event_batch b = await_batch(&r, false);
    assert_true(b.snapshot && b.kinds.count == 1);
    int64_t last = b.batch, before = b.stamp_ns;
    for (int i = 0; i < 3; i++) {
        b = cell_await(r.alice, r.memory, WIRE_EVENT_BATCH).event_batch;
        assert_int_equal(b.heartbeat, 1);
        assert_int_equal(b.kinds.count, 0);
        assert_int_equal(b.batch, last); /* it is none */
        assert_int_equal(b.oldest_pose_ns, 0);
        assert_true(b.stamp_ns - before >= (int64_t)(0.9e9 * PERIOD_S)); /* no more often than that */
        before = b.stamp_ns;
    }
    leave(&r);
}

/* 200 times the same poses, stamped anew: no events, and the heartbeat tells their age. */
static void a_resting_scene_sends_nothing_but_heartbeats(void **state)
{
    (void)state;
    room r = enter(PERIOD_S);
    int64_t last = await_batch(&r, false).batch;
    move(&r, 1000, 1.5);
    move(&r, 2000, 1.5);
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    for (int i = 0; i < 200; i++) {
        move(&r, 3000 + i, 1.5);
        if (i % 10 == 0) cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    }
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    wire_event_batch b = await_batch(&r, true);
    while (b.oldest_pose_ns < 3199) b = await_batch(&r, true);
    assert_int_equal(b.latest_pose_ns, 3199);
    assert_in_range(b.batch, last, last + 1); /* the velocity became known to be 0 */
    last = b.batch;
    move(&r, 4000, 1.25);
    b = await_batch(&r, false);
    assert_int_equal(b.batch, last + 1);
    assert_int_equal(b.kinds.at[0], WIRE_EVENT_UPDATE);
    leave(&r);
}

/* It waits for its first reader, who gets a snapshot before any heartbeat. */
static void no_heartbeat_comes_before_the_first_batch(void **state)
{
    (void)state;
    room r = enter(PERIOD_S / 5);
    wire_event_batch b = cell_await(r.alice, r.memory, WIRE_EVENT_BATCH).event_batch;
    assert_true(b.snapshot && !b.heartbeat);
    leave(&r);
}

static void heartbeats_are_counted_and_are_no_batches(void **state)
{
    (void)state;
    room r = enter(PERIOD_S / 5);
    for (int i = 0; i < 5; i++) await_batch(&r, true);
    wire_message s = cell_await(r.alice, r.memory, WIRE_STATUS);
    assert_true(cell_counter(&s.status, "heartbeats") >= 4);
    assert_int_equal(cell_counter(&s.status, "batches_out"), 1);
    leave(&r);
}

static void an_subscription_has_hysteresis(void **state)
{
    (void)state;
    room r = enter(3600);
    await_batch(&r, false);
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r.sequence,
            .facts = WIRE_FACT_TOUCH,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .hysteresis_m = 0.5,
            .tolerance_m = 1e-9}};
    memory_send(r.alice, &m);
    while (await_batch(&r, false).snapshot != 1) {
    }
    move(&r, 1, 2.25); /* 0.25 m apart */
    wire_event_batch b = await_batch(&r, false);
    assert_int_equal(b.kinds.at[0], WIRE_EVENT_UPDATE);
    assert_true(b.lo.at[0] > 0.2);
    move(&r, 2, 2.75);
    b = await_batch(&r, false);
    assert_int_equal(b.kinds.at[0], WIRE_EVENT_END);
    leave(&r);
}

static bool has_counter(const wire_status *s, const char *name)
{
    for (uint32_t i = 0; i < s->counter_names.count; i++)
        if (strcmp(s->counter_names.at[i], name) == 0) return true;
    return false;
}

/* Up to 64 streams are named; a client may call one of its own "other_streams". */
static void the_work_of_streams_is_told_by_name_and_of_the_rest_together(void **state)
{
    (void)state;
    enum { NAMED = 64 };
    room r = enter(3600);
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .facts = WIRE_FACT_TOUCH,
            .stream = "other_streams",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-9}};
    for (int32_t i = 1; i < NAMED; i++) {
        m.subscription.subscription = i;
        m.subscription.sequence = ++r.sequence;
        memory_send(r.alice, &m);
        m.subscription.stream = "";
    }
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    cell_await(r.alice, r.memory, WIRE_STATUS);
    wire_status s = cell_await(r.alice, r.memory, WIRE_STATUS).status;
    size_t named = 0;
    for (uint32_t i = 0; i < s.counter_names.count; i++) named += strncmp(s.counter_names.at[i], "work_of_", 8) == 0;
    assert_int_equal(named, NAMED); /* "other_streams" among them, once */
    assert_true(has_counter(&s, "work_of_other_streams"));
    assert_false(has_counter(&s, "other_streams_work"));
    m.subscription.subscription = NAMED;
    m.subscription.sequence = ++r.sequence;
    memory_send(r.alice, &m);
    cell_settle(r.alice, r.memory, ALICE, ++r.sequence);
    cell_await(r.alice, r.memory, WIRE_STATUS);
    s = cell_await(r.alice, r.memory, WIRE_STATUS).status;
    assert_true(has_counter(&s, "other_streams_work"));
    leave(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_silent_stream_has_a_heartbeat_with_the_number_of_its_last_batch),
        cmocka_unit_test(a_resting_scene_sends_nothing_but_heartbeats),
        cmocka_unit_test(no_heartbeat_comes_before_the_first_batch),
        cmocka_unit_test(heartbeats_are_counted_and_are_no_batches),
        cmocka_unit_test(an_subscription_has_hysteresis),
        cmocka_unit_test(the_work_of_streams_is_told_by_name_and_of_the_rest_together),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
