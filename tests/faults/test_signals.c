/* How the daemon ends: in order at the first SIGTERM or SIGINT, at once at the second, and never not at all. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <unistd.h>

static void ends_in_order(const char *uri, int number)
{
    pid_t daemon = rig_daemon(NULL, NULL);
    collided *c = rig_connect(uri, 2, COLLIDED_REMOVE);
    heard h;
    rig_box(c, "table", 0);
    rig_box(c, "part", 0.5);
    rig_watch(c, &h, "part");
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    rig_kill(daemon, number);
    UNTIL(c, RIG_PATIENCE_S, h.closing);
    assert_int_equal(h.touching, 0);
    assert_int_equal(h.kinds[COLLIDED_END], 1);
    assert_string_equal(h.cause[COLLIDED_END], "shutdown");
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
    rig_close(c);
}

static void sigterm_ends_every_contact_and_closes_the_streams(void **state)
{
    ends_in_order(*state, SIGTERM);
}
static void sigint_does_so_too(void **state)
{
    ends_in_order(*state, SIGINT);
}

static void two_in_a_row_never_hang(void **state)
{
    for (int round = 0; round < 3; round++) {
        pid_t daemon = rig_daemon(NULL, NULL);
        collided *c = rig_connect(*state, 2, COLLIDED_REMOVE);
        rig_kill(daemon, SIGTERM);
        usleep((useconds_t)(round * 1000));
        kill(daemon, SIGINT); /* it may have ended by now */
        int status = rig_wait(daemon, RIG_PATIENCE_S);
        if (status != 0 && status != 128 + SIGINT && status != 128 + SIGTERM) fail_msg("status %d", status);
        rig_close(c);
    }
}

/* Its gateway stands still and takes nothing: the one thing that ending in order has to wait for. */
static void a_gateway_that_stands_still_does_not_keep_it(void **state)
{
    pid_t daemon = rig_daemon(NULL, NULL);
    collided *c = rig_connect(*state, 2, COLLIDED_REMOVE);
    pid_t gateway = rig_child(daemon);
    assert_true(gateway > 0);
    rig_kill(gateway, SIGSTOP);
    double began = rig_now_s();
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
    printf("ended after %.2f s beside a gateway that stands still\n", rig_now_s() - began);
    assert_int_equal(kill(gateway, 0), -1); /* it is not left behind */
    rig_close(c);
}

/* Ending in order would take half a second, and its status is 0. A busy machine may let that come first now and then.
 */
static void a_second_signal_ends_at_once(void **state)
{
    int status = 0;
    for (int tries = 0; tries < 5 && status == 0; tries++) {
        pid_t daemon = rig_daemon(NULL, NULL);
        collided *c = rig_connect(*state, 10, COLLIDED_REMOVE);
        rig_kill(rig_child(daemon), SIGSTOP);
        rig_kill(daemon, SIGTERM);
        rig_kill(daemon, SIGINT); /* two of one kind might be told as one */
        status = rig_wait(daemon, RIG_PATIENCE_S);
        rig_close(c);
    }
    if (status != 128 + SIGINT && status != 128 + SIGTERM) fail_msg("status %d", status);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER_BOTH(sigterm_ends_every_contact_and_closes_the_streams),
        OVER_BOTH(sigint_does_so_too), OVER(two_in_a_row_never_hang, RIG_DDS),
        OVER(a_gateway_that_stands_still_does_not_keep_it, RIG_DDS), OVER(a_second_signal_ends_at_once, RIG_DDS)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
