/* What the verbs ask of the client library, over several runs under one name. */
#include "run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

static run r;

static void ask(const char *arguments)
{
    run_program(COLLIDECTL_FAKED, arguments, &r);
    if (r.status != EX_OK) fail_msg("'%s': status %d: %s", arguments, r.status, r.err);
}

static void says(const char *words)
{
    if (!strstr(r.err, words)) fail_msg("'%s' lacks: %s", r.err, words);
}

static void prints(const char *words)
{
    if (!strstr(r.out, words)) fail_msg("'%s' lacks: %s", r.out, words);
}

static void a_later_run_goes_on_with_the_same_bodies(void **state)
{
    (void)state;
    ask("load " DATA "/arm.urdf --srdf " DATA "/arm.srdf --pose 0,0,5");
    says(", keep\n");
    says("create 0 base\n");
    says("create 1 boom\n");
    prints("2 bodies, 1 robots");
    ask("load " DATA "/scene.yaml");
    says("create 2 table top\n");
    says("create 3 left_base\n");
    ask("load " DATA "/arm.urdf"); /* again: the same numbers */
    says("create 0 base\n");
    says("create 1 boom\n");
    ask("load " DATA "/arm.urdf --srdf " DATA "/arm.srdf --pose 0,0,5");
    ask("joints arm lift=0.5");
    says("publish 2\npose 0 0.000 0.000 5.000 1.000\npose 1 0.000 0.000 6.500 1.000\n");
    ask("joints arm --state high");
    says("pose 1 0.000 0.000 6.750 1.000\n");
    ask("joints left_arm lift=0");
    says("pose 4 1.000 0.000 1.000 1.000\n");
    ask("move left_base -1,2,3,0,1,0,0");
    says("pose 3 -1.000 2.000 3.000 0.000\n");
}

static void ground_comes_from_a_file_of_heights(void **state)
{
    (void)state;
    ask("load " DATA "/ground.yaml");
    says("height field 2 x 3 by 0.5 x 0.25 m, -0.5 m at the end, base 2 m\n");
    says("create 0 ground\n");
    expect_failure(COLLIDECTL_FAKED, "load " DATA "/no_ground.yaml", EX_DATAERR, "none.txt");
}

/* What the last run left, with mimics and limits, for people and programs. */
static void joints_are_told(void **state)
{
    (void)state;
    ask("load " DATA "/arm.urdf --srdf " DATA "/arm.srdf");
    ask("joints");
    prints("arm\n");
    ask("joints arm lift=0.5");
    ask("joints arm");
    prints("joint  lift                                 0.500000 m    0 .. 1\n");
    prints("state  high                             all\n");
    assert_null(strstr(r.out, "beyond"));
    ask("joints arm --json");
    prints("{\"joint\":\"lift\",\"value\":0.5,\"unit\":\"m\",\"lower\":0,\"upper\":1}\n");
    prints("{\"state\":\"high\",\"group\":\"all\"}\n");
    ask("joints arm lift=1.5");
    ask("joints arm");
    prints("beyond its limits");
    ask("joints --json");
    prints("{\"robot\":\"arm\",\"urdf\":\"");
    expect_failure(COLLIDECTL_FAKED, "joints nobody", EX_DATAERR, "load its URDF first");
}

static void removed_bodies_are_forgotten_and_numbers_not_used_again(void **state)
{
    (void)state;
    ask("load " DATA "/arm.urdf");
    ask("remove b?se");
    says("remove 0\n");
    prints("base\n");
    expect_failure(COLLIDECTL_FAKED, "move nobody 0,0,0", EX_DATAERR, "was not loaded");
    run_program(COLLIDECTL_FAKED, "joints arm lift=0", &r);
    assert_int_equal(r.status, EX_DATAERR);
    says("the link 'base' was removed");
    ask("load " DATA "/arm.urdf");
    says("create 2 base\n");
    says("create 1 boom\n");
}

static void names_keep_their_bodies_apart(void **state)
{
    (void)state;
    ask("--as one load " DATA "/arm.urdf");
    const char *id = strstr(r.err, "id ");
    char first[32] = "";
    assert_non_null(id);
    strncat(first, id, strcspn(id, ","));
    ask("--as one move boom 0,0,0");
    says(first);
    run_program(COLLIDECTL_FAKED, "--as two move boom 0,0,0", &r);
    assert_int_equal(r.status, EX_DATAERR);
}

static void refused_bodies_are_not_remembered(void **state)
{
    (void)state;
    setenv("FAKE_REFUSES", "boom", 1);
    run_program(COLLIDECTL_FAKED, "load " DATA "/arm.urdf", &r);
    unsetenv("FAKE_REFUSES");
    assert_int_equal(r.status, EX_DATAERR);
    says("the daemon refused: Body 1: name_taken: it is another client's");
    run_program(COLLIDECTL_FAKED, "move base 0,0,0", &r);
    assert_int_equal(r.status, EX_DATAERR);
}

