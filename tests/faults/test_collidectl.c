/* collidectl against a real daemon, as people type it, over each link. */
#include "rig.h"
#include "run.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static run r;
static char recordings[] = "/tmp/collided-faults-XXXXXX";

__attribute__((format(printf, 2, 3))) static void ctl(int expected, const char *format, ...)
{
    char arguments[512];
    va_list list;
    va_start(list, format);
    int length = vsnprintf(arguments, sizeof arguments, format, list);
    va_end(list);
    if (expected == 0) snprintf(arguments + length, sizeof arguments - (size_t)length, " --timeout %g", RIG_PATIENCE_S);
    run_program(COLLIDECTL, arguments, &r);
    if (r.status != expected) fail_msg("collidectl %s: %d, not %d\n%s%s", arguments, r.status, expected, r.out, r.err);
}

static void says(const char *words)
{
    if (!strstr(r.out, words)) fail_msg("\"%s\" is not in: %s", words, r.out);
}

/* What is watched for a while may begin when that is over, on a busy machine: it is watched again. */
static void watch_until_it_says(const char *first, const char *second, const char *arguments)
{
    double end = rig_now_s() + RIG_PATIENCE_S;
    do {
        ctl(0, "watch --json %s", arguments);
    } while (!(strstr(r.out, first) && strstr(r.out, second)) && rig_now_s() < end);
    says(first);
    says(second);
}

/* The number behind "key":, for the first time. */
static double number(const char *key)
{
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(r.out, quoted);
    if (!at) fail_msg("%s is not in: %s", quoted, r.out);
    return strtod(at + strlen(quoted), NULL);
}

static void open_daemon(const char *uri)
{
    rig_daemon("--record-dir", recordings);
    assert_int_equal(setenv("COLLIDED_URI", uri, 1), 0);
    ctl(0, "status --wait 30");
}

static void without_a_daemon_it_says_so(void **state)
{
    rig_need_network();
    assert_int_equal(setenv("COLLIDED_URI", *state, 1), 0);
    ctl(69, "status --timeout 0.5");
    assert_true(r.err[0] != '\0');
    ctl(69, "query bodies --timeout 0.5");
    ctl(69, "load --timeout 0.5 " DATA "/crane.urdf");
}

static void a_robot_is_loaded_moved_asked_about_and_removed(void **state)
{
    open_daemon(*state);
    ctl(0, "status --json");
    says("\"ready\"");
    says("\"lcm_gateway_restarts\":0");
    ctl(0, "load --srdf " DATA "/crane.srdf " DATA "/crane.urdf");

    ctl(0, "query bodies --json");
    says("\"mast\"");
    says("\"jib\"");
    says("\"hook\"");
    ctl(0, "query distance mast hook --json"); /* x: 2 - 0.1 - 0.1, level with the mast's top */
    assert_true(number("lo") <= 1.8 && number("hi") >= 1.8 && number("hi") - number("lo") < 2e-6);
    ctl(0, "query explain mast jib");
    says("Adjacent");
    ctl(0, "query box 2,0,0.5 0.1,0.1,0.1 --json");
    says("\"hook\"");
    ctl(0, "query box 2,0,0.5 0.1,0.1,0.1"); /* how deep, not a pose that no answer has */
    says("] mm");
    ctl(0, "query ray 5,0,0.5 -1,0,0 --json");
    says("\"hook\"");
    assert_true(number("lo") <= 2.9 && number("hi") >= 2.9);

    ctl(0, "joints crane trolley=1");
    ctl(0, "query distance mast hook --json");
    assert_true(number("lo") <= 2.8 && number("hi") >= 2.8);
    ctl(0, "move hook 0,0,5");
    ctl(0, "query distance mast hook --json");
    assert_true(number("lo") <= 4.4 && number("hi") >= 4.4); /* z: 5 - 0.1 - 0.5 */
    ctl(0, "move hook 0,0,0.5");
    watch_until_it_says("\"snapshot\"", "\"begin\"", "--seconds 1");
    ctl(0, "remove hook");
    ctl(0, "query bodies --json");
    if (strstr(r.out, "\"hook\"")) fail_msg("removed, yet there: %s", r.out);
    ctl(65, "query distance mast nobody --timeout 30");
}

static void count_events(void *context, const collided_batch *batch)
{
    *(size_t *)context += batch->event_count;
}

static void impacts_are_predicted_and_found_by_hand(void **state)
{
    size_t impacts = 0;
    open_daemon(*state);
    ctl(0, "load " DATA "/range.yaml");
    ctl(0, "query sweep bullet --linear 20,0,0 --json"); /* from -1 to -0.15 */
    says("\"wall\"");
    assert_true(number("lo") <= 0.0425 && number("hi") >= 0.0425 && number("hi") - number("lo") < 1e-6);
    ctl(0, "query sweep bullet --linear 20,0,0 --span 0.04");
    says("none\n");

    ctl(0, "move bullet -1,0,0 --linear 2,0,0");
    watch_until_it_says("{\"event\":\"predicted\"", "}", "--seconds 0.5 --facts predict --horizon 2");
    assert_true(number("lo_s") <= 0.425 && number("hi_s") >= 0.425 && fabs(number("closing_m_s") - 2) < 1e-6);
    ctl(0, "watch --json --seconds 0.5 --facts predict --horizon 0.4");
    if (strstr(r.out, "predicted")) fail_msg("it is beyond the horizon: %s", r.out);

    collided *c = rig_connect(*state, 10, COLLIDED_REMOVE);
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = COLLIDED_IMPACT;
    def.callback = count_events;
    def.context = &impacts;
    assert_int_not_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
    assert_int_equal(collided_sync(c, RIG_PATIENCE_S), COLLIDED_OK);
    ctl(0, "move bullet 1,0,0 --teleport");
    ctl(0, "move bullet -1,0,0");
    UNTIL(c, RIG_PATIENCE_S, impacts == 1);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "impacts") == 1);
    ctl(0, "status --json");
    says("\"impacts\":1,\"predicted\":1,\"undecided_sweeps\":0");
    rig_close(c);
}

