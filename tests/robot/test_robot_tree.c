/* Kinematic trees: sines against libm, poses against a plain chain of quaternions by libm, lanes against scalars,
 * limits of motion against samples, and what is refused. */
#include "robot/turn.h"
#include "robot_draws.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* With COLLIDED_BRIEF a fifth. */
static int rounds_of(int normal)
{
    return getenv("COLLIDED_BRIEF") ? normal / 5 : normal;
}

static void test_sines(void **state)
{
    (void)state;
    uint64_t seed = 3;
    for (int i = 0; i < rounds_of(2000000); i++) {
        double most = i % 3 == 0 ? TURN_ANGLE_MAX : i % 3 == 1 ? 7 : 1e-3, x = prng_in(&seed, -most, most);
        if (i % 7 == 0) x = round(x / 1.5707963267948966) * 1.5707963267948966;
        lanes s, c;
        turn_sin_cos((lanes){0, x, 0, 0}, &s, &c);
        assert_true(fabs(s[1] - (double)sinl(x)) <= TURN_ERROR && fabs(c[1] - (double)cosl(x)) <= TURN_ERROR);
    }
}

/* The truth, but for libm's rounding: each joint's turn by Rodrigues' formula. */
static void chain(const robot_draw *d, const double *q, pose *out)
{
    size_t coordinate = 0, of[DRAW_LINKS];
    for (size_t i = 0; i < d->joint_count; i++)
        if (d->joints[i].type != ROBOT_FIXED && d->joints[i].mimic < 0) of[i] = coordinate++;
    for (size_t i = 0; i < d->joint_count; i++) {
        const robot_joint *j = &d->joints[i];
        pose parent = j->parent < 0 ? POSE_IDENTITY : out[j->parent], here = pose_mul(parent, j->origin);
        double value = j->type == ROBOT_FIXED ? 0 : j->mimic < 0 ? q[of[i]] : q[of[j->mimic]] * j->factor + j->offset;
        vec3 axis = vec_unit(j->axis);
        pose motion = j->type == ROBOT_PRISMATIC ? (pose){vec_scale(axis, value), {1, 0, 0, 0}}
                      : j->type == ROBOT_FIXED
                          ? POSE_IDENTITY
                          : (pose){VEC_ZERO, {cos(value / 2), axis.x * sin(value / 2), axis.y * sin(value / 2),
                                                 axis.z * sin(value / 2)}};
        out[i] = pose_mul(here, motion);
    }
}

static void test_poses(void **state)
{
    (void)state;
    uint64_t seed = 4;
    for (int round = 0; round < rounds_of(3000); round++) {
        robot_draw d;
        draw_robot(&seed, &d);
        double q[4][DRAW_LINKS];
        lanes side[DRAW_LINKS];
        robot_frames frames[DRAW_LINKS];
        for (int k = 0; k < 4; k++) draw_configuration(&seed, d.tree, q[k]);
        for (size_t c = 0; c < robot_tree_coordinates(d.tree); c++)
            for (int k = 0; k < 4; k++) side[c][k] = q[k][c];
        robot_tree_forward_lanes(d.tree, side, frames);
        for (int k = 0; k < 4; k++) {
            pose truth[DRAW_LINKS], got[DRAW_LINKS];
            chain(&d, q[k], truth);
            robot_tree_forward(d.tree, q[k], got);
            for (size_t i = 0; i < d.joint_count; i++) {
                vec3 point = vec(0.3, -0.2, 0.5), inner = quat_rotate(robot_tree_inner(d.tree, i), point);
                double slack = robot_tree_slack(d.tree, i, 1);
                vec3 expected = pose_point(truth[i], point), here = pose_point(got[i], point), turned;
                const robot_frames *f = &frames[i];
                double by_lane[3];
                for (int x = 0; x < 3; x++)
                    by_lane[x] = f->x[x][k] * inner.x + f->y[x][k] * inner.y + f->z[x][k] * inner.z + f->p[x][k];
                turned = vec(by_lane[0], by_lane[1], by_lane[2]);
                assert_true(vec_norm(vec_sub(expected, here)) <= 2 * slack);
                assert_true(vec_norm(vec_sub(expected, turned)) <= 2 * slack);
                assert_true(vec_norm(expected) <= robot_tree_reach(d.tree, i, 1));
            }
        }
        draw_robot_free(&d);
    }
}

