/* How much a round takes: of commands as much as is expected to take some milliseconds, of poses as much as ticks have
 * shown to take about a slice. Counted: the service is told what things took. */
#include "base/clock.h"
#include "cell.h"
#include "service/commands.h"
#include "service/server.h"
#include "service/service.h"
#include "service/shares.h"

#include <stdio.h>

enum { ALICE = 1, RULES = 1024, MANY = 20000 };

static server *start(void)
{
    char why[256];
    config c = cell_config();
    snprintf(c.links, sizeof c.links, "memory://rounds");
    server *v = server_create(&c, why, sizeof why);
    if (!v) fail_msg("%s", why);
    server_service(v)->tick = 1;
    return v;
}

static void tell(server *v, const wire_message *m)
{
    link_sink sink = server_sink(v);
    sink.message(sink.context, server_service(v)->links[0], m);
}

static void report_body(server *v, int32_t number, uint32_t rules)
{
    static const char *patterns[RULES], *reasons[RULES];
    static uint8_t actions[RULES];
    static double distances[RULES];
    for (int i = 0; i < RULES; i++) patterns[i] = "*nobody*", reasons[i] = "";
    const uint8_t type = WIRE_SHAPE_SPHERE;
    const double none[3] = {0}, half = 0.5, here[7] = {0, 0, 0, 1, 0, 0, 0}, at[7] = {2.0 * number, 0, 0, 1, 0, 0, 0};
    const int64_t geometry = 0;
    char name[32];
    snprintf(name, sizeof name, "body %d", (int)number);
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = number + 2,
            .body = number,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, at},
            .shape_types = {1, &type},
            .shape_sizes = {3, none},
            .shape_radii = {1, &half},
            .shape_poses = {7, here},
            .shape_geometries = {1, &geometry},
            .rule_patterns = {rules, patterns},
            .rule_actions = {rules, actions},
            .rule_reasons = {rules, reasons},
            .rule_paddings = {rules, distances},
            .rule_margins = {rules, distances}}};
    tell(v, &m);
}

/* slow: what has come in this round has taken a second already. */
static int until_much(uint32_t rules, bool slow)
{
    server *v = start();
    link_sink sink = server_sink(v);
    int count = 0;
    service *s = server_service(v);
    s->receive_began_ns = slow ? clock_thread_ns() - INT64_C(1000000000) : 0;
    s->receive_look_us = 100;
    assert_false(sink.much(sink.context));
    for (; count < MANY && !sink.much(sink.context); count++) report_body(v, count, rules);
    server_destroy(v);
    return count;
}

static void commands_that_take_long_are_fewer_in_a_round(void **state)
{
    (void)state;
    assert_in_range(until_much(RULES, false), 10, 40);
    assert_in_range(until_much(0, false), 300, 2000);
}

/* Whatever they were expected to take. */
static void commands_that_have_taken_long_wait_for_the_next_round(void **state)
{
    (void)state;
    assert_in_range(until_much(RULES, true), 1, 2);
    assert_in_range(until_much(0, true), 2, 60);
}

/* Of bodies that are announced, how many the next tick takes once commands took so many times as long as expected. */
static size_t taken_when(double times_as_long)
{
    server *v = start();
    service *s = server_service(v);
    s->monotonic_ns = 1;
    for (int i = 0; i < 200; i++) report_body(v, i, RULES);
    assert_true(shares_learn(s));
    shares_carried_out(s, (int64_t)(1e3 * times_as_long * shares_expected_us(s)));
    shares_release(s);
    size_t count = s->inbox.commands.count;
    server_destroy(v);
    return count;
}

static void commands_that_took_long_are_fewer_in_a_tick(void **state)
{
    (void)state;
    size_t quick = taken_when(0.1), slow = taken_when(8);
    assert_in_range(quick, 40, 60);
    assert_in_range(slow, 1, 20);
}

/* ---- poses ---- */

static size_t room_for_all(server *v)
{
    static int32_t bodies[MANY];
    static double positions[3 * MANY], orientations[4 * MANY];
    uint64_t work;
    for (int i = 0; i < MANY; i++) {
        bodies[i] = i;
        positions[3 * i + 1] = 50; /* none of them stays where it was */
        orientations[4 * i] = 1;
    }
    const wire_pose_batch m = {.version = WIRE_VERSION,
        .client = ALICE,
        .sequence = 2 * MANY,
        .bodies = {MANY, bodies},
        .positions = {3 * (size_t)MANY, positions},
        .orientations = {4 * (size_t)MANY, orientations}};
    return poses_room(server_service(v), &m, &work);
}

/* Some of what waits for its share, and a tick, a second later. */
static void go_on(service *s)
{
    s->monotonic_ns += INT64_C(1000000000);
    s->now_ns += INT64_C(1000000000);
    shares_release(s);
    service_tick(s);
}

static void poses_that_took_long_are_fewer_in_a_round(void **state)
{
    (void)state;
    enum { UNITS = 4000000, A_BODY = 1000 /* units */ };
    server *v = start();
    service *s = server_service(v);
    s->config.slice_us = 20000;
    for (int32_t i = 0; i < MANY; i++) {
        report_body(v, i, 0);
        if (i % 500 == 0) go_on(s);
    }
    /* On a busy machine a tick takes fewer bodies, and learns that units take long: it is told otherwise below. */
    for (int i = 0; i < 10000 && world_get_figures(s->world).bodies < MANY; i++) go_on(s);
    assert_int_equal(world_get_figures(s->world).bodies, MANY);
    for (int i = 0; i < 500; i++) service_learn_effort(s, UNITS, UNITS);
    size_t quick = room_for_all(v);
    assert_in_range(quick, 10000, 13000);
    service_learn_effort(s, UNITS / 100, 100 * UNITS); /* too little to learn from */
    assert_int_equal(room_for_all(v), quick);
    size_t before = quick;
    for (int i = 0; i < 50; i++) { /* four nanoseconds a unit */
        service_learn_effort(s, UNITS, INT64_C(4) * UNITS);
        size_t now = room_for_all(v);
        assert_true(now <= before);
        before = now;
    }
    assert_in_range(before, 4800, 5300); /* 20 ms */
    for (int i = 0; i < 50; i++) service_learn_effort(s, UNITS, INT64_C(1000) * UNITS);
    assert_in_range(room_for_all(v), 2000, 2600); /* some come through, however slow it is */
    for (int i = 0; i < 500; i++) service_learn_effort(s, UNITS, UNITS);
    assert_int_equal(room_for_all(v), quick);
    server_destroy(v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(commands_that_take_long_are_fewer_in_a_round),
        cmocka_unit_test(commands_that_have_taken_long_wait_for_the_next_round),
        cmocka_unit_test(commands_that_took_long_are_fewer_in_a_tick),
        cmocka_unit_test(poses_that_took_long_are_fewer_in_a_round),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
