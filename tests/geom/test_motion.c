/* Motions: poses against 113-bit sine and cosine, within motion_error; motion_between reaches its end; boxes contain
 * the shape at every sampled time. */
#include "geom/motion.h"
#include "geom/support.h"
#include "oracle/quad.h"
#include "random_shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { MOTIONS = 4000, BOXES = 1500, TIMES = 24, DIRECTIONS = 12 };

/* ---- sine and cosine of 113 bits ---- */

/* pi to 113 bits: three doubles that do not overlap. */
static quad pi(void)
{
    return (quad)0x1.921fb54442d18p+1 + (quad)0x1.1a62633145c07p-53 + (quad)-0x1.f1976b7ed8fbcp-109;
}

/* Their Taylor series, after whole turns are taken off. */
static void sine_cosine(quad x, quad *sine, quad *cosine)
{
    quad turn = 2 * pi();
    x -= turn * (quad)(long long)(double)(x / turn);
    quad term = 1, sum[2] = {0, 0};
    for (int k = 0; k < 60; k++) {
        sum[k & 1] += k & 2 ? -term : term;
        term = term * x / (k + 1);
    }
    *cosine = sum[0];
    *sine = sum[1];
}

static qvec wide(vec3 v)
{
    return qv(v.x, v.y, v.z);
}

/* Rodrigues: v turned about a unit axis. */
static qvec turned(qvec v, qvec axis, quad angle)
{
    quad s, c;
    sine_cosine(angle, &s, &c);
    qvec along = q_scale(axis, q_dot(axis, v) * (1 - c));
    return q_add(q_add(q_scale(v, c), q_scale(q_cross(axis, v), s)), along);
}

/* v by a quaternion, divided by its norm. */
static qvec rotated(quat q, qvec v)
{
    qvec u = qv(q.x, q.y, q.z);
    quad w = q.w, norm2 = w * w + q_dot(u, u);
    qvec t = q_scale(q_cross(u, v), 2 / norm2);
    return q_add(v, q_add(q_scale(t, w), q_cross(u, t)));
}

/* Where a point of the body is at a time, by the numbers of the motion. */
static qvec truth_at(const motion *m, double time, vec3 point)
{
    quad speed = q_norm(wide(m->angular));
    qvec x = rotated(m->start.q, wide(point));
    if (speed > 0) x = turned(x, q_scale(wide(m->angular), 1 / speed), speed * (quad)time);
    return q_add(x, q_add(wide(m->start.p), q_scale(wide(m->linear), time)));
}

static motion random_motion(uint64_t *state, double most_angle)
{
    motion m = {random_pose(state, 10), random_vec(state, 20), VEC_ZERO};
    if (prng_bits(state) % 8) m.angular = vec_scale(random_unit(state), prng_in(state, 0, most_angle));
    return m;
}

static void poses_are_within_their_error(void **state)
{
    (void)state;
    static const double MOST[] = {1e-9, 1e-3, 1, 30, 1000, MOTION_ANGLE_MAX};
    uint64_t random = 11;
    double worst = 0;
    for (int i = 0; i < MOTIONS; i++) {
        motion m = random_motion(&random, MOST[i % 6]);
        double time = prng_in(&random, 0, 1), reach = prng_in(&random, 0.1, 5);
        vec3 point = vec_scale(random_unit(&random), reach);
        pose p = motion_pose(&m, time);
        qvec got = q_add(rotated(p.q, wide(point)), wide(p.p));
        double off = (double)q_norm(q_sub(got, truth_at(&m, time, point)));
        double error = motion_error(&m, time, reach * (1 + 1e-15));
        if (!(off <= error)) fail_msg("motion %d at %g: off by %g, %g allowed", i, time, off, error);
        worst = fmax(worst, off / error);
    }
    print_message("at worst %.2g of the error that is allowed\n", worst);
    assert_true(worst > 1e-3); /* the bound means something */
}

static void whole_multiples_of_a_quarter_turn_are_exact_enough(void **state)
{
    (void)state;
    for (int k = 1; k < 2000; k++) {
        motion m = {POSE_IDENTITY, VEC_ZERO, {0, 0, 0.5 * (double)pi() * k}};
        pose p = motion_pose(&m, 1);
        qvec got = rotated(p.q, qv(1, 0, 0));
        assert_true((double)q_norm(q_sub(got, truth_at(&m, 1, vec(1, 0, 0)))) <= motion_error(&m, 1, 1));
    }
}

