/* The table of options: defaults, ranges, files, the command line, and what is said of errors. */
#include "service/config.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char why[2048];

static int parse(config *c, const char *text)
{
    return config_parse(c, text, strlen(text), "test.conf", why, sizeof why);
}

static void defaults_are_within_their_ranges(void **state)
{
    (void)state;
    config c;
    config_default(&c);
    assert_string_equal(c.links, "auto");
    assert_true(c.caches);
    assert_int_equal(c.max_clients, 1200);
}

static void every_number_is_taken_at_its_limits_and_refused_beyond(void **state)
{
    (void)state;
    size_t count;
    const config_option *o = config_options(&count);
    config c;
    char value[64];
    config_default(&c);
    for (size_t i = 0; i < count; i++) {
        if (o[i].type != CONFIG_WHOLE && o[i].type != CONFIG_NUMBER) continue;
        const double in[] = {o[i].least, o[i].most}, out[] = {o[i].least - 1, o[i].most + 1};
        for (int k = 0; k < 2; k++) {
            snprintf(value, sizeof value, "%.17g", in[k]);
            assert_int_equal(config_set(&c, o[i].key, value, why, sizeof why), 0);
            snprintf(value, sizeof value, "%.17g", out[k]);
            assert_int_equal(config_set(&c, o[i].key, value, why, sizeof why), -1);
            assert_non_null(strstr(why, o[i].key));
        }
        assert_int_equal(config_set(&c, o[i].key, "nan", why, sizeof why), -1);
        assert_int_equal(config_set(&c, o[i].key, "", why, sizeof why), -1);
        assert_int_equal(config_set(&c, o[i].key, "1x", why, sizeof why), -1);
    }
}

static void files_are_read_with_comments_and_spaces(void **state)
{
    (void)state;
    config c;
    config_default(&c);
    assert_int_equal(parse(&c, "# a comment\n\n  rate = 250  # Hz\r\nengine=gjk\ncaches = no"), 0);
    assert_true(c.rate == 250);
    assert_string_equal(c.engine, "gjk");
    assert_false(c.caches);
}

static void errors_name_file_line_and_what_is_allowed(void **state)
{
    (void)state;
    static const struct {
        const char *text, *says[3];
    } BAD[] = {
        {"rate = 1\nspeed = 3\n", {"test.conf:2:", "unknown key \"speed\"", "--help"}},
        {"rate = fast\n", {"test.conf:1:", "rate", "from 0 to 100000 Hz"}},
        {"\n\nengine = magic\n", {"test.conf:3:", "engine", "auto|gjk|ccd|mpr"}},
        {"caches = maybe\n", {"test.conf:1:", "caches", "yes or no"}},
        {"just words\n", {"test.conf:1:", "key = value", ""}},
        {"workers = 1.5\n", {"test.conf:1:", "whole number", "0 to 64"}},
    };
    config c;
    for (size_t i = 0; i < sizeof BAD / sizeof *BAD; i++) {
        config_default(&c);
        assert_int_equal(parse(&c, BAD[i].text), -1);
        for (int k = 0; k < 3; k++)
            if (!strstr(why, BAD[i].says[k])) fail_msg("\"%s\" does not say \"%s\"", why, BAD[i].says[k]);
    }
}

static void a_part_of_a_choice_is_no_choice(void **state)
{
    (void)state;
    config c;
    config_default(&c);
    assert_int_equal(config_set(&c, "engine", "gj", why, sizeof why), -1);
    assert_int_equal(config_set(&c, "engine", "auto|gjk", why, sizeof why), -1);
    assert_int_equal(config_set(&c, "engine", "", why, sizeof why), -1);
    assert_int_equal(config_set(&c, "engine", "mpr", why, sizeof why), 0);
}

static void the_command_line_wins_over_the_file(void **state)
{
    (void)state;
    char path[] = "/tmp/collided-test-XXXXXX";
    int fd = mkstemp(path);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, "rate = 10\nmargin = 1\n", 21), 21);
    close(fd);
    config c;
    const char *asked = NULL;
    char *args[] = {"collided", "--rate=20", "--config", path, "--json", "--max-bodies", "7", NULL};
    config_default(&c);
    assert_int_equal(config_arguments(&c, 7, args, &asked, why, sizeof why), 0);
    assert_true(c.rate == 20 && c.margin == 1 && c.json && c.max_bodies == 7);
    unlink(path);
}

static void bad_arguments_are_refused(void **state)
{
    (void)state;
    char *cases[][3] = {{"collided", "rate", NULL}, {"collided", "--rate", NULL},
        {"collided", "--config=/nonexistent", NULL}, {"collided", "--unknown=1", NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        config c;
        const char *asked = NULL;
        config_default(&c);
        assert_true(config_arguments(&c, 2, cases[i], &asked, why, sizeof why) < 0);
        assert_true(*why && !strchr(why, '\n'));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_within_their_ranges),
        cmocka_unit_test(every_number_is_taken_at_its_limits_and_refused_beyond),
        cmocka_unit_test(files_are_read_with_comments_and_spaces),
        cmocka_unit_test(errors_name_file_line_and_what_is_allowed),
        cmocka_unit_test(a_part_of_a_choice_is_no_choice),
        cmocka_unit_test(the_command_line_wins_over_the_file),
        cmocka_unit_test(bad_arguments_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
