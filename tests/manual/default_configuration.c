/* default_configuration: the file that is installed changes nothing, as it is and with every setting uncommented. */
#include "service/config.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static void as_it_is_it_gives_the_defaults(void **state)
{
    (void)state;
    config expected, got;
    char why[2048] = "";
    config_default(&expected);
    config_default(&got);
    assert_int_equal(config_read(&got, DEFAULTS, why, sizeof why), 0);
    assert_memory_equal(&expected, &got, sizeof got);
}

/* Begins with zeros instead of defaults, so that a key that is not there is noticed. */
static void uncommented_it_gives_each_default(void **state)
{
    (void)state;
    config expected, got = {0};
    char line[4096], why[2048] = "";
    size_t settings = 0, count;
    config_default(&expected);
    memset(&got, 0, sizeof got);
    FILE *file = fopen(DEFAULTS, "r");
    assert_non_null(file);
    while (fgets(line, sizeof line, file)) {
        if (line[0] != '#' || line[1] == ' ' || !strchr(line, '=')) continue;
        if (config_parse(&got, line + 1, strlen(line + 1), DEFAULTS, why, sizeof why) != 0) fail_msg("%s", why);
        settings++;
    }
    fclose(file);
    (void)config_options(&count);
    assert_int_equal(settings, count);
    assert_memory_equal(&expected, &got, sizeof got);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_it_is_it_gives_the_defaults),
        cmocka_unit_test(uncommented_it_gives_each_default),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
