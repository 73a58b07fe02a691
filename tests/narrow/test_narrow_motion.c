/* Proofs without a search: separation along any axis never exceeds the 113-bit one, and no point moves farther than the
 * motion bound says. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static void separation_is_never_more_than_the_true_one(void **state)
{
    (void)state;
    double worst = 0;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++)
            for (int i = 0; i < 64; i++) {
                random_state r = {((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i + 31};
                shape a = random_shape(&r, (shape_type)ta), b = random_shape(&r, (shape_type)tb);
                if (ta == SHAPE_HALFSPACE || tb == SHAPE_HALFSPACE) continue; /* the axis is theirs: see below */
                pose pa, pb;
                random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &pa, &pb);
                pa = POSE_IDENTITY;
                vec3 axis = random_direction(&r);
                uint32_t hint_a = 0, hint_b = 0;
                double s = narrow_separation(&a, &b, &pb, axis, &hint_a, &hint_b);
                placed oa = oracle_place(&a, pa, VEC_ZERO), ob = oracle_place(&b, pb, VEC_ZERO);
                double slack = (double)(oracle_separation(&oa, &ob, real3_of(axis)) - s);
                assert_true(slack >= 0);
                worst = fmax(worst, slack / (vec_norm(pb.p) + shape_reach(&a) + shape_reach(&b)));
            }
    assert_true(worst < 1e-14);
}

static void separation_from_a_plane_is_its_height(void **state)
{
    (void)state;
    shape plane = {.type = SHAPE_HALFSPACE}, ball = {.type = SHAPE_SPHERE, .radius = 0.5};
    pose at = {{0, 0, -2}, {0, 1, 0, 0}}; /* turned over: it faces down, the ball is below it by 2 */
    double s = narrow_separation(&ball, &plane, &at, vec(1, 0, 0), NULL, NULL);
    assert_true(s <= -2.5 && s > -2.5 - 1e-14);
    at.p.z = 2;
    s = narrow_separation(&ball, &plane, &at, vec(0, 0, 1), NULL, NULL);
    assert_true(s <= 1.5 && s > 1.5 - 1e-14);
}

static void no_point_moves_farther_than_the_bound(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 4000; i++) {
        random_state r = {i};
        double reach = random_in(&r, 0, 3), step = pow(10, -random_in(&r, 0, 17));
        pose before = {vec_scale(random_direction(&r), random_in(&r, 0, 10)), random_rotation(&r)}, now = before;
        vec3 spin = vec_scale(random_direction(&r), step),
             shift = vec_scale(random_direction(&r), random_unit(&r) * step);
        now.p = vec_add(now.p, shift);
        now.q = quat_unit(quat_mul(before.q, (quat){1, spin.x, spin.y, spin.z}));
        double bound = narrow_motion_bound(&before, &now, reach);
        for (int k = 0; k < 8; k++) {
            shape point = {.type = SHAPE_SPHERE};
            real3 x = real3_scale(real3_of(random_direction(&r)), reach * (1 - 1e-15));
            placed p0 = oracle_place(&point, before, VEC_ZERO), p1 = oracle_place(&point, now, VEC_ZERO);
            real3 moved = real3_sub(oracle_point(&p1, x), oracle_point(&p0, x));
            assert_true(real3_dot(moved, moved) <= (real)bound * bound);
        }
        assert_true(bound <= 2.2 * step * reach + step + 1e-13);
    }
}

static void what_does_not_move_is_bounded_by_zero(void **state)
{
    (void)state;
    pose p = {{1, 2, 3}, {0.5, 0.5, 0.5, 0.5}};
    assert_true(narrow_motion_bound(&p, &p, 2) == 0);
    assert_true(isinf(narrow_motion_bound(&p, &p, INFINITY)));
}

static int create(void **state)
{
    (void)state;
    cases_create();
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    cases_destroy();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(separation_is_never_more_than_the_true_one),
        cmocka_unit_test(separation_from_a_plane_is_its_height),
        cmocka_unit_test(no_point_moves_farther_than_the_bound),
        cmocka_unit_test(what_does_not_move_is_bounded_by_zero),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
