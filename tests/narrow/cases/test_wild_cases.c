/* Cases from the trackers of MuJoCo, Bullet, parry and Newton in which the distance may have been right, but not what
 * was told beside it: a contact too deep, a contact too few, a normal to the side, a witness metres off. Of each the
 * distance, the axis, the witness points and the manifold are held against what the geometry says.
 *
 * Where a report gives its numbers they are these; where it gives a description, the scene is built from that. */
#include "judge.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static narrow_scratch *scratch;

static shape box(double x, double y, double z)
{
    return (shape){.type = SHAPE_BOX, .half = {x, y, z}};
}

static quat about(vec3 axis, double angle)
{
    vec3 v = vec_scale(vec_unit(axis), sin(angle / 2));
    return (quat){cos(angle / 2), v.x, v.y, v.z};
}

static const char *named; /* the case under way */

static void expect(bool holds, const char *what, double value)
{
    if (holds) return;
    print_error("%s: %s (%.17g)\n", named, what, value);
    fail();
}

/* Interval, state and certificate by the oracle; axis; the points of the manifold no deeper than the depth allows. */
static narrow_result decide(const char *name, shape a, pose at_a, shape b, pose at_b, double distance, double tolerance,
    expected_state state, vec3 normal)
{
    subject x, y;
    narrow_result r;
    expectation e = {.measured = true, .distance = distance, .tolerance = tolerance, .state = state};
    bool has_normal = vec_norm2(normal) > 0;
    named = name;
    if (has_normal) e.normal_count = 1;
    e.normals[0][0] = normal.x, e.normals[0][1] = normal.y, e.normals[0][2] = normal.z;
    subject_from_shape(&x, a);
    subject_from_shape(&y, b);
    subject_place(&x, at_a);
    subject_place(&y, at_b);
    judgement j = judge(&x, &y, &e);
    expect(!j.fault, j.fault ? j.fault : "", j.result.lo);
    narrow_request ask = {.facts = NARROW_DISTANCE | NARROW_MANIFOLD,
        .tolerance = 1e-9 * j.size,
        .range = INFINITY,
        .threshold = 1e-3 * j.size};
    narrow_query_world(&a, at_a, &b, at_b, &ask, scratch, &r);
    expect(r.lo <= j.result.hi && j.result.lo <= r.hi, "another answer where a manifold is asked for", r.lo);
    for (uint32_t i = 0; i < r.manifold.count; i++)
        expect(r.manifold.points[i].distance >= r.lo - 1e-9 * j.size, "a contact deeper than the depth",
            r.manifold.points[i].distance);
    subject_free(&x);
    subject_free(&y);
    return r;
}

static double spread(const manifold *m, vec3 along)
{
    double least = INFINITY, most = -INFINITY;
    for (uint32_t i = 0; i < m->count; i++) {
        double s = vec_dot(m->points[i].point, along);
        least = fmin(least, s);
        most = fmax(most, s);
    }
    return m->count ? most - least : 0;
}

static pose at(double x, double y, double z)
{
    return (pose){vec(x, y, z), {1, 0, 0, 0}};
}

/* https://github.com/google-deepmind/mujoco/issues/3476: two boxes of 71 mm that rest face to face, 0.056 mm deep at a
 * corner, had a second contact 71.056 mm deep. */
static void resting_boxes_have_no_phantom_depth(void **state)
{
    (void)state;
    const double h = 35.5, depth = 0.056;
    shape a = box(60, h, 20), b = a;
    for (int i = -3; i <= 3; i++) {
        double yaw = 2e-4 * i; /* about z: the corner comes nearer by the sine of it */
        double y = 2 * h - depth + (h * cos(yaw) + 60 * fabs(sin(yaw)) - h);
        pose there = {vec(4 * i, y, 0.5 * i), about(vec(0, 0, 1), yaw)};
        double truth = -depth;
        narrow_result r = decide("mujoco-3476", a, at(0, 0, 0), b, there, truth, 0.02, STATE_OVERLAPPING, VEC_ZERO);
        expect(r.lo > -2 * depth, "deeper than it can be", r.lo);
        expect(fabs(r.axis.y) > 0.999, "normal to the side", r.axis.y);
        for (uint32_t k = 0; k < r.manifold.count; k++)
            expect(r.manifold.points[k].distance > -2 * depth, "a contact deeper than it can be",
                r.manifold.points[k].distance);
    }
}

