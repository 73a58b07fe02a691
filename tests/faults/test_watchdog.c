/* A daemon under a service manager (manager.h): it is started again after a watchdog or a crash. */
#include "manager.h"
#include "rig.h"

#include <signal.h>
#include <unistd.h>

#define ORDINARY "--links", RIG_DDS, "--status-period", "0.1", "--workers", "1"

static const char *const PLAIN[] = {ORDINARY, NULL};

/* One that stands still gives no sign of life. */
static void a_daemon_that_hangs_is_killed_and_started_again(void **state)
{
    (void)state;
    rig_need_network();
    manager *m = manager_start(PLAIN, 1);
    manager_await(m, 0, RIG_PATIENCE_S);
    pid_t first = manager_pid(m);
    double end = rig_now_s() + 2.5;
    while (rig_now_s() < end) usleep(10000);
    assert_int_equal(manager_restarts(m), 0);
    rig_kill(first, SIGSTOP);
    while (manager_killed(m) == 0) usleep(2000);
    rig_kill(first, SIGCONT);
    manager_await(m, 1, RIG_PATIENCE_S);
    assert_int_not_equal(manager_pid(m), first);
    assert_true(manager_longest_silence_s(m) >= 1);
    assert_int_equal(manager_killed(m), 1);
    assert_int_equal(manager_stop(m), 0);
}

static void a_wrong_option_is_not_tried_again(void **state)
{
    (void)state;
    static const char *const WRONG[] = {"--rate=-1", NULL};
    manager *m = manager_start(WRONG, 0);
    double end = rig_now_s() + RIG_PATIENCE_S;
    while (!manager_has_ended(m) && rig_now_s() < end) usleep(2000);
    assert_true(manager_has_ended(m));
    assert_int_equal(manager_restarts(m), 0);
    assert_true(manager_said(m, "rate = \"-1\""));
    assert_int_equal(manager_stop(m), 64);
}

int main(void)
{
    rig_isolate();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_daemon_that_hangs_is_killed_and_started_again, manager_end_all),
        cmocka_unit_test_teardown(a_wrong_option_is_not_tried_again, manager_end_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
