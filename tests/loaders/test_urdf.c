/* URDF: what is read, and what is refused with which words. */
#include "fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINK(name) "<link name='" name "'/>"
#define JOINT(name, type, parent, child, rest)                                                                         \
    "<joint name='" name "' type='" type "'><parent link='" parent "'/><child link='" child "'/>" rest "</joint>"
#define ROBOT(inside) "<robot name='r'>" inside "</robot>"
#define SHAPE(geometry) ROBOT("<link name='a'><collision><geometry>" geometry "</geometry></collision></link>")

static void all_geometries_are_read(void **state)
{
    (void)state;
    static const char text[] =
        ROBOT("<link name='a'>"
              "<collision><geometry><box size='1 2 3'/></geometry></collision>"
              "<collision><origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/>"
              "<geometry><sphere radius='0.5'/></geometry></collision>"
              "<collision><geometry><cylinder radius='1' length='4'/></geometry></collision>"
              "<collision><geometry><capsule radius='1' length='4'/></geometry></collision>"
              "<collision><geometry><mesh filename='m.stl' scale='1 -1 2'/></geometry></collision>"
              "<visual><geometry><box size='nonsense'/></geometry></visual></link>");
    fixture f;
    urdf u;
    fixture_begin(&f);
    assert_true(fixture_urdf(&f, text, &u));
    assert_int_equal(u.links[0].shape_count, 5);
    const load_shape *s = u.links[0].shapes;
    assert_true(s[0].shape.type == COLLIDED_BOX && s[0].shape.half[0] == 0.5 && s[0].shape.half[2] == 1.5);
    assert_true(s[1].shape.type == COLLIDED_SPHERE && s[1].shape.radius == 0.5);
    assert_true(s[1].shape.pose.position[2] == 3);
    assert_true(fabs(s[1].shape.pose.orientation[0] - sqrt(0.5)) < 1e-15);
    assert_true(fabs(s[1].shape.pose.orientation[3] - sqrt(0.5)) < 1e-15);
    assert_true(s[2].shape.type == COLLIDED_CYLINDER && s[2].shape.half[0] == 1 && s[2].shape.half[2] == 2);
    assert_true(s[3].shape.type == COLLIDED_CAPSULE && s[3].shape.radius == 1 && s[3].shape.half[2] == 2);
    assert_true(s[4].shape.type == COLLIDED_HULL && s[4].scale[1] == -1);
    assert_string_equal(s[4].mesh, "m.stl");
    fixture_end(&f);
}

static void numbers_that_are_none_are_refused_with_their_line(void **state)
{
    (void)state;
    urdf_is_refused(
        ROBOT("\n\n<link name='a'><collision><geometry>\n<box size='1 nan 1'/></geometry></collision></link>"),
        "test.urdf:4:");
    urdf_is_refused(SHAPE("<box size='1 inf 1'/>"), "3 finite numbers");
    urdf_is_refused(SHAPE("<box size='1 1e999 1'/>"), "3 finite numbers");
    urdf_is_refused(SHAPE("<box size='1 1'/>"), "3 finite numbers");
    urdf_is_refused(SHAPE("<box size='1 -1 1'/>"), "negative");
    urdf_is_refused(SHAPE("<box/>"), "no attribute 'size'");
    urdf_is_refused(SHAPE("<sphere radius='-1'/>"), "at least 0");
    urdf_is_refused(SHAPE("<cylinder radius='1' length='-2'/>"), "at least 0");
    urdf_is_refused(SHAPE("<capsule radius='1'/>"), "no attribute 'length'");
    urdf_is_refused(SHAPE("<torus/>"), "none of box");
    urdf_is_refused(SHAPE("<mesh filename=''/>"), "empty");
}

static void what_is_no_tree_is_refused(void **state)
{
    (void)state;
    urdf_is_refused(
        ROBOT(LINK("a") LINK("b") JOINT("1", "fixed", "a", "b", "") JOINT("2", "fixed", "b", "a", "")), "ring");
    urdf_is_refused(
        ROBOT(LINK("r") LINK("a") LINK("b") JOINT("1", "fixed", "a", "b", "") JOINT("2", "fixed", "b", "a", "")),
        "ring");
    urdf_is_refused(ROBOT(LINK("a") JOINT("1", "fixed", "a", "a", "")), "ring");
    urdf_is_refused(ROBOT(LINK("a") LINK("b")), "no parent");
    urdf_is_refused(
        ROBOT(LINK("a") LINK("b") LINK("c") JOINT("1", "fixed", "a", "c", "") JOINT("2", "fixed", "b", "c", "")),
        "two parents");
    urdf_is_refused(ROBOT(LINK("a") LINK("a")), "two links named 'a'");
    urdf_is_refused(
        ROBOT(LINK("a") LINK("b") LINK("c") JOINT("1", "fixed", "a", "b", "") JOINT("1", "fixed", "a", "c", "")),
        "two joints named '1'");
    urdf_is_refused(ROBOT(LINK("a") JOINT("1", "fixed", "nobody", "a", "")), "'nobody', which does not exist");
    urdf_is_refused(ROBOT(LINK("a") JOINT("1", "fixed", "a", "nobody", "")), "'nobody', which does not exist");
    urdf_is_refused(ROBOT(""), "no links");
    urdf_is_refused(ROBOT(LINK("a*")), "patterns");
}