/* By central differences of the poses. */
static void test_velocities(void **state)
{
    (void)state;
    uint64_t seed = 6;
    const double h = 1e-6;
    for (int round = 0; round < rounds_of(3000); round++) {
        robot_draw d;
        draw_robot(&seed, &d);
        double q[DRAW_LINKS], rates[DRAW_LINKS], before[DRAW_LINKS], after[DRAW_LINKS];
        pose at[DRAW_LINKS], was[DRAW_LINKS], will_be[DRAW_LINKS];
        vec3 linear[DRAW_LINKS], angular[DRAW_LINKS];
        draw_configuration(&seed, d.tree, q);
        for (size_t c = 0; c < robot_tree_coordinates(d.tree); c++) {
            q[c] = fmax(-3, fmin(3, q[c]));
            rates[c] = prng_in(&seed, -1, 1);
            before[c] = q[c] - h * rates[c], after[c] = q[c] + h * rates[c];
        }
        robot_tree_forward(d.tree, q, at);
        robot_tree_forward(d.tree, before, was);
        robot_tree_forward(d.tree, after, will_be);
        robot_tree_velocities(d.tree, rates, at, linear, angular);
        for (size_t i = 0; i < d.joint_count; i++) {
            double size = 1 + robot_tree_reach(d.tree, i, 1) + vec_norm(angular[i]) * vec_norm(angular[i]);
            quat turn = quat_mul(will_be[i].q, quat_conj(was[i].q));
            double sign = turn.w < 0 ? -1 : 1;
            vec3 moved = vec_scale(vec_sub(will_be[i].p, was[i].p), 0.5 / h),
                 turned = vec_scale(vec(turn.x, turn.y, turn.z), sign / h);
            assert_true(vec_norm(vec_sub(moved, linear[i])) <= 1e-7 * size * size);
            assert_true(vec_norm(vec_sub(turned, angular[i])) <= 1e-7 * size * size);
        }
        draw_robot_free(&d);
    }
}

/* Where a point of link b is, seen from link a. */
static vec3 seen_from(const robot_draw *d, int32_t a, uint32_t b, vec3 point, const double *q)
{
    pose links[DRAW_LINKS];
    robot_tree_forward(d->tree, q, links);
    return a < 0 ? pose_point(links[b], point) : pose_point(pose_relative(links[a], links[b]), point);
}

