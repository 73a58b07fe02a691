/* Forward kinematics and what is made of a robot. Oracle for the arm: the modified Denavit-Hartenberg parameters that
 * Franka publishes for the Panda, multiplied as 4 x 4 matrices; nothing of the URDF enters it. */
#include "fixture.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct matrix {
    double m[4][4];
} matrix;

static matrix product(const matrix *a, const matrix *b)
{
    matrix out = {0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            for (int k = 0; k < 4; k++) out.m[i][j] += a->m[i][k] * b->m[k][j];
    return out;
}

/* Craig's convention: Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d) */
static matrix modified_dh(double a, double d, double alpha, double theta)
{
    double ca = cos(alpha), sa = sin(alpha), ct = cos(theta), st = sin(theta);
    return (matrix){{{ct, -st, 0, a}, {st * ca, ct * ca, -sa, -d * sa}, {st * sa, ct * sa, ca, d * ca}, {0, 0, 0, 1}}};
}

static void pose_is_matrix(const collided_pose *p, const matrix *m, double tolerance)
{
    double w = p->orientation[0], x = p->orientation[1], y = p->orientation[2], z = p->orientation[3];
    const double r[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
        {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
        {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; i++) {
        if (!(fabs(p->position[i] - m->m[i][3]) <= tolerance))
            fail_msg("position[%d] is %.17g, not %.17g", i, p->position[i], m->m[i][3]);
        for (int j = 0; j < 3; j++)
            if (!(fabs(r[i][j] - m->m[i][j]) <= tolerance)) fail_msg("rotation[%d][%d]", i, j);
    }
}

static void panda_is_where_its_parameters_say(const robot *b, const double *values)
{
    static const double quarter = 1.57079632679489661923;
    const double a[] = {0, 0, 0, 0.0825, -0.0825, 0, 0.088}, d[] = {0.333, 0, 0.316, 0, 0.384, 0, 0};
    const double alpha[] = {0, -quarter, quarter, quarter, -quarter, quarter, quarter};
    collided_pose links[64];
    robot_forward(b, values, links);
    matrix at = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}}};
    for (int i = 0; i < 7; i++) {
        char name[32];
        snprintf(name, sizeof name, "panda_joint%d", i + 1);
        matrix step = modified_dh(a[i], d[i], alpha[i], values[urdf_find_joint(&b->model, name)]);
        at = product(&at, &step);
        snprintf(name, sizeof name, "panda_link%d", i + 1);
        pose_is_matrix(&links[urdf_find_link(&b->model, name)], &at, 1e-10); /* the URDF's pi/2 has 12 digits */
    }
}

static void panda_states_agree_with_denavit_and_hartenberg(void **state)
{
    (void)state;
    fixture f;
    robot b;
    double values[64];
    fixture_begin(&f);
    if (!fixture_panda(&f, &b)) skip();
    static const char *const states[] = {"ready", "extended", "transport"};
    for (int i = 0; i < 3; i++) {
        robot_default_values(&b, values);
        assert_true(robot_state(&b, states[i], values, &f.report));
        panda_is_where_its_parameters_say(&b, values);
    }
    uint64_t seed = 1;
    for (int k = 0; k < 200; k++) {
        for (int i = 0; i < b.model.joint_count; i++) {
            seed = seed * 6364136223846793005u + 1442695040888963407u;
            values[i] = 6.4 * ((double)(seed >> 11) / 9007199254740992.0 - 0.5);
        }
        panda_is_where_its_parameters_say(&b, values);
    }
    fixture_end(&f);
}

static void panda_bodies_follow_the_srdf(void **state)
{
    (void)state;
    fixture f;
    robot b;
    double values[64];
    load_bodies bodies;
    fixture_begin(&f);
    if (!fixture_panda(&f, &b)) skip();
    robot_default_values(&b, values);
    b.source.prefix = "left_";
    collided_pose base = {{1, 2, 3}, {0, 0, 0, 1}}; /* half a turn about z */
    if (!robot_bodies(&b, base, values, COLLIDED_MOVING, &f.pool, &bodies, &f.report)) fail_msg("%s", f.report.error);
    assert_int_equal(bodies.count, 11); /* link8 has no geometry */
    const load_body *link5 = &bodies.at[5];
    assert_string_equal(link5->name, "left_panda_link5");
    assert_string_equal(link5->group, "panda");
    assert_int_equal(link5->rule_count, 3);
    assert_string_equal(link5->rules[0].pattern, "left_panda_link3");
    assert_string_equal(link5->rules[0].reason, "SRDF: Never");
    assert_string_equal(link5->rules[2].reason, "SRDF: Adjacent");
    assert_true(link5->rules[0].allow);
    assert_true(link5->shapes[0].points.count > 100);
    assert_true(fabs(bodies.at[1].pose.position[2] - 3.333) < 1e-12);
    assert_true(fabs(bodies.at[0].pose.position[1] - 2) < 1e-12);
    fixture_end(&f);
}

