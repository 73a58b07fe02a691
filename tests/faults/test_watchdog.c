/* A daemon under a service manager (manager.h): it is started again after a watchdog or a crash. */
#include "manager.h"
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
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

/* ---- what it died over ---- */

static manager *start_hanging(double watchdog_s)
{
    rig_need_network();
    manager *m = manager_start_program(HANGING_DAEMON, PLAIN, watchdog_s, MANAGER_PAUSE_S);
    manager_await(m, 0, RIG_PATIENCE_S);
    return m;
}

static bool has_limit(collided *c, const char *text)
{
    collided_daemon_status s;
    return collided_get_status(c, 0, &s) == COLLIDED_OK && strstr(s.limits, text);
}

/* -1 where no Status has come. */
static int64_t counter(collided *c, const char *name)
{
    collided_daemon_status s;
    if (collided_get_status(c, 0, &s) != COLLIDED_OK) return -1;
    for (size_t i = 0; i < s.counter_count; i++)
        if (strcmp(s.counters[i].name, name) == 0) return s.counters[i].value;
    return -1;
}

static void expect_doctor_says(const char *text)
{
    char line[2048];
    bool said = false;
    FILE *f = popen(COLLIDECTL " --connect " RIG_DDS " doctor 2>&1", "r"); /* NOLINT(cert-env33-c): a fixed line */
    assert_non_null(f);
    while (fgets(line, sizeof line, f)) said |= strstr(line, text) != NULL;
    pclose(f);
    if (!said) fail_msg("doctor does not say \"%s\"", text);
}

/* The one command is refused, and told; all else that its client announces anew is let in, and nobody is killed again.
 * `how`: as the log has to say it; NULL: it is not looked at. */
static void refused_is_what_it_died_over(const char *body, double watchdog_s, const char *how)
{
    char what[128];
    manager *m = start_hanging(watchdog_s);
    collided *c = rig_connect(RIG_DDS, 60, COLLIDED_KEEP);
    rig_box(c, "table", 0);
    rig_box(c, "part", 0.5);
    collided_flush(c);
    UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 2);
    rig_box(c, body, 9);
    collided_flush(c);
    UNTIL(c, RIG_PATIENCE_S, manager_restarts(m) == 1 && manager_is_ready(m));
    UNTIL(c, RIG_PATIENCE_S, counter(c, "suspects_refused") >= 1 && counter(c, "bodies") == 2);
    assert_int_equal(counter(c, "suspects"), 1);
    snprintf(what, sizeof what, "(\"%s\") of client", body);
    UNTIL(c, RIG_PATIENCE_S, has_limit(c, "suspect: a daemon was killed over Body") && has_limit(c, what));
    if (how) {
        assert_true(manager_said(m, how));
        assert_true(manager_said(m, what));
        assert_true(manager_said(m, "refused for 60 s"));
    }
    rig_box(c, "late", 20); /* of the same client */
    collided_flush(c);
    UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 3);
    expect_doctor_says(what);
    THROUGHOUT(c, 2.5, manager_restarts(m) == 1);
    rig_close(c);
    assert_int_equal(manager_stop(m), 0);
}

static void a_command_that_the_watchdog_killed_it_over_is_refused(void **state)
{
    (void)state;
    refused_is_what_it_died_over("hang", 1, "killed (signal 6, ");
}

static void so_is_one_that_ended_it_by_a_fault(void **state)
{
    (void)state;
    refused_is_what_it_died_over("fault", 0, "killed (signal 31, ");
}

/* SIGKILL may come from anybody, at any time: only what it came upon twice is refused, and then for twice as long. */
static void what_may_be_chance_is_refused_the_second_time(void **state)
{
    (void)state;
    char hangs[128];
    manager *m = start_hanging(0);
    snprintf(hangs, sizeof hangs, "%s/hangs", manager_folder(m));
    collided *c = rig_connect(RIG_DDS, 60, COLLIDED_KEEP);
    rig_box(c, "table", 0);
    rig_box(c, "hang", 9);
    collided_flush(c);
    for (unsigned death = 0; death < 2; death++) {
        UNTIL(c, RIG_PATIENCE_S, access(hangs, F_OK) == 0);
        unlink(hangs);
        assert_int_equal(kill(manager_pid(m), SIGKILL), 0);
        UNTIL(c, RIG_PATIENCE_S, manager_restarts(m) == death + 1 && manager_is_ready(m));
        if (death == 0) assert_true(manager_said(m, "held against nobody unless it happens again"));
        if (death == 0) assert_false(manager_said(m, "refused for"));
    }
    UNTIL(c, RIG_PATIENCE_S, counter(c, "suspects_refused") >= 1 && counter(c, "bodies") == 1);
    assert_true(manager_said(m, "2 time(s) so far: it is refused for 120 s"));
    rig_close(c);
    assert_int_equal(manager_stop(m), 0);
}

/* ---- what it was building ---- */

static void ground(collided *c, const char *name, double height)
{
    enum { ROWS = 12 }; /* too many to be built within the tick */
    double heights[ROWS * ROWS];
    for (int i = 0; i < ROWS * ROWS; i++) heights[i] = height + 0.01 * (i % 5);
    collided_shape s = collided_height_field(collided_create_height_field(c, heights, ROWS, ROWS, 0.1, 0.1, 1));
    collided_body_def b = collided_body_def_default();
    b.name = name;
    b.shapes = &s;
    b.shape_count = 1;
    b.motion = COLLIDED_FIXED;
    collided_create_body(c, &b);
    collided_flush(c);
}