/* https://github.com/google-deepmind/mujoco/issues/1857: a capsule below a disc, apart, was told at a negative distance
 * from it, with points that faced the middle of the disc. */
static void bodies_apart_have_a_positive_distance(void **state)
{
    (void)state;
    shape capsule = {.type = SHAPE_CAPSULE, .radius = 0.01, .half = {0, 0, 0.05}};
    shape disc = {.type = SHAPE_CYLINDER, .half = {0.2, 0.2, 0.005}};
    for (int i = 0; i <= 30; i++) {
        double up = 1e-3 * i, turn = 0.2 * i, truth = 0.095 - (up + 0.05 + 0.01);
        pose below = {vec(-0.1 * cos(turn), -0.1 * sin(turn), up), about(vec(0, 0, 1), turn)};
        narrow_result r =
            decide("mujoco-1857", capsule, below, disc, at(0, 0, 0.1), truth, 1e-12, STATE_APART, vec(0, 0, 1));
        expect(r.lo > 0, "not apart", r.lo);
        vec3 on_disc = vec_add(r.point_b, below.p);
        expect(hypot(on_disc.x - below.p.x, on_disc.y - below.p.y) < 1e-6, "a point that is not above the capsule",
            on_disc.x);
    }
}

/* https://github.com/google-deepmind/mujoco_warp/issues/1555: a battery that lies on a table had one contact, at one
 * end or the other. */
static void a_lying_cylinder_has_its_whole_line(void **state)
{
    (void)state;
    const double radius = 0.00725, half = 0.02525;
    shape battery = {.type = SHAPE_CYLINDER, .half = {radius, radius, half}}, table = box(0.4, 0.6, 0.02);
    const quat lying = about(vec(0, 1, 0), acos(-1) / 2);
    for (int i = -20; i <= 20; i++) {
        double pitch = 1e-7 * i * abs(i), roll = 0.157 * i, depth = 1e-5;
        quat q = quat_unit(quat_mul(about(vec(0, 1, 0), pitch), quat_mul(lying, about(vec(0, 0, 1), roll))));
        pose there = {vec(0.1, 0.05, 0.02 + radius - depth), q};
        double truth = -(depth + half * fabs(sin(pitch)) - radius * (1 - cos(pitch)));
        narrow_result r =
            decide("mujoco_warp-1555", table, at(0, 0, 0), battery, there, truth, 1e-12, STATE_OVERLAPPING, VEC_ZERO);
        expect(r.manifold.count >= 2, "contacts", r.manifold.count);
        expect(spread(&r.manifold, vec(1, 0, 0)) > 1.9 * half, "they span", spread(&r.manifold, vec(1, 0, 0)));
    }
}

/* https://github.com/google-deepmind/mujoco_warp/issues/1526: two boxes stacked exactly, 0.25 mm deep: no contact. */
static void a_stacked_box_has_its_contact(void **state)
{
    (void)state;
    shape cube = box(0.1, 0.1, 0.1);
    for (int i = -8; i <= 8; i++) {
        double depth = 2.5e-4 * ldexp(1, i);
        narrow_result r = decide("mujoco_warp-1526", cube, at(0, 0, 0.2), cube, at(0, 0, 0.4 - depth), -depth, 1e-15,
            STATE_OVERLAPPING, vec(0, 0, 1));
        expect(r.manifold.count == 4, "contacts", r.manifold.count);
    }
}

/* https://github.com/newton-physics/newton/pull/3248: something small near the edge of a large thin table was told to
 * overlap sideways, by metres. */
static void a_thin_table_is_met_from_above(void **state)
{
    (void)state;
    shape table = box(8, 6, 0.1), small = box(0.05, 0.05, 0.05), ball = {.type = SHAPE_SPHERE, .radius = 0.05};
    static const double gaps[] = {1e-2, 1e-5, 0, -1e-5, -1e-2};
    for (int i = 0; i < 5; i++) {
        expected_state s = gaps[i] > 0 ? STATE_APART : gaps[i] < 0 ? STATE_OVERLAPPING : STATE_ANY;
        pose there = at(7.93, 5.93, 0.15 + gaps[i]);
        narrow_result r = decide("newton-3248 box", table, at(0, 0, 0), small, there, gaps[i], 1e-14, s, vec(0, 0, 1));
        expect(gaps[i] > 1e-3 || r.manifold.count == 4, "contacts", r.manifold.count);
        decide("newton-3248 ball", ball, there, table, at(0, 0, 0), gaps[i], 1e-14, s, vec(0, 0, -1));
    }
}