static const char gripper[] =
    "<robot name='g'><link name='base'><collision><geometry><sphere radius='1'/></geometry></collision></link>"
    "<link name='frame'/><link name='one'><collision><geometry><sphere radius='1'/></geometry></collision></link>"
    "<link name='two'><collision><geometry><sphere radius='1'/></geometry></collision></link>"
    "<joint name='f' type='fixed'><parent link='base'/><child link='frame'/></joint>"
    "<joint name='j1' type='prismatic'><parent link='frame'/><child link='one'/><axis xyz='0 2 0'/>"
    "<limit lower='0.1' upper='1'/></joint>"
    "<joint name='j2' type='revolute'><parent link='frame'/><child link='two'/><axis xyz='0 0 1'/>"
    "<limit lower='-1' upper='1'/><mimic joint='j1' multiplier='-2' offset='0.5'/></joint></robot>";

static void load_gripper(fixture *f, robot *b)
{
    fixture_begin(f);
    *b = (robot){.pool = &f->pool, .source.urdf = "test.urdf"};
    if (!fixture_urdf(f, gripper, &b->model)) fail_msg("%s", f->report.error);
}

static void mimic_joints_and_limits_hold(void **state)
{
    (void)state;
    fixture f;
    robot b;
    double values[3];
    collided_pose links[4];
    load_gripper(&f, &b);
    robot_default_values(&b, values);
    assert_true(values[1] == 0.1); /* the limit next to zero */
    assert_true(robot_set_list(&b, "j1=0.25", values, &f.report));
    robot_forward(&b, values, links);
    assert_true(fabs(links[2].position[1] - 0.25) < 1e-15);      /* the axis counts as a direction */
    assert_true(fabs(links[3].orientation[3] - sin(0)) < 1e-15); /* -2 * 0.25 + 0.5 = 0 */
    assert_int_equal(f.report.warnings, 0);
    assert_true(robot_set(&b, "j1", 2, values, &f.report));
    assert_non_null(strstr(f.warning, "beyond its limits 0.1 to 1"));
    fixture_end(&f);
}

