/* The dial in the daemon: tolerances that cannot be are answered with what can be; what each subscriber costs is in
 * Status; a session with a budget replays to the bit, for any number of workers, with caches and without. */
#include "cell.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { ALICE = 11, BODIES = 40, STEPS = 60 };

static wire_message ask_for(int64_t sequence, int32_t subscription)
{
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .subscription = subscription,
            .facts = WIRE_FACT_TOUCH | WIRE_FACT_DISTANCE,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .range_m = 2,
            .relative_tolerance = 1e-6}};
}

static void expect_refused(memory_end *e, wire_memory *memory, const wire_message *m, uint8_t reason, const char *text)
{
    memory_send(e, m);
    wire_reject r = cell_await(e, memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, reason);
    assert_int_equal(r.sequence, m->subscription.sequence);
    if (!strstr(r.text, text)) fail_msg("\"%s\" does not say \"%s\"", r.text, text);
}

static void a_tolerance_that_cannot_be_is_answered_with_what_can(void **state)
{
    (void)state;
    config c = cell_config();
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    cell_hello(e, ALICE, 1, 60, WIRE_LOST_REMOVE);
    static const double RELATIVE[] = {-1e-6, 1e-16, 2};
    int64_t sequence = 1;
    for (size_t i = 0; i < sizeof RELATIVE / sizeof *RELATIVE; i++) {
        wire_message m = ask_for(++sequence, 0);
        m.subscription.relative_tolerance = RELATIVE[i];
        expect_refused(e, memory, &m, WIRE_BAD_NUMBER, "1e-15 to 1 is possible, or 0");
    }
    wire_message m = ask_for(++sequence, 0);
    m.subscription.relative_tolerance = NAN;
    expect_refused(e, memory, &m, WIRE_BAD_NUMBER, "relative_tolerance[0] is not a number");
    m = ask_for(++sequence, 0);
    m.subscription.tolerance_m = -0.5;
    expect_refused(e, memory, &m, WIRE_BAD_NUMBER, "at least 0 is allowed");
    m = ask_for(++sequence, 0);
    m.subscription.facts |= WIRE_FACT_MANIFOLD;
    m.subscription.accuracy = WIRE_BY_BOXES;
    expect_refused(e, memory, &m, WIRE_UNSUPPORTED, "manifolds need 0, by tolerance");
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(daemon), 0);
}

/* Finer in metres than doubles tell apart: it is taken, and the answer says that it is wider. */
static void what_arithmetic_cannot_give_is_said(void **state)
{
    (void)state;
    config c = cell_config();
    cell *daemon = cell_start(&c);
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    cell_hello(e, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(e, ALICE, 2, 0, "a", 0);
    cell_sphere(e, ALICE, 3, 1, "b", 5.1);
    cell_settle(e, memory, ALICE, 4);
    static const double TOLERANCES[] = {1e-9, 1e-30};
    static const uint8_t ACHIEVED[] = {WIRE_CERTAIN, WIRE_WIDE};
    for (int i = 0; i < 2; i++) {
        wire_message q = {.kind = WIRE_QUERY,
            .query = {.version = WIRE_VERSION,
                .client = ALICE,
                .sequence = 5 + i,
                .kind = WIRE_QUERY_DISTANCE,
                .name_a = "a",
                .name_b = "b",
                .tolerance_m = TOLERANCES[i]}};
        memory_send(e, &q);
        wire_answer a = cell_await(e, memory, WIRE_ANSWER).answer;
        assert_true(a.achieved.count == 1 && a.lo.at[0] <= a.hi.at[0] && a.hi.at[0] < 3.2);
        assert_int_equal(a.achieved.at[0], ACHIEVED[i]);
    }
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(daemon), 0);
}

/* ---- a session with a budget ---- */

static char folder[] = "/tmp/collided-dial-XXXXXX";

static void play_session(cell *daemon)
{
    memory_end *e = cell_client(daemon);
    wire_memory *memory = wire_memory_create();
    int64_t sequence = 0;
    cell_hello(e, ALICE, ++sequence, 60, WIRE_LOST_REMOVE);
    for (int i = 0; i < BODIES; i++) {
        char name[16];
        snprintf(name, sizeof name, "ball%d", i);
        cell_sphere(e, ALICE, ++sequence, i, name, 1.5 * i);
    }
    wire_message fine = ask_for(++sequence, 0), coarse = ask_for(++sequence, 1);
    coarse.subscription.accuracy = WIRE_BY_BOXES;
    coarse.subscription.stream = "coarse";
    memory_send(e, &fine);
    memory_send(e, &coarse);
    for (int step = 0; step < STEPS; step++) {
        for (int i = 0; i < BODIES; i++) cell_pose(e, ALICE, ++sequence, i, 1.5 * i + sin(0.1 * step + i));
        cell_settle(e, memory, ALICE, ++sequence);
    }
    wire_status s = cell_await(e, memory, WIRE_STATUS).status;
    assert_true(cell_counter(&s, "work_of_coarse") >= 0);
    assert_true(cell_counter(&s, "undone_ticks") > 0);
    assert_true(cell_counter(&s, "pairs_by_bounds") + cell_counter(&s, "pairs_by_standing") > 0);
    memory_disconnect(e);
    wire_memory_destroy(memory);
}

static void count_work(void *work, const wire_log_entry *e)
{
    if (e->kind != WIRE_LOG_TICK) return;
    assert_int_equal(e->tick.budgeted, 1);
    *(int64_t *)work += e->tick.work;
}

static void a_session_with_a_budget_replays_to_the_bit(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) fail_msg("no folder");
    config c = cell_config();
    c.budget_us = 40;
    snprintf(c.record, sizeof c.record, "%s/session.lcmlog", folder);
    cell *daemon = cell_start(&c);
    play_session(daemon);
    assert_int_equal(cell_stop(daemon), 0);
    int64_t work = 0; /* a slow build may find time for none */
    int ticks = cell_read(c.record, count_work, &work);
    print_message("%d ticks, %lld units\n", ticks, (long long)work);
    assert_true(work >= 0);
    assert_true(ticks >= 10);
    for (long workers = 1; workers <= 8; workers *= 2) assert_int_equal(cell_replay(c.record, workers, true), EX_OK);
    assert_int_equal(cell_replay(c.record, 2, false), EX_OK);
    unlink(c.record);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tolerance_that_cannot_be_is_answered_with_what_can),
        cmocka_unit_test(what_arithmetic_cannot_give_is_said),
        cmocka_unit_test(a_session_with_a_budget_replays_to_the_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