#define TWO(type, rest) ROBOT(LINK("a") LINK("b") JOINT("j", type, "a", "b", rest))

static void joints_are_checked(void **state)
{
    (void)state;
    urdf_is_refused(TWO("helical", ""), "unknown type 'helical'");
    urdf_is_refused(TWO("revolute", ""), "needs a <limit>");
    urdf_is_refused(TWO("revolute", "<limit lower='1' upper='-1'/>"), "above its upper limit");
    urdf_is_refused(TWO("continuous", "<axis xyz='0 0 0'/>"), "axis of joint 'j' is zero");
    urdf_is_refused(TWO("continuous", "<mimic joint='k'/>"), "'k', which does not exist");
    urdf_is_refused(TWO("continuous", "<mimic joint='j'/>"), "mimics itself");
    fixture f;
    urdf u;
    fixture_begin(&f);
    assert_true(fixture_urdf(&f, TWO("floating", ""), &u));
    assert_int_equal(u.joints[0].type, URDF_FIXED);
    assert_non_null(strstr(f.warning, "taken as fixed"));
    fixture_end(&f);
}

static void entities_are_refused_before_they_are_read(void **state)
{
    (void)state;
    static const char laughs[] =
        "<?xml version='1.0'?><!DOCTYPE robot [<!ENTITY a 'ha'>"
        "<!ENTITY b '&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;'><!ENTITY c '&b;&b;&b;&b;&b;&b;&b;&b;&b;'>"
        "<!ENTITY d '&c;&c;&c;&c;&c;&c;&c;&c;&c;&c;'>]><robot name='&d;'><link name='a'/></robot>";
    urdf_is_refused(laughs, "DOCTYPE");
    urdf_is_refused("<!DOCTYPE robot SYSTEM 'file:///etc/passwd'><robot name='r'/>", "DOCTYPE");
    urdf_is_refused("<robot name='&nobody;'/>", "well-formed");
}

static void what_is_no_urdf_is_refused(void **state)
{
    (void)state;
    urdf_is_refused("", "well-formed");
    urdf_is_refused("<robot name='r'>", "well-formed");
    urdf_is_refused("<html/>", "not <robot>");
    urdf_is_refused("<robot/>", "no attribute 'name'");
    urdf_is_refused("\x01\xff\xfe", "well-formed");
}

static void what_is_too_large_is_refused(void **state)
{
    (void)state;
    enum { LINKS = URDF_LINKS_MAX + 1, BYTES = LINKS * 32 + 64 };
    char *text = malloc(BYTES);
    assert_non_null(text);
    size_t n = (size_t)snprintf(text, BYTES, "<robot name='r'>");
    for (int i = 0; i < LINKS; i++) n += (size_t)snprintf(text + n, BYTES - n, "<link name='l%d'/>", i);
    snprintf(text + n, BYTES - n, "</robot>");
    urdf_is_refused(text, "more than 4096");
    free(text);

    enum { DEEP = 5000 };
    text = malloc(DEEP * 3 + 64);
    assert_non_null(text);
    strcpy(text, "<robot name='r'>");
    n = strlen(text);
    for (int i = 0; i < DEEP; i++) memcpy(text + n + 3 * (size_t)i, "<a>", 4);
    urdf_is_refused(text, "well-formed");
    free(text);
}

/* Every prefix of a good file, and every file with one byte changed, is either read or refused: nothing else happens.
 */
static void damaged_files_do_no_harm(void **state)
{
    (void)state;
    static const char good[] = TWO("revolute", "<limit lower='-1' upper='1'/><origin xyz='1 2 3'/><mimic joint='j'/>");
    size_t size = sizeof good - 1;
    for (size_t i = 0; i < 2 * size; i++) {
        char text[sizeof good];
        memcpy(text, good, sizeof good);
        if (i >= size) text[i - size] = (char)(i * 37 + 1);
        fixture f;
        urdf u;
        fixture_begin(&f);
        bool ok = urdf_parse(&u, &f.pool, text, i < size ? i : size, "test.urdf", &f.report);
        assert_int_equal(ok, f.report.error[0] == '\0');
        fixture_end(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_geometries_are_read),
        cmocka_unit_test(numbers_that_are_none_are_refused_with_their_line),
        cmocka_unit_test(what_is_no_tree_is_refused),
        cmocka_unit_test(joints_are_checked),
        cmocka_unit_test(entities_are_refused_before_they_are_read),
        cmocka_unit_test(what_is_no_urdf_is_refused),
        cmocka_unit_test(what_is_too_large_is_refused),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