static void test_bends(void **state)
{
    (void)state;
    uint64_t seed = 5;
    double nearest = 0;
    for (int round = 0; round < rounds_of(20000); round++) {
        robot_draw d;
        draw_robot(&seed, &d);
        size_t n = robot_tree_coordinates(d.tree);
        double q0[DRAW_LINKS], q1[DRAW_LINKS], change[DRAW_LINKS], q[DRAW_LINKS];
        draw_configuration(&seed, d.tree, q0);
        draw_configuration(&seed, d.tree, q1);
        for (size_t c = 0; c < n; c++) change[c] = q1[c] - q0[c];
        uint32_t b = (uint32_t)(prng_bits(&seed) % d.joint_count);
        int32_t a = (int32_t)(prng_bits(&seed) % (d.joint_count + 1)) - 1;
        vec3 point = vec(prng_in(&seed, -1, 1), prng_in(&seed, -1, 1), prng_in(&seed, -1, 1));
        robot_lever levers[2 * ROBOT_LINKS_MAX];
        size_t count = robot_tree_levers(d.tree, a, b, vec_norm(point), levers);
        double bend = robot_levers_bend(levers, count, change), way = robot_levers_way(levers, count, change);
        double t0 = prng_in(&seed, 0, 1), t1 = prng_in(&seed, t0, 1), h = t1 - t0;
        for (size_t c = 0; c < n; c++) q[c] = q0[c] + t0 * change[c];
        vec3 start = seen_from(&d, a, b, point, q);
        for (size_t c = 0; c < n; c++) q[c] = q0[c] + t1 * change[c];
        vec3 end = seen_from(&d, a, b, point, q);
        assert_true(vec_norm(vec_sub(end, start)) <= way * h + 1e-11);
        for (int k = 1; k < 8; k++) {
            double s = k / 8.0;
            for (size_t c = 0; c < n; c++) q[c] = q0[c] + (t0 + s * h) * change[c];
            vec3 here = seen_from(&d, a, b, point, q), chord = vec_madd(start, s, vec_sub(end, start));
            double off = vec_norm(vec_sub(here, chord));
            assert_true(off <= bend * h * h / 8 + 1e-11);
            if (bend * h * h > 1e-3) nearest = fmax(nearest, off / (bend * h * h / 8));
        }
        draw_robot_free(&d);
    }
    assert_true(nearest > 0.5); /* the bound is one that is nearly reached */
}

static void test_refused(void **state)
{
    (void)state;
    robot_joint good = {.parent = -1,
        .type = ROBOT_REVOLUTE,
        .origin = POSE_IDENTITY,
        .axis = {0, 0, 1},
        .lower = -1,
        .upper = 1,
        .mimic = -1};
    robot_status status;
    size_t where;
    robot_joint two[2] = {good, good};
    two[1].parent = 0;
    robot_tree *t = robot_tree_create(two, 2, &status, &where);
    assert_non_null(t);
    double q[2] = {0, 1.1};
    assert_int_equal(robot_tree_beyond(t, q), 1);
    q[0] = NAN;
    assert_int_equal(robot_tree_beyond(t, q), 0);
    robot_tree_destroy(t);
#define REFUSED(change, why)                                                                                           \
    do {                                                                                                               \
        robot_joint bad[2] = {two[0], two[1]};                                                                         \
        change;                                                                                                        \
        assert_null(robot_tree_create(bad, 2, &status, &where));                                                       \
        assert_int_equal(status, why);                                                                                 \
        assert_int_equal(where, 1);                                                                                    \
    } while (0)
    REFUSED(bad[1].parent = 1, ROBOT_BAD_PARENT);
    REFUSED(bad[1].parent = -2, ROBOT_BAD_PARENT);
    REFUSED(bad[1].type = 7, ROBOT_BAD_TYPE);
    REFUSED(bad[1].origin.p.x = INFINITY, ROBOT_BAD_ORIGIN);
    REFUSED(bad[1].origin.q.w = 0.5, ROBOT_BAD_ORIGIN);
    REFUSED(bad[1].axis = VEC_ZERO, ROBOT_BAD_AXIS);
    REFUSED(bad[1].axis.y = NAN, ROBOT_BAD_AXIS);
    REFUSED(bad[1].lower = 2, ROBOT_BAD_LIMITS);
    REFUSED(bad[1].upper = NAN, ROBOT_BAD_LIMITS);
    REFUSED(bad[1].mimic = 1, ROBOT_BAD_MIMIC);
    REFUSED(bad[1].mimic = 9, ROBOT_BAD_MIMIC);
    REFUSED((bad[1].mimic = 0, bad[1].factor = NAN), ROBOT_BAD_MIMIC);
    assert_null(robot_tree_create(two, 0, &status, &where));
    assert_int_equal(status, ROBOT_NO_LINKS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sines), cmocka_unit_test(test_poses),
        cmocka_unit_test(test_velocities), cmocka_unit_test(test_bends), cmocka_unit_test(test_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