static void make_file(manager *m, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", manager_folder(m), name);
    fclose(fopen(path, "we"));
}

static bool drop_file(manager *m, const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", manager_folder(m), name);
    return unlink(path) == 0;
}

/* All the rest of that client is there again, and another geometry of it is built. */
static void refused_is_what_was_built(manager *m, collided *c, unsigned restarts)
{
    UNTIL(c, RIG_PATIENCE_S, counter(c, "suspects_refused") >= 1 && counter(c, "bodies") == 1);
    assert_int_equal(counter(c, "suspects"), 1);
    UNTIL(c, RIG_PATIENCE_S, has_limit(c, "suspect: a daemon was killed over the building of Geometry"));
    ground(c, "hills", 0.5);
    UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 2);
    THROUGHOUT(c, 1, manager_restarts(m) == restarts && counter(c, "bodies") == 2);
    rig_close(c);
    assert_int_equal(manager_stop(m), 0);
}

static void ended_in_a_build(const char *file, const char *how)
{
    manager *m = start_hanging(0);
    collided *c = rig_connect(RIG_DDS, 60, COLLIDED_KEEP);
    rig_box(c, "table", 0);
    collided_flush(c);
    UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 1);
    make_file(m, file);
    ground(c, "ground", 0);
    UNTIL(c, RIG_PATIENCE_S, manager_restarts(m) == 1 && manager_is_ready(m));
    drop_file(m, file);
    assert_true(manager_said(m, how));
    assert_true(manager_said(m, "while it carried out the building of Geometry"));
    refused_is_what_was_built(m, c, 1);
}

static void a_geometry_that_faults_while_it_is_built_is_refused(void **state)
{
    (void)state;
    ended_in_a_build("build_faults", "killed (signal 31, ");
}

static void so_is_one_that_takes_all_memory(void **state)
{
    (void)state;
#ifdef __SANITIZE_ADDRESS__
    print_message("skipped: the sanitizer ends a process that has no memory in a way of its own\n");
    skip();
#endif
    ended_in_a_build("build_fills", ": out of memory) while it carried out the building");
}

/* The kernel, when it has no memory, sends SIGKILL, too. */
static void a_build_that_was_killed_over_twice_is_refused(void **state)
{
    (void)state;
    manager *m = start_hanging(0);
    collided *c = rig_connect(RIG_DDS, 60, COLLIDED_KEEP);
    rig_box(c, "table", 0);
    make_file(m, "build_hangs");
    ground(c, "ground", 0);
    for (unsigned death = 0; death < 2; death++) {
        UNTIL(c, RIG_PATIENCE_S, drop_file(m, "hangs"));
        UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 1); /* it does something else */
        assert_int_equal(kill(manager_pid(m), SIGKILL), 0);
        UNTIL(c, RIG_PATIENCE_S, manager_restarts(m) == death + 1 && manager_is_ready(m));
        if (death == 0) assert_false(manager_said(m, "refused for"));
    }
    drop_file(m, "build_hangs");
    assert_true(manager_said(m, "2 time(s) so far: it is refused for 120 s"));
    refused_is_what_was_built(m, c, 2);
}

/* In order, or while nothing was carried out. */
static void an_end_between_commands_is_nobodys_fault(void **state)
{
    (void)state;
    manager *m = start_hanging(0);
    collided *c = rig_connect(RIG_DDS, 60, COLLIDED_KEEP);
    rig_box(c, "table", 0);
    collided_flush(c);
    UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 1);
    kill(manager_pid(m), SIGABRT);
    UNTIL(c, RIG_PATIENCE_S, manager_restarts(m) == 1 && manager_is_ready(m));
    UNTIL(c, RIG_PATIENCE_S, counter(c, "bodies") == 1);
    assert_true(manager_said(m, "not while it carried out a command"));
    assert_int_equal(counter(c, "suspects"), 0);
    rig_close(c);
    assert_int_equal(manager_stop(m), 0);
}

int main(void)
{
    rig_isolate();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_daemon_that_hangs_is_killed_and_started_again, manager_end_all),
        cmocka_unit_test_teardown(a_wrong_option_is_not_tried_again, manager_end_all),
        cmocka_unit_test_teardown(a_command_that_the_watchdog_killed_it_over_is_refused, manager_end_all),
        cmocka_unit_test_teardown(so_is_one_that_ended_it_by_a_fault, manager_end_all),
        cmocka_unit_test_teardown(what_may_be_chance_is_refused_the_second_time, manager_end_all),
        cmocka_unit_test_teardown(a_geometry_that_faults_while_it_is_built_is_refused, manager_end_all),
        cmocka_unit_test_teardown(so_is_one_that_takes_all_memory, manager_end_all),
        cmocka_unit_test_teardown(a_build_that_was_killed_over_twice_is_refused, manager_end_all),
        cmocka_unit_test_teardown(an_end_between_commands_is_nobodys_fault, manager_end_all),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
