/* Numbers and names as text. */
#include "fixture.h"

#include "loaders/text.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>

static void numbers_are_decimal_finite_and_whole(void **state)
{
    (void)state;
    double v = 0;
    assert_true(text_number("-1.5e-3", &v) && v == -1.5e-3);
    static const char *const bad[] = {
        "", " 1", "1 ", "nan", "inf", "-inf", "1e999", "0x10", "1,5", "1.5x", "--1", "e5"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (text_number(bad[i], &v)) fail_msg("'%s' was taken as a number", bad[i]);
}

static void numbers_do_not_follow_the_locale(void **state)
{
    (void)state;
    double v = 0;
    bool comma = setlocale(LC_NUMERIC, "de_DE.UTF-8") != NULL;
    if (!comma) print_message("skipped in part: there is no locale de_DE.UTF-8 here\n");
    assert_true(!comma || strtod("0,25", NULL) == 0.25); /* the locale is what it is called */
    assert_true(text_number("0.25", &v) && v == 0.25);
    assert_false(text_number("0,25", &v));
    setlocale(LC_NUMERIC, "C");
}

static void lists_tell_how_many_there_were(void **state)
{
    (void)state;
    double v[3];
    assert_int_equal(text_numbers("  1 2\t3\n", " \t\n", v, 3), 3);
    assert_true(v[0] == 1 && v[1] == 2 && v[2] == 3);
    assert_int_equal(text_numbers("1 2 3 4 5", " ", v, 3), 5);
    assert_int_equal(text_numbers("", " ", v, 3), 0);
    assert_int_equal(text_numbers("1 x", " ", v, 3), -1);
}

static void names_that_are_patterns_are_refused(void **state)
{
    (void)state;
    char most[129];
    memset(most, 'n', sizeof most);
    most[128] = '\0';
    assert_non_null(text_name_fault(most));
    most[127] = '\0';
    assert_null(text_name_fault(most));
    assert_non_null(text_name_fault(""));
    assert_non_null(text_name_fault("a*"));
    assert_non_null(text_name_fault("a?"));
    assert_non_null(text_name_fault("group:a"));
    assert_non_null(text_name_fault("a\nb"));
}

/* The oracle: the definition, by recursion. */
static bool matches(const char *p, const char *n)
{
    if (*p == '*') return matches(p + 1, n) || (*n && matches(p, n + 1));
    return *n ? (*p == '?' || *p == *n) && matches(p + 1, n + 1) : !*p;
}

static void patterns_match_as_their_definition_says(void **state)
{
    (void)state;
    uint64_t seed = 7;
    int matched = 0;
    for (int i = 0; i < 20000; i++) {
        char pattern[7] = "", name[8] = "";
        for (int k = 0; k < 6; k++) pattern[k] = "ab*?*a\0"[(seed = seed * 6364136223846793005u + 1) >> 33 & 3];
        for (int k = 0; k < 7; k++) name[k] = "ab"[(seed = seed * 6364136223846793005u + 1) >> 40 & 1];
        pattern[(seed >> 35) % 7] = '\0';
        name[(seed >> 45) % 8] = '\0';
        assert_int_equal(text_matches(pattern, name), matches(pattern, name));
        matched += matches(pattern, name);
    }
    assert_in_range(matched, 1000, 19000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_decimal_finite_and_whole),
        cmocka_unit_test(numbers_do_not_follow_the_locale),
        cmocka_unit_test(lists_tell_how_many_there_were),
        cmocka_unit_test(names_that_are_patterns_are_refused),
        cmocka_unit_test(patterns_match_as_their_definition_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
