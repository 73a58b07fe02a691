/* 'collidectl trade' on recordings: what it prints, what it promises, the picture, and what it refuses. */
#include "recording.h"
#include "run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

static char folder[] = "/tmp/collided-trade-XXXXXX";
static const recording SESSION = {.ticks = 150, .subscription = true, .range = 0.2};
static run r;

static const char *path(const char *name)
{
    static char text[2][96];
    static int turn;
    turn = !turn;
    snprintf(text[turn], sizeof text[turn], "%s/%s", folder, name);
    return text[turn];
}

static void trade(const char *words, const char *name)
{
    char arguments[256];
    snprintf(arguments, sizeof arguments, "trade %s --out %s %s", words, path("picture"), path(name));
    run_program(COLLIDECTL, arguments, &r);
}

static double number(const char *line, const char *key)
{
    char quoted[64];
    snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(line, quoted);
    if (!at) fail_msg("no %s in: %s", key, line);
    return strtod(at + strlen(quoted), NULL);
}

static bool is_picture(const char *name, const char *begins)
{
    char head[16] = "";
    FILE *f = fopen(path(name), "r");
    if (!f) return false;
    size_t size = fread(head, 1, sizeof head - 1, f);
    fclose(f);
    return size == sizeof head - 1 && strncmp(head, begins, strlen(begins)) == 0;
}

/* The lines of one pair stand from the loosest to exact. */
static void every_pair_has_its_figures_and_finer_is_never_worse(void **state)
{
    (void)state;
    trade("--json", "session");
    if (r.status != EX_OK) fail_msg("status %d: %s", r.status, r.err);
    char before[64] = "", pair[64];
    double error = 0, events = 0, bytes[2] = {0, 0}; /* of the whole session, by boxes and exact */
    int rows = 0, pairs = 0;
    char *rest = r.out, *line;
    while ((line = strtok_r(rest, "\n", &rest)) && strncmp(line, "{\"event\":\"trade\"", 16) == 0) {
        const char *at = strstr(line, "\"pair\":\"");
        assert_non_null(at);
        snprintf(pair, sizeof pair, "%.*s", (int)strcspn(at + 8, "\""), at + 8);
        if (strcmp(pair, before) != 0) pairs++;
        if (strcmp(pair, before) == 0 && number(line, "error_max") > 1.0001 * error + 1e-15)
            fail_msg("%s: a finer accuracy has a larger error", line);
        error = number(line, "error_max");
        strcpy(before, pair);
        rows++;
        assert_true(number(line, "missed") == 0 && number(line, "outside") == 0 && number(line, "false") >= 0);
        assert_true(number(line, "measured") == 0 || number(line, "ns_mean") > 0);
        assert_true(number(line, "ns_p99") >= 0 && number(line, "error_mean") <= error);
        assert_true(number(line, "bytes_per_s") >= 0);
        events += number(line, "events");
        if (strcmp(pair, "all") != 0) continue;
        assert_true(number(line, "tick_ns_p99") >= number(line, "tick_ns_mean") / 2);
        bytes[strstr(line, "\"accuracy\":\"boxes\"") == NULL] = number(line, "bytes_per_s");
    }
    assert_true(pairs >= 12 && rows % pairs == 0 && events > 100);
    assert_string_equal(before, "all");
    assert_true(bytes[0] > 0 && bytes[0] < 0.9 * bytes[1]); /* bounds stand for a while, and are not told anew */
    assert_true(error < 1e-12);                             /* of the exact run */
    assert_non_null(line);
    assert_non_null(strstr(line, "{\"event\":\"recommendation\",\"use\":\""));
    assert_true(number(line, "ticks") == SESSION.ticks && number(line, "measured") > 100);
    assert_non_null(strstr(line, "picture.png"));
}

/* What it takes to build geometries and to find all pairs is the same at each accuracy, and much more than a tick. */
static void ticks_in_which_something_is_announced_are_left_out(void **state)
{
    (void)state;
    static const int AGAIN[] = {0, 3, -1},
                     LEFT_OUT[] = {1, 4, 0}; /* the first one; in the last case there is no other */
    for (size_t i = 0; i < sizeof AGAIN / sizeof *AGAIN; i++) {
        recording announced = SESSION;
        announced.ticks = 60;
        announced.again = AGAIN[i];
        unlink(path("announced"));
        record_session(path("announced"), &announced);
        trade("--json", "announced");
        if (r.status != EX_OK) fail_msg("status %d: %s", r.status, r.err);
        assert_true(number(r.out, "ticks") == 60 && number(r.out, "ticks_left_out") == LEFT_OUT[i]);
        assert_true(number(strstr(r.out, "\"pair\":\"all\""), "tick_ns_mean") > 0);
        trade("", "announced");
        assert_true(!strstr(r.out, "are left out") == !LEFT_OUT[i]);
    }
}

