/* Pairs that never meet, where the answer is known: balls on a stick that turns, on rails, on joints that mimic others,
 * and far down a chain. Each is asked on both sides of the border between meeting and not. */
#include "fit_fixture.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static load_shape ball(double x, double y, double z, double radius)
{
    load_shape s = {.shape = collided_sphere(radius), .scale = {1, 1, 1}};
    s.shape.pose.position[0] = x, s.shape.pose.position[1] = y, s.shape.pose.position[2] = z;
    return s;
}

static never_answer ask(const char *urdf_text, const load_shape *a, const load_shape *b, size_t boxes)
{
    fixture f;
    urdf u;
    never_answer out;
    fixture_begin(&f);
    if (!fixture_urdf(&f, urdf_text, &u)) fail_msg("%s", f.report.error);
    never_meet_find(&u, urdf_find_link(&u, "a"), a, 1, urdf_find_link(&u, "b"), b, 1, boxes, &out);
    never_answer back;
    never_meet_find(&u, urdf_find_link(&u, "b"), b, 1, urdf_find_link(&u, "a"), a, 1, boxes, &back);
    assert_int_equal(out.verdict, back.verdict); /* whichever comes first */
    fixture_end(&f);
    return out;
}

#define LINKS "<link name='a'/><link name='b'/>"
#define JOINT(name, type, parent, child, rest)                                                                         \
    "<joint name='" name "' type='" type "'><parent link='" parent "'/><child link='" child "'/>" rest "</joint>"
#define LIMIT(lo, hi) "<limit lower='" lo "' upper='" hi "' velocity='1' effort='1'/>"
#define ROBOT(text) "<robot name='r'>" text "</robot>"

/* A ball 1 m from the axis turns by up to a right angle to either side, towards one that stands at 0, 1, 0. */
static void a_stick_turns(void **state)
{
    (void)state;
    const char *urdf = ROBOT(LINKS JOINT("j", "revolute", "a", "b", "<axis xyz='0 0 1'/>" LIMIT("-1", "1")));
    double least = 2 * sin((acos(-1) / 2 - 1) / 2); /* between the centres */
    load_shape still = ball(0, 1, 0, 0.25), turning = ball(1, 0, 0, least - 0.25 - 1e-4);
    never_answer x = ask(urdf, &still, &turning, 100000);
    assert_int_equal(x.verdict, NEVER_PROVEN);
    assert_true(x.clearance_m > 0 && x.clearance_m <= 1e-4 + 1e-9);
    turning.shape.radius += 2e-4;
    x = ask(urdf, &still, &turning, 100000);
    assert_int_equal(x.verdict, NEVER_MEET);
    double value;
    assert_int_equal(sscanf(x.at, "j=%lf", &value), 1);
    assert_true(value > 0.99 && value < 1.001);
    turning.shape.radius -= 2e-4;
    assert_int_equal(ask(urdf, &still, &turning, 5).verdict, NEVER_UNDECIDED);
    turning.shape.radius += 1e-4; /* they touch to rounding */
    assert_int_not_equal(ask(urdf, &still, &turning, 100000).verdict, NEVER_PROVEN);
}

static void once_around_is_all_around(void **state)
{
    (void)state;
    const char *urdf = ROBOT(LINKS JOINT("j", "continuous", "a", "b", "<axis xyz='0 0 1'/>"));
    load_shape beside = ball(-1, 0, 0.5, 0.2), round = ball(1, 0, 0, 0.29);
    assert_int_equal(ask(urdf, &beside, &round, 100000).verdict, NEVER_PROVEN);
    round.shape.radius = 0.31;
    assert_int_equal(ask(urdf, &beside, &round, 100000).verdict, NEVER_MEET);
}

