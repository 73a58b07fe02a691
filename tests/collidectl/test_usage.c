/* Wrong usage: EX_USAGE and one line that says what to do; help lists every option; no daemon: EX_UNAVAILABLE. */
#include "run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

static void wrong_usage_is_told_in_one_line(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *words;
    } cases[] = {
        {"", "no verb was given"},
        {"dance", "unknown verb 'dance'"},
        {"--colour red status", "unknown option '--colour'"},
        {"status --srdf x", "--srdf is not an option of 'status', but of: load"},
        {"--json status", "--json is not an option of ''"},
        {"status now", "too many arguments"},
        {"status --wait", "--wait needs a value: --wait S"},
        {"status --wait soon", "number from 0 to 86400"},
        {"status --wait -1", "number from 0 to 86400"},
        {"status --timeout nan", "number from 0.01"},
        {"status --json=yes", "--json takes no value"},
        {"--as ../x status", "--as '../x'"},
        {"--connect http://x status", "must begin with dds:// or lcm://"},
        {"load", "too few arguments"},
        {"load a.stl", "neither .urdf nor .yaml"},
        {"load " DATA "/scene.yaml --state high", "a scene says itself"},
        {"load a.urdf --package x", "NAME=PATH"},
        {"load a.urdf --pose 1,2", "X,Y,Z"},
        {"load a.urdf --pose 0,0,0,0,0,0,0", "unit quaternion"},
        {"remove", "too few arguments"},
        {"move a", "too few arguments"},
        {"move a 1,2", "X,Y,Z"},
        {"move a 1,2,inf", "X,Y,Z"},
        {"joints --state high", "say of which robot"},
        {"watch a", "too many arguments"},
        {"watch --facts smell", "touch,distance,manifold,impact,predict"},
        {"watch --facts predict --horizon 0", "number from 0.001 to 86400"},
        {"move a 1,2,3 --linear 1,2", "--linear '1,2': must be X,Y,Z"},
        {"move a 1,2,3 --angular 1,nan,3", "--angular '1,nan,3': must be X,Y,Z"},
        {"load a.urdf --teleport", "--teleport is not an option of 'load', but of: move"},
        {"watch --rate fast", "number from 0"},
        {"watch --tolerance 1e-6 --relative 1e-6", "--tolerance and --relative: say one of them"},
        {"watch --accuracy boxes --tolerance 0", "--tolerance says nothing under --accuracy boxes"},
        {"watch --accuracy verdict --relative 1e-3", "--relative says nothing under --accuracy verdict"},
        {"query", "too few arguments"},
        {"query mood", "none of ray, distance"},
        {"query distance a", "query distance A B"},
        {"query ray 0,0,0 0,0,0", "direction is zero"},
        {"query ray 0,0 1,0,0", "X,Y,Z"},
        {"query box 0,0,0 1,-1,1", "not negative"},
        {"query cast 0,0,0 1,1,1 0,0,0", "direction is zero"},
        {"query cast 0,0,0 1,-1,1 1,0,0", "not negative"},
        {"query cast 0,0,0 1,1,1", "collidectl query cast"},
        {"query nearest a 0", "1 to 4096"},
        {"query nearest a 2.5", "1 to 4096"},
        {"query sweep a", "--linear X,Y,Z or --angular X,Y,Z"},
        {"query sweep", "query sweep BODY --linear"},
        {"query sweep a --linear 1,0,0 --span 0", "number from 1e-06 to 86400"},
        {"query bodies a b", "query bodies [PATTERN]"},
        {"record", "too few arguments"},
        {"record ../x", "without '/'"},
        {"replay", "too few arguments"},
        {"replay x --workers 1.5", "whole number from 1 to 64"},
        {"trade a b", "too many arguments"},
        {"trade x --workers 0", "whole number from 1 to 64"},
        {"trade x --out=", "--out ''"},
        {"trade x --seconds 5", "leave out x"},
        {"doctor now", "too many arguments"},
        {"doctor --connect dds://x", "--connect 'dds://x': must be dds://DOMAIN"},
        {"doctor --connect lcm://nowhere", "must be dds://DOMAIN"},
        {"forget", "too few arguments"},
        {"forget press", "16 hex digits"},
        {"help dance", "unknown verb 'dance'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        expect_failure(COLLIDECTL, cases[i].arguments, EX_USAGE, cases[i].words);
}

static void help_lists_the_options_of_each_verb(void **state)
{
    (void)state;
    static const struct {
        const char *verb, *options;
    } cases[] = {
        {"status", "--json --brief --wait"},
        {"top", "--json --once --seconds"},
        {"load", "--srdf --package --prefix --pose --state --joints --fixed --deadline --stay"},
        {"fit", "--srdf --package --excess --output --json"},
        {"remove", ""},
        {"move", "--linear --angular --teleport"},
        {"joints", "--state"},
        {"watch",
            "--a --b --facts --horizon --range --accuracy --tolerance --relative --hysteresis --rate --json --seconds"},
        {"query", "--json --tolerance --length --linear --angular --span"},
        {"record", "--seconds"},
        {"replay", "--speed --workers --json"},
        {"trade", "--json --seconds --workers --out"},
        {"doctor", "--json --peer --list --system-root"},
        {"forget", ""},
        {"version", ""},
        {"help", ""},
    };
    static run help, option;
    run_program(COLLIDECTL, "help", &help);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[256], *rest = text;
        assert_non_null(strstr(help.out, cases[i].verb));
        snprintf(text, sizeof text, "help %s", cases[i].verb);
        run_program(COLLIDECTL, text, &option);
        assert_int_equal(option.status, EX_OK);
        snprintf(text, sizeof text, "--connect --as --timeout --help %s", cases[i].options);
        for (char *word; (word = strtok_r(rest, " ", &rest));) {
            char line[64];
            snprintf(line, sizeof line, "\n  %s ", word);
            if (!strstr(option.out, line)) fail_msg("help %s lacks %s", cases[i].verb, word);
        }
        snprintf(text, sizeof text, "%s --help", cases[i].verb);
        run_program(COLLIDECTL, text, &help);
        assert_string_equal(help.out, option.out);
        run_program(COLLIDECTL, "--help", &help);
        assert_int_equal(help.status, EX_OK);
    }
}