static void people_get_a_table_a_recommendation_and_a_picture(void **state)
{
    (void)state;
    trade("", "session");
    if (r.status != EX_OK) fail_msg("status %d: %s", r.status, r.err);
    const char *const words[] = {"asked at every accuracy", "accuracy      time", "missed", "false", "kB/s",
        "capsule-cone", "sphere-cylinder", "cylinder-halfspace", "\nall ", "\nuse ", " a tick", "picture: "};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++)
        if (!strstr(r.out, words[i])) fail_msg("no '%s' in: %s", words[i], r.out);
    assert_string_equal(r.err, "");
    assert_true(is_picture("picture.png", "\x89PNG\r\n") && is_picture("picture.svg", "<?xml"));
    assert_true(is_picture("picture.tsv", "# pair\taccuracy") || is_picture("picture.tsv", "# pair accuracy"));
}

static void without_gnuplot_the_data_stays_and_the_package_is_named(void **state)
{
    (void)state;
    char *old = strdup(getenv("PATH") ? getenv("PATH") : "");
    unlink(path("picture.png"));
    setenv("PATH", folder, 1);
    trade("", "session");
    setenv("PATH", old, 1);
    free(old);
    assert_int_equal(r.status, EX_OK);
    assert_non_null(strstr(r.err, "apt-get install gnuplot-nox, then: gnuplot /tmp/"));
    assert_true(is_picture("picture.tsv", "# pair") && is_picture("picture.gnuplot", "# What"));
    assert_true(access(path("picture.png"), F_OK) != 0);
    assert_null(strstr(r.out, "picture: "));
}

static void refuse(const char *name, int status, const char *words)
{
    char arguments[128];
    snprintf(arguments, sizeof arguments, "trade %s", path(name));
    expect_failure(COLLIDECTL, arguments, status, words);
}

static void what_holds_nothing_to_compare_is_refused(void **state)
{
    (void)state;
    recording unheard = SESSION, apart = SESSION, still = SESSION;
    unheard.subscription = false;
    record_session(path("unheard"), &unheard);
    refuse("unheard", EX_DATAERR, "no subscription is in it");
    apart.height = 50;
    record_session(path("apart"), &apart);
    refuse("apart", EX_DATAERR, "nothing to compare");
    still.ticks = 0;
    record_session(path("still"), &still);
    refuse("still", EX_DATAERR, "no tick is in it");
    refuse("missing", EX_NOINPUT, "No such file");
}

static void damaged_recordings_are_refused(void **state)
{
    (void)state;
    struct stat is;
    record_session(path("truncated"), &SESSION);
    assert_int_equal(stat(path("truncated"), &is), 0);
    assert_int_equal(truncate(path("truncated"), is.st_size - 10), 0);
    refuse("truncated", EX_DATAERR, "a trade needs a whole recording");
    FILE *f = fopen(path("text"), "w");
    assert_non_null(f);
    fputs("no recording at all, but long enough to be looked at as one\n", f);
    fclose(f);
    refuse("text", EX_DATAERR, "name a recording of collided");
}

static void what_cannot_be_written_is_told(void **state)
{
    (void)state;
    char arguments[256];
    snprintf(arguments, sizeof arguments, "trade --out %s/nowhere/picture %s", folder, path("session"));
    expect_failure(COLLIDECTL, arguments, EX_CANTCREAT, "another place by --out");
    expect_failure(COLLIDED, "--trade", EX_CONFIG, "what is compared is a recording");
}

static int set_up(void **state)
{
    (void)state;
    if (!mkdtemp(folder)) return -1;
    record_session(path("session"), &SESSION);
    return 0;
}

static int take_down(void **state)
{
    (void)state;
    char command[64];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command); /* NOLINT(cert-env33-c): the folder is our own */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pair_has_its_figures_and_finer_is_never_worse),
        cmocka_unit_test(ticks_in_which_something_is_announced_are_left_out),
        cmocka_unit_test(people_get_a_table_a_recommendation_and_a_picture),
        cmocka_unit_test(without_gnuplot_the_data_stays_and_the_package_is_named),
        cmocka_unit_test(what_holds_nothing_to_compare_is_refused),
        cmocka_unit_test(damaged_recordings_are_refused),
        cmocka_unit_test(what_cannot_be_written_is_told),
    };
    return cmocka_run_group_tests(tests, set_up, take_down);
}