static void with_stay_bodies_live_as_long_as_the_process(void **state)
{
    (void)state;
    setenv("FAKE_INTERRUPTS", "1", 1);
    ask("load --stay " DATA "/arm.urdf");
    unsetenv("FAKE_INTERRUPTS");
    says(", id 0, remove\n");
    says("create 0 base\n");
    says("close\n");
    expect_failure(COLLIDECTL_FAKED, "move base 0,0,0", EX_DATAERR, "was not loaded");
}

static void status_is_a_health_check(void **state)
{
    (void)state;
    setenv("FAKE_HEALTH", "ready", 1);
    ask("status");
    says(", id 0, remove\n");
    prints("narrow_queries       123456\n");
    ask("status --json");
    prints("\"health\":\"ready\"");
    prints("\"counters\":{\"bodies\":3,\"narrow_queries\":123456}}\n");
    setenv("FAKE_STREAMS", "1", 1);
    ask("status --brief");
    unsetenv("FAKE_STREAMS");
    assert_string_equal(r.out, "ready: 3 bodies of 0 clients, 2 contacts\n"
                               "cell: 2 contacts, nearest -1.500 mm, impact possible in 0.96 s\nfar: 0 contacts\n");
    setenv("FAKE_HEALTH", "degraded", 1);
    run_program(COLLIDECTL_FAKED, "status", &r);
    assert_int_equal(r.status, EX_TEMPFAIL);
    says("the daemon is degraded, not ready");
}

static void watch_prints_an_object_a_line(void **state)
{
    (void)state;
    ask("watch --json --seconds 0.01 --facts touch,distance --range 0.5 --a x* --b group:y --rate 10");
    says("subscribe 3 x* group:y range 0.5 horizon 0 rate 10\n");
    prints("{\"event\":\"lost\",\"stream\":\"s\"");
    prints("\"a\":\"a \\\"quoted\\\"\\\\\",\"b\":\"\xc3\xa4\"");
    prints("\"points\":[{\"point\":[1,2,3],\"distance\":-0.001,\"feature\":7}]}\n");
    prints("\"lo\":null,\"hi\":null");
    int lines = 0;
    for (const char *c = r.out; *c; c++) lines += *c == '\n';
    assert_int_equal(lines, 8); /* lost, snapshot, begin, unknown, impact, predicted, averted, heartbeat */
    prints("{\"event\":\"heartbeat\",\"stream\":\"s\"");
    prints(
        "\"simulation_ns\":2500000000,\"step\":7,\"missing\":2,\"undone\":0,\"oldest_pose_ns\":1700000000000000000}\n");
    ask("watch --seconds 0.01");
    prints("begin    a \"quoted\"\\");
    prints("[-1.000000, -1.000000] mm  age 250 ms");
    prints(" alive    nothing has changed since; age of the oldest pose 500 ms\n");
    prints(" sim 2.500000 s missing  2 lock-step clients: step 7 was done without them\n");
}

static void watch_tells_impacts_and_what_is_predicted(void **state)
{
    (void)state;
    ask("watch --json --seconds 0.01 --facts impact,predict --horizon 2");
    says("subscribe 24 * * range 0 horizon 2 rate 0\n");
    prints("\"achieved\":\"certain\"");
    prints("{\"event\":\"impact\",");
    prints("\"closing_m_s\":20,\"impact\":{\"lo_s\":0.042500000000000003,\"hi_s\":0.042500001000000003,"
           "\"start_ns\":1700000000000000000,\"estimated\":false,\"pose_a\":{\"position\":[");
    prints("\"pose_b\":{\"position\":[0,0,0],\"orientation\":[1,0,0,0]}},\"points\":[]}\n");
    expect_failure(COLLIDECTL_FAKED, "watch --accuracy high", EX_USAGE, "must be boxes, tolerance or verdict");
    expect_failure(COLLIDECTL_FAKED, "watch --relative 1e-16", EX_USAGE, "1e-15 to 1");
    expect_failure(COLLIDECTL_FAKED, "watch --relative -1", EX_USAGE, "1e-15 to 1");
    expect_failure(COLLIDECTL_FAKED, "watch --tolerance nan", EX_USAGE, "from 0 to 1");
    prints("\"hi_s\":null,\"start_ns\":5,\"estimated\":true");
    prints("{\"event\":\"averted\",");
    ask("watch --seconds 0.01 --facts touch,impact --accuracy boxes --tolerance 0.001"); /* of the times */
    ask("watch --seconds 0.01 --facts touch,predict");
    says("subscribe 17 * * range 0 horizon 1 rate 0\n");
    prints("impact   bullet                   wall                     [0.04250000000, 0.04250000100] s");
    prints("within 1e-09 s; closing 20 m/s, normal 1.000000 0.000000 0.000000, at -0.050000 0.000000 0.000000\n");
    prints("predicted arm                      cart                              [0.730000, inf] s");
    prints("contact not proven, of an estimated velocity; closing 0 m/s");
    prints("averted  arm                      cart                                                 ");
}