static void wrong_joint_values_are_refused(void **state)
{
    (void)state;
    static const struct {
        const char *list, *words;
    } cases[] = {{"jx=1", "no joint 'jx'"}, {"f=1", "is fixed"}, {"j2=1", "mimics 'j1'"}, {"j1=nan", "NAME=NUMBER"},
        {"j1", "NAME=NUMBER"}, {"j1=0.5,=2", "no joint ''"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fixture f;
        robot b;
        double values[3];
        load_gripper(&f, &b);
        robot_default_values(&b, values);
        assert_false(robot_set_list(&b, cases[i].list, values, &f.report));
        if (!strstr(f.report.error, cases[i].words)) fail_msg("'%s' lacks: %s", f.report.error, cases[i].words);
        fixture_end(&f);
    }
}

static void without_srdf_joined_links_may_touch(void **state)
{
    (void)state;
    fixture f;
    robot b;
    double values[3];
    load_bodies bodies;
    load_gripper(&f, &b);
    robot_default_values(&b, values);
    assert_false(robot_state(&b, "ready", values, &f.report));
    assert_non_null(strstr(f.report.error, "--srdf"));
    f.report.error[0] = '\0';
    assert_true(robot_bodies(&b, (collided_pose){{0}, {1}}, values, COLLIDED_FIXED, &f.pool, &bodies, &f.report));
    assert_int_equal(bodies.count, 3);
    assert_int_equal(bodies.at[0].rule_count, 2); /* through the link without geometry */
    assert_int_equal(bodies.at[1].rule_count, 1);
    assert_string_equal(bodies.at[1].rules[0].pattern, "base");
    assert_int_equal(bodies.at[2].motion, COLLIDED_FIXED);
    fixture_end(&f);
}

static void unknown_packages_and_missing_meshes_are_told(void **state)
{
    (void)state;
    fixture f;
    robot b;
    load_bodies bodies;
    static const struct {
        const char *file, *words;
    } cases[] = {{"package://nowhere_description/a.stl", "--package nowhere_description=FOLDER"},
        {"missing.stl", "missing.stl: No such file"}, {"http://a/b.stl", "neither package://"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[256];
        snprintf(text, sizeof text,
            "<robot name='g'><link name='a'><collision><geometry><mesh filename='%s'/></geometry>"
            "</collision></link></robot>",
            cases[i].file);
        fixture_begin(&f);
        b = (robot){.pool = &f.pool, .source.urdf = LOADERS_DATA "/test.urdf"};
        assert_true(fixture_urdf(&f, text, &b.model));
        assert_false(robot_bodies(&b, (collided_pose){{0}, {1}}, NULL, COLLIDED_MOVING, &f.pool, &bodies, &f.report));
        if (!strstr(f.report.error, cases[i].words)) fail_msg("'%s' lacks: %s", f.report.error, cases[i].words);
        fixture_end(&f);
    }
}

static void packages_around_the_model_are_found(void **state)
{
    (void)state;
    fixture f;
    fixture_begin(&f);
    const char *path =
        package_resolve(&f.pool, "package://loaders/data/tetrahedron.stl", LOADERS_DATA, NULL, 0, "x", &f.report);
    assert_non_null(path);
    assert_non_null(strstr(path, "tests/loaders/data/tetrahedron.stl"));
    const load_package list[] = {{"loaders", "/elsewhere"}};
    assert_string_equal(
        package_resolve(&f.pool, "package://loaders/m.stl", LOADERS_DATA, list, 1, "x", &f.report), "/elsewhere/m.stl");
    assert_string_equal(package_resolve(&f.pool, "file:///m.stl", "a", NULL, 0, "x", &f.report), "/m.stl");
    assert_string_equal(package_resolve(&f.pool, "m.stl", "a", NULL, 0, "x", &f.report), "a/m.stl");
    fixture_end(&f);
}

/* Where ROS would look: after the list and the folders around the model, and without naming what is not there. */
static void packages_of_ros_are_found(void **state)
{
    (void)state;
    fixture f;
    char made[] = "/tmp/collided_packages_XXXXXX", path[256];
    static const char *const folders[] = {"", "/src", "/src/repo", "/src/repo/deep_pkg", "/src/flat_pkg", "/prefix",
        "/prefix/share", "/prefix/share/ament_pkg", "/model", "/model/meshes"};
    fixture_begin(&f);
    assert_non_null(mkdtemp(made));
    for (size_t i = 1; i < sizeof folders / sizeof *folders; i++) {
        snprintf(path, sizeof path, "%s%s", made, folders[i]);
        assert_int_equal(mkdir(path, 0700), 0);
    }
    snprintf(path, sizeof path, "%s/model/meshes/a.stl", made);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fclose(file);
    snprintf(path, sizeof path, "/nowhere::%s/src/:%s/src/flat_pkg", made, made);
    setenv("ROS_PACKAGE_PATH", path, 1);
    snprintf(path, sizeof path, "/nowhere:%s/prefix", made);
    setenv("AMENT_PREFIX_PATH", path, 1);
    static const struct {
        const char *uri, *end;
    } cases[] = {{"package://flat_pkg/m.stl", "/src/flat_pkg/m.stl"},
        {"package://deep_pkg/m.stl", "/src/repo/deep_pkg/m.stl"},
        {"package://ament_pkg/m.stl", "/prefix/share/ament_pkg/m.stl"},
        {"package://unpacked/meshes/a.stl", "/model/meshes/a.stl"}};
    snprintf(path, sizeof path, "%s/model", made);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *found = package_resolve(&f.pool, cases[i].uri, path, NULL, 0, "x", &f.report);
        if (!found) fail_msg("%s", f.report.error);
        char expected[256];
        snprintf(expected, sizeof expected, "%s%s", made, cases[i].end);
        assert_string_equal(found, expected);
    }
    assert_null(package_resolve(&f.pool, "package://../meshes/a.stl", path, NULL, 0, "x", &f.report));
    assert_non_null(strstr(f.report.error, "AMENT_PREFIX_PATH"));
    unsetenv("ROS_PACKAGE_PATH");
    unsetenv("AMENT_PREFIX_PATH");
    snprintf(path, sizeof path, "%s/model/meshes/a.stl", made);
    unlink(path);
    for (size_t i = sizeof folders / sizeof *folders; i-- > 0;) {
        snprintf(path, sizeof path, "%s%s", made, folders[i]);
        assert_int_equal(rmdir(path), 0);
    }
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(panda_states_agree_with_denavit_and_hartenberg),
        cmocka_unit_test(panda_bodies_follow_the_srdf),
        cmocka_unit_test(mimic_joints_and_limits_hold),
        cmocka_unit_test(wrong_joint_values_are_refused),
        cmocka_unit_test(without_srdf_joined_links_may_touch),
        cmocka_unit_test(unknown_packages_and_missing_meshes_are_told),
        cmocka_unit_test(packages_around_the_model_are_found),
        cmocka_unit_test(packages_of_ros_are_found),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