/* Two slides along x, the second the other way: 0.1 + v against 1 - 2 v, v up to 0.2. */
static void rails_and_mimics(void **state)
{
    (void)state;
    const char *urdf = ROBOT("<link name='base'/>" LINKS JOINT(
        "one", "prismatic", "base", "a", "<axis xyz='1 0 0'/>" LIMIT("0", "0.2")) JOINT("two", "prismatic", "base", "b",
        "<axis xyz='-1 0 0'/>" LIMIT("0", "9") "<mimic joint='one' multiplier='2' offset='0.1'/>"));
    load_shape a = ball(0.1, 0, 0, 0.09), b = ball(1.1, 0, 0, 0.2); /* least: 1.1 - 0.5 - 0.3 = 0.3 */
    never_answer x = ask(urdf, &a, &b, 10000);
    assert_int_equal(x.verdict, NEVER_PROVEN);
    assert_true(x.clearance_m <= 0.01 + 1e-9 && x.clearance_m > 0);
    b.shape.radius = 0.22;
    assert_int_equal(ask(urdf, &a, &b, 10000).verdict, NEVER_MEET);
}

static void what_has_no_range_is_not_proven(void **state)
{
    (void)state;
    const char *urdf = ROBOT("<link name='base'/>" LINKS JOINT("one", "continuous", "base", "a", "<axis xyz='1 0 0'/>")
            JOINT("two", "prismatic", "base", "b", "<axis xyz='0 0 1'/>" LIMIT("0", "1") "<mimic joint='one'/>"));
    load_shape a = ball(0, 0, 0, 0.1), b = ball(0, 9, 0, 0.1);
    assert_int_equal(ask(urdf, &a, &b, 10000).verdict, NEVER_UNKNOWN);
    const char *floating = ROBOT(LINKS JOINT("j", "floating", "a", "b", ""));
    assert_int_equal(ask(floating, &a, &b, 10000).verdict, NEVER_UNKNOWN);
    const char *fixed = ROBOT(LINKS JOINT("j", "fixed", "a", "b", ""));
    assert_int_equal(ask(fixed, &a, &b, 10000).verdict, NEVER_PROVEN);
}

/* A turned, rounded box, as pieces of a concave link are: its corner is the nearest. */
static void boxes_and_capsules_take_part(void **state)
{
    (void)state;
    const char *urdf = ROBOT(LINKS JOINT("j", "prismatic", "a", "b", "<axis xyz='0 0 1'/>" LIMIT("-1", "1")));
    double corner = sqrt(2) * 0.5; /* to x, of the box that is turned by 45 degrees about z */
    load_shape box = {.shape = collided_box(1, 1, 4)}, rod = {.shape = collided_capsule(0.1, 3)};
    box.shape.radius = 0.05;
    box.shape.pose.orientation[0] = cos(acos(-1) / 8), box.shape.pose.orientation[3] = sin(acos(-1) / 8);
    rod.shape.pose.position[0] = corner + 0.05 + 0.1 + 0.001;
    never_answer x = ask(urdf, &box, &rod, 10000);
    assert_int_equal(x.verdict, NEVER_PROVEN);
    assert_true(x.clearance_m > 0 && x.clearance_m < 0.001 + 1e-9);
    rod.shape.radius += 0.002;
    assert_int_equal(ask(urdf, &box, &rod, 10000).verdict, NEVER_MEET);
}

/* Three joints in a row, tilted: the least distance over drawn values is no less than what is proven, nor by far more.
 */
static void chains_hold_at_drawn_values(void **state)
{
    (void)state;
    const char *urdf = ROBOT(LINKS "<link name='m'/><link name='n'/>" JOINT("j1", "revolute", "a", "m",
        "<origin xyz='0 0 0.5' rpy='0.3 0 0'/><axis xyz='0 0 1'/>" LIMIT("-2", "1")) JOINT("j2", "revolute", "m", "n",
        "<origin xyz='0.4 0 0' rpy='0 1 0.2'/><axis xyz='0 1 0'/>" LIMIT("-0.5", "0.8"))
            JOINT("j3", "prismatic", "n", "b", "<origin xyz='0 0.1 0.3'/><axis xyz='1 0 1'/>" LIMIT("-0.1", "0.1")));
    load_shape a = ball(0, 0, 0, 0.2), b = ball(0.2, 0, 0, 0.1);
    never_answer x = ask(urdf, &a, &b, 200000);
    assert_int_equal(x.verdict, NEVER_PROVEN);
    fixture f;
    robot r = {0};
    fixture_begin(&f);
    assert_true(fixture_urdf(&f, urdf, &r.model));
    prng random = {4};
    double least = INFINITY;
    for (size_t n = 0; n < fit_count(1000000); n++) {
        double values[3];
        collided_pose poses[4];
        for (int i = 0; i < 3; i++) values[i] = drawn(&random, r.model.joints[i].lower, r.model.joints[i].upper);
        robot_forward(&r, values, poses);
        pose of_b = pose_from(&poses[urdf_find_link(&r.model, "b")]);
        least = fmin(least, vec_norm(vec_add(quat_rotate(of_b.q, vec(0.2, 0, 0)), of_b.p)) - 0.3);
    }
    assert_true(least >= x.clearance_m && x.clearance_m > 0.4 * least);
    fixture_end(&f);
}