/* https://github.com/dimforge/parry/issues/315: two unit cubes that touch in the plane x = 1: both points were told at
 * the first one's centre, the normal along y. */
static void touching_cubes_touch_in_their_plane(void **state)
{
    (void)state;
    shape cube = box(0.5, 0.5, 0.5);
    pose first = at(0.5, 0.5, 0.5);
    narrow_result r = decide("parry-315", cube, first, cube, at(1.5, 0.5, 0.5), 0, 1e-15, STATE_TOUCHING, vec(1, 0, 0));
    expect(fabs(r.point_a.x + first.p.x - 1) < 1e-12, "A's point is not in the plane", r.point_a.x + first.p.x);
    expect(fabs(r.point_b.x + first.p.x - 1) < 1e-12, "B's point is not in the plane", r.point_b.x + first.p.x);
    expect(r.manifold.count == 4, "contacts", r.manifold.count);
}

/* https://github.com/dimforge/parry/issues/378: a capsule just above a slab; B's point was told at the slab's corner,
 * two metres away. */
static void witness_points_face_each_other(void **state)
{
    (void)state;
    shape capsule = {.type = SHAPE_CAPSULE, .radius = 0.5, .half = {0, 0, 0.25}}, slab = box(4, 4, 0.5);
    static const double heights[] = {2.7391, 2.75, 2.75 + 6.7250437e-7, 2.76};
    for (int i = 0; i < 4; i++) {
        pose above = at(6.0373735, 0, heights[i]);
        double truth = heights[i] - 0.75 - 2;
        expected_state s = i == 1 ? STATE_ANY : truth > 0 ? STATE_APART : STATE_OVERLAPPING;
        narrow_result r = decide("parry-378", capsule, above, slab, at(4, 0, 1.5), truth, 1e-14, s, vec(0, 0, -1));
        expect(hypot(r.point_b.x, r.point_b.y) < 1e-6, "B's point is not below the capsule",
            hypot(r.point_b.x, r.point_b.y));
    }
}

/* https://github.com/bulletphysics/bullet3/issues/1703: beside a box of 128 x 1 x 128 with margin 0, a depth was told
 * with the sign of a gap. */
static void a_large_floor_has_the_sign_of_a_small_one(void **state)
{
    (void)state;
    shape floor = box(128, 1, 128), small = box(1, 1, 1), foot = box(0.3, 1, 0.2);
    for (int i = 0; i < 12; i++) {
        double depth = 0.04 * (i - 3) / 8, x = 11.3 * (i - 6), z = 7.7 * (5 - i);
        expected_state s = depth > 0 ? STATE_OVERLAPPING : depth < 0 ? STATE_APART : STATE_ANY;
        pose there = {vec(x, 2 - depth, z), about(vec(0, 1, 0), 0.3 * i)};
        vec3 normal = vec(0, 1, 0);
        decide("bullet-1703", floor, at(0, 0, 0), foot, there, -depth, 1e-13, s, normal);
        there.p.x = 0.01 * i, there.p.z = -0.01 * i;
        decide("bullet-1703 small", small, at(0, 0, 0), foot, there, -depth, 1e-13, s, normal);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(resting_boxes_have_no_phantom_depth),
        cmocka_unit_test(bodies_apart_have_a_positive_distance), cmocka_unit_test(a_lying_cylinder_has_its_whole_line),
        cmocka_unit_test(a_stacked_box_has_its_contact), cmocka_unit_test(a_thin_table_is_met_from_above),
        cmocka_unit_test(touching_cubes_touch_in_their_plane), cmocka_unit_test(witness_points_face_each_other),
        cmocka_unit_test(a_large_floor_has_the_sign_of_a_small_one)};
    scratch = aligned_alloc(64, narrow_scratch_size());
    int failed = scratch ? cmocka_run_group_tests(tests, NULL, NULL) : 1;
    free(scratch);
    return failed;
}