static void between_two_poses_it_reaches_the_second(void **state)
{
    (void)state;
    uint64_t random = 12;
    for (int i = 0; i < MOTIONS; i++) {
        pose from = random_pose(&random, 10), to = random_pose(&random, 10);
        if (i % 4 == 1) to.q = from.q;
        if (i % 4 == 2) to.q = quat_unit(quat_mul((quat){1, 1e-9 * prng_in(&random, -1, 1), 0, 1e-12}, from.q));
        if (i % 4 == 3) to.q = (quat){-to.q.w, -to.q.x, -to.q.y, -to.q.z};
        double span = prng_in(&random, 0.001, 10);
        motion m = motion_between(from, to, span);
        assert_true(vec_norm(m.angular) * span <= (double)pi() * (1 + 1e-15)); /* the shorter way */
        pose end = motion_pose(&m, span);
        assert_true(vec_norm(vec_sub(end.p, to.p)) <= 1e-14 * 20);
        vec3 point = random_unit(&random);
        double off = vec_norm(vec_sub(quat_rotate(end.q, point), quat_rotate(to.q, point)));
        if (off > 1e-14) fail_msg("motion %d: off by %g", i, off);
        if (i % 4 == 1) assert_true(vec_norm(m.angular) * span <= 1e-15);
    }
}

static bool inside(const aabb *box, vec3 p)
{
    return p.x >= box->lo.x && p.x <= box->hi.x && p.y >= box->lo.y && p.y <= box->hi.y && p.z >= box->lo.z &&
           p.z <= box->hi.z;
}

static void boxes_contain_all_of_the_motion(void **state)
{
    (void)state;
    static const double MOST[] = {0.3, 3, 7, 60};
    uint64_t random = 13;
    double volume = 0, tight = 0;
    for (int i = 0; i < BOXES; i++) {
        motion m = random_motion(&random, MOST[i % 4]);
        shape s = random_plain_shape(&random, 1);
        pose local = i % 2 ? random_pose(&random, 1) : POSE_IDENTITY;
        aabb box = motion_bounds(&m, &s, local, 1),
             sampled = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
        for (int k = 0; k <= TIMES; k++) {
            pose at = pose_mul(motion_pose(&m, (double)k / TIMES), local);
            mat3 r = quat_matrix(at.q);
            for (int d = 0; d < DIRECTIONS; d++) {
                vec3 u = random_unit(&random);
                vec3 x = vec_add(mat_mul(r, support_core(&s, mat_tmul(r, u), NULL)), at.p);
                x = vec_madd(x, s.radius * (1 - 1e-12), u);
                if (!inside(&box, x)) fail_msg("motion %d at %d/%d: outside", i, k, TIMES);
            }
            sampled = aabb_union(sampled, shape_bounds(&s, at));
        }
        if (vec_norm(m.angular) < 3) {
            vec3 a = vec_sub(box.hi, box.lo), b = vec_sub(sampled.hi, sampled.lo);
            volume += a.x + a.y + a.z, tight += b.x + b.y + b.z;
        }
    }
    print_message("edges %.3f of those of the samples, below half a turn\n", volume / tight);
    assert_true(volume < 1.1 * tight); /* and the boxes are no larger than they need be */
}

static void half_spaces_that_turn_have_no_bounds(void **state)
{
    (void)state;
    shape plane = {.type = SHAPE_HALFSPACE};
    motion m = {POSE_IDENTITY, {1, 0, 0}, {0, 0.1, 0}};
    aabb box = motion_bounds(&m, &plane, POSE_IDENTITY, 1);
    assert_true(isinf(box.hi.z) && isinf(box.lo.z) && isinf(box.hi.x));
    m.angular = VEC_ZERO;
    box = motion_bounds(&m, &plane, POSE_IDENTITY, 1);
    assert_true(box.hi.z >= 0 && box.hi.z < 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_are_within_their_error),
        cmocka_unit_test(whole_multiples_of_a_quarter_turn_are_exact_enough),
        cmocka_unit_test(between_two_poses_it_reaches_the_second),
        cmocka_unit_test(boxes_contain_all_of_the_motion),
        cmocka_unit_test(half_spaces_that_turn_have_no_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