static void missing_and_bad_files_are_told(void **state)
{
    (void)state;
    expect_failure(COLLIDECTL, "load missing.urdf", EX_NOINPUT, "load: missing.urdf: No such file");
    expect_failure(COLLIDECTL, "replay missing.log", EX_NOINPUT, "replay: missing.log: No such file");
    expect_failure(COLLIDECTL, "trade missing.log", EX_NOINPUT, "trade: missing.log: No such file");
    expect_failure(COLLIDECTL, "trade " DATA, EX_NOINPUT, "not a file");
    expect_failure(COLLIDECTL, "load " DATA "/arm.urdf --srdf missing.srdf", EX_DATAERR, "missing.srdf: No such file");
    expect_failure(COLLIDECTL, "load " DATA "/arm.urdf --state high", EX_DATAERR, "add --srdf FILE");
    expect_failure(
        COLLIDECTL, "load " DATA "/arm.urdf --srdf " DATA "/arm.srdf --state low", EX_DATAERR, "it has: high");
    expect_failure(COLLIDECTL, "load " DATA "/arm.urdf --joints tail=1", EX_DATAERR, "no joint 'tail'");
    expect_failure(COLLIDECTL, "move nobody 0,0,0", EX_DATAERR, "was not loaded");
    expect_failure(COLLIDECTL, "joints nobody a=1", EX_DATAERR, "load its URDF first");
}

/* Each would wait for a writer, without end: the alarm ends this program then. */
static void a_fifo_is_no_file(void **state)
{
    (void)state;
    char folder[] = "/tmp/collided-usage-XXXXXX", fifo[64], arguments[256];
    static const char *const verbs[] = {"load %s/fifo.urdf", "load %s/fifo.yaml",
        "load " DATA "/arm.urdf --srdf %s/fifo.urdf", "trade %s/fifo.urdf", "replay %s/fifo.urdf"};
    assert_non_null(mkdtemp(folder));
    alarm(30);
    for (int i = 0; i < 2; i++) {
        snprintf(fifo, sizeof fifo, "%s/fifo.%s", folder, i ? "yaml" : "urdf");
        assert_int_equal(mkfifo(fifo, 0600), 0);
    }
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++) {
        snprintf(arguments, sizeof arguments, verbs[i], folder); /* NOLINT(clang-diagnostic-format-nonliteral) */
        expect_failure(COLLIDECTL, arguments, i < 3 ? EX_DATAERR : EX_NOINPUT, "not a file");
    }
    snprintf(arguments, sizeof arguments, "--config %s/fifo.urdf", folder);
    expect_failure(COLLIDED, arguments, EX_NOINPUT, "is not a file, but a FIFO: name a readable file with --config");
    snprintf(arguments, sizeof arguments, "--replay %s/fifo.urdf", folder);
    expect_failure(COLLIDED, arguments, EX_NOINPUT, "not a file: name a recording");
    alarm(0);
    unlink(fifo);
    snprintf(fifo, sizeof fifo, "%s/fifo.urdf", folder);
    unlink(fifo);
    assert_int_equal(rmdir(folder), 0);
}

static void no_daemon_is_told_with_what_to_do(void **state)
{
    (void)state;
    static const char *const verbs[] = {"status", "load " DATA "/arm.urdf", "watch", "query bodies", "record x"};
    for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++) {
        char arguments[512];
        snprintf(arguments, sizeof arguments, "--connect dds://97 --timeout 0.1 %s", verbs[i]);
        expect_failure(COLLIDECTL, arguments, EX_UNAVAILABLE, "start the daemon by 'collided'");
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(wrong_usage_is_told_in_one_line),
        cmocka_unit_test(help_lists_the_options_of_each_verb),
        cmocka_unit_test(missing_and_bad_files_are_told),
        cmocka_unit_test(a_fifo_is_no_file),
        cmocka_unit_test(no_daemon_is_told_with_what_to_do),
    };
    return cmocka_run_group_tests(tests, run_make_state, run_remove_state);
}
