/* A daemon that is killed and started again: clients that do nothing but poll get the same world back. */
#include "rig.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

static void polling_alone_rebuilds_the_world_after_a_restart(void **state)
{
    const char *uri = *state;
    pid_t first = rig_daemon(NULL, NULL);
    collided *c = rig_connect(uri, 10, COLLIDED_REMOVE);
    heard h;
    rig_box(c, "table", 0);
    collided_body part = rig_box(c, "part", 5);
    rig_watch(c, &h, "part");
    assert_int_equal(collided_sync(c, RIG_PATIENCE_S), COLLIDED_OK);
    for (int step = 1; step <= 5; step++) rig_move(c, part, 5 - 0.85 * step, step); /* ends at 0.75: touching */
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1 && h.step == 5);
    int64_t before = h.epoch;
    size_t snapshots = h.snapshots;

    rig_kill(first, SIGKILL);
    pid_t second = rig_daemon(NULL, NULL);
    collided_daemon_status status = {0};
    UNTIL(c, RIG_PATIENCE_S, collided_get_status(c, 1, &status) == COLLIDED_OK && status.epoch > before);
    UNTIL(c, RIG_PATIENCE_S, h.epoch == status.epoch && h.snapshots > snapshots);
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    collided_result bodies = {0};
    assert_int_equal(collided_query_bodies(c, "*", RIG_PATIENCE_S, &bodies), COLLIDED_OK);
    assert_int_equal(bodies.count, 2);
    for (size_t i = 0; i < bodies.count; i++) /* the newest pose, not that of the creation */
        if (bodies.hits[i].name_a[0] == 'p') assert_true(fabs(bodies.hits[i].point_a[0] - 0.75) < 1e-12);
    collided_result_free(&bodies);

    rig_move(c, part, 3, 6);
    UNTIL(c, RIG_PATIENCE_S, h.touching == 0 && h.step == 6);
    assert_string_equal(h.cause[COLLIDED_END], "motion");
    rig_close(c);
    assert_true(rig_alive(second));
}

/* It says that it is ready when all that its clients had is back, and not before. */
static void ready_is_said_when_the_world_is_whole(void **state)
{
    enum { CLIENTS = 3, BODIES = 40 };
    const char *uri = *state;
    pid_t first = rig_daemon(NULL, NULL);
    collided *c[CLIENTS];
    collided_daemon_status status = {0};
    for (int k = 0; k < CLIENTS; k++) {
        c[k] = rig_connect(uri, 10, COLLIDED_REMOVE);
        for (int i = 0; i < BODIES; i++) {
            char name[32];
            snprintf(name, sizeof name, "box%d.%d", k, i);
            rig_box(c[k], name, 2 * (BODIES * k + i));
        }
        assert_int_equal(collided_sync(c[k], RIG_PATIENCE_S), COLLIDED_OK);
    }
    UNTIL(
        c[0], RIG_PATIENCE_S, collided_get_status(c[0], 1, &status) == COLLIDED_OK && !strcmp(status.health, "ready"));
    int64_t before = status.epoch;
    rig_kill(first, SIGKILL);
    pid_t second = rig_daemon("--settle", "6"); /* on a busy machine the clients may hear of it late */
    bool was_starting = false, is_ready = false;
    for (double end = rig_now_s() + RIG_PATIENCE_S; !is_ready && rig_now_s() < end;) {
        for (int k = 0; k < CLIENTS; k++) (void)collided_poll(c[k], 0.01);
        if (collided_get_status(c[0], 0, &status) != COLLIDED_OK || status.epoch == before) continue;
        was_starting |= !strcmp(status.health, "starting");
        is_ready = !strcmp(status.health, "ready");
    }
    assert_true(was_starting && is_ready);
    for (size_t i = 0; i < status.counter_count; i++)
        if (!strcmp(status.counters[i].name, "bodies")) assert_int_equal(status.counters[i].value, CLIENTS * BODIES);
    for (int k = 0; k < CLIENTS; k++) rig_close(c[k]);
    assert_true(rig_alive(second));
}

static void a_daemon_that_is_gone_is_said_so(void **state)
{
    const char *uri = *state;
    pid_t daemon = rig_daemon(NULL, NULL);
    collided *c = rig_connect(uri, 10, COLLIDED_REMOVE);
    assert_int_equal(collided_poll(c, 0.1), COLLIDED_OK);
    rig_kill(daemon, SIGKILL);
    UNTIL(c, RIG_PATIENCE_S, collided_poll(c, 0.01) == COLLIDED_NO_DAEMON);
    rig_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER_BOTH(polling_alone_rebuilds_the_world_after_a_restart),
        OVER_BOTH(ready_is_said_when_the_world_is_whole), OVER_BOTH(a_daemon_that_is_gone_is_said_so)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