/* ---- what is said to meet does, at the values that are told ---- */

static load_shape drawn_rod(prng *r)
{
    load_shape s = {.scale = {1, 1, 1}};
    double thin = drawn(r, 0.02, 0.2), tall = drawn(r, 0.2, 1);
    s.shape = prng_below(r, 2) ? collided_capsule(thin, tall) : collided_box(thin, drawn(r, 0.02, 0.4), tall);
    if (s.shape.type == COLLIDED_BOX && prng_below(r, 2)) s.shape.radius = drawn(r, 0.001, 0.05);
    vec3 axis = vec_scale(drawn_direction(r), sin(0.6));
    const double q[4] = {cos(0.6), axis.x, axis.y, axis.z};
    memcpy(s.shape.pose.orientation, q, sizeof q);
    for (int k = 0; k < 3; k++) s.shape.pose.position[k] = drawn(r, -0.3, 0.3);
    return s;
}

/* Their distance at the values, by the engine. */
static double away_at(robot *r, fixture *f, const char *values_told, const load_shape *a, const load_shape *b)
{
    double values[3];
    collided_pose poses[4];
    solid_set of_a, of_b;
    robot_default_values(r, values);
    if (!robot_set_list(r, values_told, values, &f->report)) fail_msg("%s: %s", values_told, f->report.error);
    robot_forward(r, values, poses);
    set_make(&of_a, a, 1);
    set_make(&of_b, b, 1);
    double away = set_distance(&of_a, pose_from(&poses[urdf_find_link(&r->model, "a")]), &of_b,
        pose_from(&poses[urdf_find_link(&r->model, "b")]));
    set_free(&of_a);
    set_free(&of_b);
    return away;
}

static void what_meets_meets_where_told(void **state)
{
    (void)state;
    const char *urdf = ROBOT(LINKS "<link name='m'/><link name='n'/>" JOINT("j1", "revolute", "a", "m",
        "<origin xyz='0 0 0.5' rpy='0.3 0 0'/><axis xyz='0 0 1'/>" LIMIT("-2", "1")) JOINT("j2", "revolute", "m", "n",
        "<origin xyz='0.4 0 0' rpy='0 1 0.2'/><axis xyz='0 1 0'/>" LIMIT("-0.5", "0.8"))
            JOINT("j3", "prismatic", "n", "b", "<origin xyz='0 0.1 0.3'/><axis xyz='1 0 1'/>" LIMIT("-0.1", "0.1")));
    fixture f;
    robot r = {0};
    fixture_begin(&f);
    assert_true(fixture_urdf(&f, urdf, &r.model));
    prng random = {5};
    size_t met = 0, count = fit_count(50000);
    for (size_t n = 0; n < count; n++) {
        load_shape a = drawn_rod(&random), b = drawn_rod(&random);
        never_answer x = ask(urdf, &a, &b, 2000);
        if (x.verdict != NEVER_MEET) continue;
        met++;
        double away = away_at(&r, &f, x.at, &a, &b);
        if (away > 1e-8) fail_msg("draw %zu: %.9g m apart at %s", n, away, x.at);
    }
    assert_true(met > count / 10 && met < count);
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stick_turns),
        cmocka_unit_test(once_around_is_all_around),
        cmocka_unit_test(rails_and_mimics),
        cmocka_unit_test(what_has_no_range_is_not_proven),
        cmocka_unit_test(boxes_and_capsules_take_part),
        cmocka_unit_test(chains_hold_at_drawn_values),
        cmocka_unit_test(what_meets_meets_where_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
