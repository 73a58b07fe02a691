/* Name patterns and the first rule that matches. */
#include "scene.h"
#include "world/rules.h"

static bool filter_matches(const char *text, const char *name, const char *group)
{
    pattern p;
    pattern_init(&p, text);
    bool does = pattern_matches(&p, name, group);
    pattern_free(&p);
    return does;
}

static void patterns_match_as_people_expect(void **state)
{
    (void)state;
    assert_true(filter_matches("*", "", ""));
    assert_true(filter_matches("panda_*", "panda_link7", ""));
    assert_false(filter_matches("panda_*", "pand", ""));
    assert_true(filter_matches("*_link?", "panda_link7", ""));
    assert_false(filter_matches("*_link?", "panda_link", ""));
    assert_true(filter_matches("a*b*c", "a--b--b-c", ""));
    assert_false(filter_matches("a*b*c", "a--b--b-d", ""));
    assert_true(filter_matches("exact", "exact", ""));
    assert_false(filter_matches("exact", "exactly", ""));
}

static void groups_are_matched_by_prefix(void **state)
{
    (void)state;
    assert_true(filter_matches("group:arm", "x", "arm"));
    assert_true(filter_matches("group:a*", "x", "arm"));
    assert_false(filter_matches("group:arm", "arm", ""));
    assert_false(filter_matches("group:*", "x", "")); /* no group is not a group */
}

static void a_pattern_of_many_stars_ends_soon(void **state)
{
    (void)state;
    char text[128];
    memset(text, 'a', 127);
    text[127] = '\0';
    assert_false(filter_matches("*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*a*b", text, ""));
}

static void the_first_rule_that_matches_decides(void **state)
{
    (void)state;
    const filter_rule rules[] = {
        {.pattern = "panda_link5", .reason = "watch it"}, {.pattern = "panda_*", .allow = true}};
    rule_sets sets;
    uint32_t set = 0;
    rules_init(&sets);
    rules_choose(&sets, &set, rules, 2);
    assert_int_equal(rules_first(&sets, set, 1, "panda_link5", ""), 0);
    assert_int_equal(rules_first(&sets, set, 2, "panda_link6", ""), 1);
    assert_int_equal(rules_first(&sets, set, 3, "table", ""), WORLD_NONE);
    rules_choose(&sets, &set, NULL, 0);
    assert_int_equal(rules_first(&sets, set, 1, "panda_link5", ""), WORLD_NONE);
    rules_free(&sets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patterns_match_as_people_expect),
        cmocka_unit_test(groups_are_matched_by_prefix),
        cmocka_unit_test(a_pattern_of_many_stars_ends_soon),
        cmocka_unit_test(the_first_rule_that_matches_decides),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