static void moves_tell_velocities_and_teleports(void **state)
{
    (void)state;
    ask("load " DATA "/arm.urdf");
    ask("move base 1,2,3 --linear 4,0,0");
    says("publish 1\nlinear 4 0 0\npose 0 1.000");
    ask("move base 1,2,3 --teleport --angular 0,0,5");
    says("teleport: publish 1\nangular 0 0 5\npose 0 1.000");
}

static void scenes_tell_how_bodies_are_swept(void **state)
{
    (void)state;
    ask("load " DATA "/swept.yaml");
    says("create 0 bullet\nits ccd is 2, it accelerates by 3 and 0.5\n");
    says("create 1 base\nits ccd is 1, it accelerates by 2 and 0\n");
    says("create 2 boom\nits ccd is 1, it accelerates by 2 and 0\n");
}

static void queries_and_recordings_are_asked_for(void **state)
{
    (void)state;
    ask("query distance a b");
    prints("[22.13489100, 22.13489110] mm  age -\n");
    ask("query ray 0,0,0 0,0,-1 --json");
    prints("{\"query\":\"ray\",");
    prints("\"stale\":false,\"achieved\":\"certain\"}");
    ask("query sweep arm --linear 1,0,0 --span 2");
    says("arm goes by 1 0 0, 0 0 0 for 2\nquery sweep\n");
    prints("a                        in [0.02213489100, 0.02213489110] s  normal");
    ask("query sweep arm --angular 0,0,3");
    says("arm goes by 0 0 0, 0 0 3 for 1\n");
    ask("query bodies p*");
    says("query p*\n");
    ask("record session --seconds 0.01");
    says("record session\nrecord (end)\n");
    prints("recording: /var/lib/collided/session\n");
}

/* No daemon is asked. The scene that it writes loads, with the shape that was found and the rule that was proven. */
static void fitted_robots_are_loaded(void **state)
{
    (void)state;
    char words[512], path[256];
    snprintf(path, sizeof path, "%s/fitted.yaml", getenv("XDG_STATE_HOME"));
    snprintf(words, sizeof words, "fit " DATA "/arm.urdf --excess 0.05 --output %s", path);
    ask(words);
    prints("base                     sphere ");
    prints("never meet, proven: 1 of 1 pairs");
    assert_string_equal(r.err, "");
    ask("fit " DATA "/arm.urdf --srdf " DATA "/arm.srdf --excess 0.001 --json");
    prints("\"link\":\"base\",\"shape\":\"box\"");
    prints("\"verdict\":\"never meet\"");
    snprintf(words, sizeof words, "load %s", path);
    ask(words);
    prints("base                             moving  1 shape    2 rules");
    ask("joints arm lift=0.5");
    says("pose 1 0.000 0.000 1.500 1.000\n");
    expect_failure(COLLIDECTL_FAKED, "fit " DATA "/none.urdf", EX_NOINPUT, "none.urdf");
    expect_failure(COLLIDECTL_FAKED, "fit " DATA "/arm.urdf --excess 0", EX_USAGE, "--excess '0': must be a number");
    expect_failure(
        COLLIDECTL_FAKED, "fit " DATA "/arm.urdf --output /proc/no/fitted.yaml", EX_CANTCREAT, "/proc/no/fitted.yaml");
}

/* A joint without limits: nothing is known of the pair, and that is told. */
static void what_fit_does_not_decide_is_told(void **state)
{
    (void)state;
    ask("fit " DATA "/floating.urdf --excess 0.05");
    prints("never meet, proven: 0 of 1 pairs of links\n");
    prints("neither proven never to meet, nor found to: 1 (they are checked)\n"
           "  base                     boom                     not looked at\n");
}

#define WITH_STATE(test) cmocka_unit_test_setup_teardown(test, run_make_state, run_remove_state)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_STATE(a_later_run_goes_on_with_the_same_bodies),
        WITH_STATE(ground_comes_from_a_file_of_heights),
        WITH_STATE(joints_are_told),
        WITH_STATE(removed_bodies_are_forgotten_and_numbers_not_used_again),
        WITH_STATE(names_keep_their_bodies_apart),
        WITH_STATE(refused_bodies_are_not_remembered),
        WITH_STATE(with_stay_bodies_live_as_long_as_the_process),
        WITH_STATE(status_is_a_health_check),
        WITH_STATE(watch_prints_an_object_a_line),
        WITH_STATE(watch_tells_impacts_and_what_is_predicted),
        WITH_STATE(moves_tell_velocities_and_teleports),
        WITH_STATE(scenes_tell_how_bodies_are_swept),
        WITH_STATE(queries_and_recordings_are_asked_for),
        WITH_STATE(fitted_robots_are_loaded),
        WITH_STATE(what_fit_does_not_decide_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
