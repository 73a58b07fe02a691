/* SRDF against a small URDF. */
#include "fixture.h"

#include <string.h>

static const char arm[] = "<robot name='arm'><link name='a'/><link name='b'/><link name='c'/>"
                          "<joint name='j1' type='continuous'><parent link='a'/><child link='b'/></joint>"
                          "<joint name='j2' type='continuous'><parent link='b'/><child link='c'/></joint></robot>";

static bool parse(fixture *f, const char *text, srdf *out)
{
    static urdf u;
    fixture_begin(f);
    assert_true(fixture_urdf(f, arm, &u));
    return srdf_parse(out, &f->pool, &u, text, strlen(text), "test.srdf", &f->report);
}

static void is_refused(const char *text, const char *words)
{
    fixture f;
    srdf s;
    if (parse(&f, text, &s)) fail_msg("accepted, instead of: %s", words);
    if (!strstr(f.report.error, words)) fail_msg("the error '%s' lacks: %s", f.report.error, words);
    fixture_end(&f);
}

static void states_pairs_groups_and_the_virtual_joint_are_read(void **state)
{
    (void)state;
    fixture f;
    srdf s;
    assert_true(parse(&f,
        "<robot name='arm'><group name='g'><chain base_link='a' tip_link='c'/><joint name='j1'/></group>"
        "<group_state name='up' group='g'><joint name='j2' value='0.5'/></group_state>"
        "<virtual_joint name='v' type='fixed' parent_frame='world' child_link='a'/>"
        "<disable_collisions link1='a' link2='c' reason='Never'/><disable_collisions link1='b' link2='a'/></robot>",
        &s));
    assert_int_equal(s.state_count, 1);
    assert_string_equal(s.states[0].name, "up");
    assert_int_equal(s.states[0].values[0].joint, 1);
    assert_true(s.states[0].values[0].value == 0.5);
    assert_int_equal(s.disabled_count, 2);
    assert_true(s.disabled[0].link1 == 0 && s.disabled[0].link2 == 2);
    assert_string_equal(s.disabled[0].reason, "Never");
    assert_string_equal(s.disabled[1].reason, "no reason given");
    assert_int_equal(s.groups[0].member_count, 2);
    assert_string_equal(s.virtual_parent, "world");
    fixture_end(&f);
}

static void unknown_joints_are_refused_and_unknown_links_warned_of(void **state)
{
    (void)state;
    is_refused(
        "<robot name='arm'>\n<group_state name='s' group='g'>\n<joint name='jx' value='0'/></group_state></robot>",
        "test.srdf:3: the joint 'jx' is not in test.urdf");
    is_refused("<robot name='arm'><group_state name='s' group='g'><joint name='j1' value='nan'/></group_state></robot>",
        "finite");
    is_refused("<robot name='arm'><group_state name='s' group='g'><joint name='j1'/></group_state></robot>", "'value'");
    fixture f;
    srdf s;
    assert_true(parse(&f, "<robot name='arm'><disable_collisions link1='a' link2='x' reason='Never'/></robot>", &s));
    assert_int_equal(s.disabled_count, 0);
    assert_non_null(strstr(f.warning, "'x'"));
    fixture_end(&f);
}

static void an_srdf_of_another_robot_is_warned_of(void **state)
{
    (void)state;
    fixture f;
    srdf s;
    assert_true(parse(&f, "<robot name='leg'/>", &s));
    assert_non_null(strstr(f.warning, "'leg'"));
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(states_pairs_groups_and_the_virtual_joint_are_read),
        cmocka_unit_test(unknown_joints_are_refused_and_unknown_links_warned_of),
        cmocka_unit_test(an_srdf_of_another_robot_is_warned_of),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