static void a_recording_replays_to_the_same_hash_for_any_number_of_workers(void **state)
{
    char first[64] = "", hash[64];
    open_daemon(*state);
    ctl(0, "load --srdf " DATA "/crane.srdf " DATA "/crane.urdf");
    collided *c = rig_connect(*state, 10, COLLIDED_REMOVE);
    collided_body box = rig_box(c, "box", 5), other = rig_box(c, "other", 5.5);
    heard h;
    rig_watch(c, &h, "*");
    UNTIL(c, RIG_PATIENCE_S, h.touching > 0);                        /* there are contacts when it begins */
    const char *name = strcmp(*state, RIG_DDS) == 0 ? "dds" : "lcm"; /* a recording is never overwritten */
    const char *const arguments[] = {"collidectl", "record", name, "--seconds", "2.5", NULL};
    pid_t recorder = rig_start(COLLIDECTL, arguments);
    char file[80];
    snprintf(file, sizeof file, "%s/%s.lcmlog", recordings, name);
    UNTIL(c, RIG_PATIENCE_S, access(file, F_OK) == 0);
    size_t batches = h.batches, ends = h.kinds[COLLIDED_END];
    for (int i = 0; i < 3; i++) ctl(0, "move hook 0.0%d,0,0.5", i);
    ctl(0, "joints crane slew=1");
    assert_int_equal(rig_move(c, box, 5.1, 0), COLLIDED_OK);
    assert_int_equal(rig_move(c, other, 9, 0), COLLIDED_OK);
    UNTIL(c, RIG_PATIENCE_S, h.batches > batches && h.kinds[COLLIDED_END] > ends);
    rig_close(c);
    assert_int_equal(rig_wait(recorder, RIG_PATIENCE_S), 0);
    for (int workers = 1; workers <= 4; workers *= 2) {
        ctl(0, "replay --json --workers %d %s/%s.lcmlog", workers, recordings, name);
        const char *at = strstr(r.out, "hash\":");
        if (!at) fail_msg("no hash: %s", r.out);
        snprintf(hash, sizeof hash, "%.*s", (int)strcspn(at, ",}"), at);
        if (!*first) snprintf(first, sizeof first, "%s", hash);
        assert_string_equal(hash, first);
    }
    printf("%s", r.out);
}

/* One that the daemon records for it. */
static void the_running_session_is_weighed(void **state)
{
    char out[64], file[80];
    open_daemon(*state);
    ctl(0, "load --srdf " DATA "/crane.srdf " DATA "/crane.urdf");
    collided *c = rig_connect(*state, 10, COLLIDED_REMOVE);
    heard h;
    rig_watch(c, &h, "*");
    snprintf(out, sizeof out, "%s/weighed", recordings);
    const char *const arguments[] = {"collidectl", "trade", "--seconds", "1", "--out", out, NULL};
    pid_t weigher = rig_start(COLLIDECTL, arguments);
    for (int i = 0; i < 6; i++) ctl(0, "move hook 0.0%d,0,0.5", i);
    rig_close(c);
    assert_int_equal(rig_wait(weigher, RIG_PATIENCE_S), 0);
    snprintf(file, sizeof file, "%s.tsv", out);
    assert_int_equal(access(file, R_OK), 0);
}

static int set_up(void **state)
{
    (void)state;
    return mkdtemp(recordings) ? 0 : -1;
}

static int take_down(void **state)
{
    char command[64];
    snprintf(command, sizeof command, "rm -rf '%s'", recordings);
    return system(command) + run_remove_state(state); /* NOLINT(cert-env33-c): the folder is our own */
}

#define WITH_STATE(test, uri)                                                                                          \
    {                                                                                                                  \
#test " over " uri, test, run_make_state, end, (void *)(uintptr_t)(uri)                                        \
    }

static int end(void **state)
{
    rig_end_all(state);
    return run_remove_state(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {WITH_STATE(without_a_daemon_it_says_so, RIG_DDS),
        WITH_STATE(without_a_daemon_it_says_so, RIG_LCM),
        WITH_STATE(a_robot_is_loaded_moved_asked_about_and_removed, RIG_DDS),
        WITH_STATE(a_robot_is_loaded_moved_asked_about_and_removed, RIG_LCM),
        WITH_STATE(impacts_are_predicted_and_found_by_hand, RIG_DDS),
        WITH_STATE(impacts_are_predicted_and_found_by_hand, RIG_LCM),
        WITH_STATE(a_recording_replays_to_the_same_hash_for_any_number_of_workers, RIG_DDS),
        WITH_STATE(a_recording_replays_to_the_same_hash_for_any_number_of_workers, RIG_LCM),
        WITH_STATE(the_running_session_is_weighed, RIG_DDS)};
    rig_isolate();
    return cmocka_run_group_tests(tests, set_up, take_down);
}
