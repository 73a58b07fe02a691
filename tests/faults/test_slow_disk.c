/* A disk that stands still while the daemon records: the world goes on, nothing is lost, and when the disk goes on all
 * of it is in the recording. Who ends a recording: who began it, and the operator. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/slow_disk_XXXXXX", still[64], session[64];

/* With the disk between it and its recordings. */
static pid_t daemon_with(const char *option, const char *value)
{
    rig_need_network();
    const char *const arguments[] = {"collided", "--links", RIG_DDS, "--status-period", "0.1", "--workers", "1",
        "--log", "warning", option, value, NULL};
    setenv("LD_PRELOAD", DISK, 1);
    setenv("DISK_STILL", still, 1);
    pid_t pid = rig_start(COLLIDED, arguments);
    unsetenv("LD_PRELOAD");
    return pid;
}

static void stop_disk(void)
{
    FILE *f = fopen(still, "w");
    assert_non_null(f);
    fclose(f);
}

static int replay(const char *path)
{
    const char *const arguments[] = {"collided", "--replay", path, "--json", "--log", "error", NULL};
    return rig_wait(rig_start(COLLIDED, arguments), RIG_PATIENCE_S);
}

static void end_daemon(pid_t daemon)
{
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
}

static void a_disk_that_stands_still_holds_nobody(void **state)
{
    pid_t daemon = daemon_with("--record", session);
    collided *c = rig_connect(*state, 60, COLLIDED_REMOVE);
    heard h;
    rig_box(c, "table", 0);
    collided_body part = rig_box(c, "part", 0.5);
    rig_watch(c, &h, "part");
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    stop_disk();
    double longest_s = 0, until_s = rig_now_s() + 5;
    int64_t step = 0;
    while (rig_now_s() < until_s) {
        double began_s = rig_now_s();
        rig_move(c, part, 0.5 + 0.0001 * (double)(step % 100), step + 1);
        step++;
        UNTIL(c, RIG_PATIENCE_S, h.step == step);
        double took_s = rig_now_s() - began_s;
        if (took_s > longest_s) longest_s = took_s;
    }
    if (longest_s > 1) fail_msg("a step waited %.3f s for the disk", longest_s); /* of a busy machine; today: 5 s */
    assert_int_equal(rig_counter(c, "record_failures"), 0);
    unlink(still);
    rig_move(c, part, 3, ++step);
    UNTIL(c, RIG_PATIENCE_S, h.touching == 0 && h.step == step);
    rig_close(c);
    end_daemon(daemon);
    assert_int_equal(replay(session), 0);
    unlink(session);
}

static void ask(collided *c, const char *name, collided_status expected)
{
    collided_result result;
    collided_status status = collided_record(c, name, RIG_PATIENCE_S, &result);
    if (status != expected) fail_msg("record \"%s\": %s", name ? name : "", result.text ? result.text : "?");
    collided_result_free(&result);
}

static bool begins(collided *c, const char *name)
{
    collided_result result;
    bool begun = collided_record(c, name, RIG_PATIENCE_S, &result) == COLLIDED_OK;
    collided_result_free(&result);
    return begun;
}

static void the_recording_of_another_is_not_ended(void **state)
{
    char path[128];
    pid_t daemon = daemon_with("--record-dir", folder);
    collided *alice = rig_connect(*state, 60, COLLIDED_REMOVE), *bob = rig_connect(*state, 60, COLLIDED_REMOVE);
    rig_box(alice, "table", 0);
    ask(alice, "hers", COLLIDED_OK);
    ask(bob, NULL, COLLIDED_UNSUPPORTED);
    ask(bob, "his", COLLIDED_UNSUPPORTED);
    rig_box(alice, "other", 2);
    ask(alice, NULL, COLLIDED_OK); /* all of it is there by now */
    snprintf(path, sizeof path, "%s/hers.lcmlog", folder);
    assert_int_equal(replay(path), 0);
    ask(bob, "hers", COLLIDED_UNSUPPORTED); /* nothing is overwritten */
    unlink(path);
    ask(alice, "hers", COLLIDED_OK);
    rig_close(alice); /* it goes on; nobody may end it */
    UNTIL(bob, RIG_PATIENCE_S, rig_counter(bob, "clients") == 1);
    ask(bob, NULL, COLLIDED_UNSUPPORTED);
    rig_kill(daemon, SIGUSR1); /* but the operator */
    UNTIL(bob, RIG_PATIENCE_S, begins(bob, "his"));
    rig_close(bob);
    end_daemon(daemon);
    assert_int_equal(replay(path), 0);
    unlink(path);
    snprintf(path, sizeof path, "%s/his.lcmlog", folder);
    unlink(path);
}

static void a_recording_of_the_configuration_is_not_ended(void **state)
{
    pid_t daemon = daemon_with("--record", session);
    collided *c = rig_connect(*state, 60, COLLIDED_REMOVE);
    rig_box(c, "table", 0);
    ask(c, NULL, COLLIDED_UNSUPPORTED);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "records_refused") == 1);
    rig_close(c);
    end_daemon(daemon);
    assert_int_equal(replay(session), 0);
    unlink(session);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER(a_disk_that_stands_still_holds_nobody, RIG_DDS),
        OVER(the_recording_of_another_is_not_ended, RIG_DDS),
        OVER(a_recording_of_the_configuration_is_not_ended, RIG_DDS)};
    if (!mkdtemp(folder)) return 1;
    snprintf(still, sizeof still, "%s/still", folder);
    snprintf(session, sizeof session, "%s/session.lcmlog", folder);
    rig_isolate();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(still);
    unlink(session);
    rmdir(folder);
    return failed;
}
