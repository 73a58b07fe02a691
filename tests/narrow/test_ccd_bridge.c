/* Properties of libccd behind its bridge. The oracle of a proposed axis is support_height_up: an axis that separates by
 * it separates; the oracle of an overlap is a common point of both shapes. */
#include "geom/random_shapes.h"
#include "geom/support.h"
#include "narrow/ccd_bridge.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* The certified gap along `axis`: positive = apart. */
static double gap_along(const shape *a, const shape *b, const transform *t, vec3 axis)
{
    vec3 towards_a = mat_tmul(t->r, vec_neg(axis));
    double reach_b = support_height_up(b, towards_a, NULL) + b->radius,
           reach_a = support_height_up(a, axis, NULL) + a->radius;
    return vec_dot(axis, t->t) - reach_b - reach_a;
}

static shape random_solid(uint64_t *seed, double size, hull **owned)
{
    *owned = NULL;
    uint64_t kind = prng_bits(seed) % 3;
    if (kind == 0) *owned = random_hull(seed, 20, size, true);
    if (*owned) return (shape){.type = SHAPE_HULL, .hull = *owned};
    vec3 half = vec(prng_in(seed, 0.2, 1) * size, 0, prng_in(seed, 0.2, 1) * size);
    half.y = kind == 1 ? prng_in(seed, 0.2, 1) * size : half.x;
    return (shape){
        .type = kind == 1 ? SHAPE_BOX : SHAPE_CYLINDER, .half = half, .radius = prng_bits(seed) % 2 ? 0.1 * size : 0};
}

static void axes_of_misses_separate_at_any_scale(void **state)
{
    (void)state;
    static const double sizes[] = {1e-150, 1e-6, 1, 1e6, 1e150 / 8};
    uint64_t seed = 41;
    int misses = 0, overlaps = 0;
    for (int i = 0; i < 2500; i++) {
        double size = sizes[i % 5];
        hull *owned[2];
        shape a = random_solid(&seed, size, &owned[0]), b = random_solid(&seed, size, &owned[1]);
        transform t = pose_transform(random_pose(&seed, 2 * size));
        ccd_proposal gjk, mpr;
        ccd_bridge_gjk(&a, &b, &t, i % 2 ? random_unit(&seed) : VEC_ZERO, &gjk);
        ccd_bridge_mpr(&a, &b, &t, &mpr);
        if (gjk.answered && !gjk.overlap) assert_true(gap_along(&a, &b, &t, gjk.axis) > -1e-9 * size);
        if (mpr.answered && !mpr.overlap) assert_true(gap_along(&a, &b, &t, mpr.axis) > -1e-9 * size);
        misses += gjk.answered && !gjk.overlap && gap_along(&a, &b, &t, gjk.axis) > 0;
        overlaps += gjk.answered && gjk.overlap;
        hull_destroy(owned[0]);
        hull_destroy(owned[1]);
    }
    assert_true(misses > 700 && overlaps > 700);
}

/* The same bits, scaled: the bridge brings every pair to unit size. */
static void scaling_by_a_power_of_two_changes_nothing_else(void **state)
{
    (void)state;
    uint64_t seed = 42;
    for (int i = 0; i < 500; i++) {
        shape a = random_plain_shape(&seed, 1), b = random_plain_shape(&seed, 1);
        transform t = pose_transform(random_pose(&seed, 1));
        double scale = ldexp(1, (int)(prng_bits(&seed) % 400) - 200);
        shape scaled_a = a, scaled_b = b;
        scaled_a.half = vec_scale(a.half, scale);
        scaled_a.radius *= scale;
        scaled_b.half = vec_scale(b.half, scale);
        scaled_b.radius *= scale;
        transform scaled_t = {t.r, vec_scale(t.t, scale)};
        ccd_proposal plain, scaled;
        ccd_bridge_gjk(&a, &b, &t, VEC_ZERO, &plain);
        ccd_bridge_gjk(&scaled_a, &scaled_b, &scaled_t, VEC_ZERO, &scaled);
        assert_int_equal(plain.answered, scaled.answered);
        assert_int_equal(plain.overlap, scaled.overlap);
        assert_memory_equal(&plain.axis, &scaled.axis, sizeof plain.axis);
        assert_true(plain.depth * scale == scaled.depth);
    }
}

static void a_common_centre_overlaps(void **state)
{
    (void)state;
    uint64_t seed = 43;
    for (int i = 0; i < 500; i++) {
        hull *owned[2];
        shape a = random_solid(&seed, 1, &owned[0]), b = random_solid(&seed, 1, &owned[1]);
        transform t = pose_transform((pose){VEC_ZERO, random_rotation(&seed)});
        ccd_proposal gjk, mpr;
        ccd_bridge_gjk(&a, &b, &t, VEC_ZERO, &gjk);
        ccd_bridge_mpr(&a, &b, &t, &mpr);
        assert_true(!gjk.answered || (gjk.overlap && gjk.depth > 0));
        assert_true(mpr.answered && mpr.overlap && mpr.depth > 0);
        hull_destroy(owned[0]);
        hull_destroy(owned[1]);
    }
}

static void the_depth_axis_points_from_a_to_b(void **state)
{
    (void)state;
    shape box = {.type = SHAPE_BOX, .half = {1, 1, 1}};
    transform above = pose_transform((pose){{0.1, 0.05, 1.9}, {1, 0, 0, 0}});
    ccd_proposal out;
    ccd_bridge_gjk(&box, &box, &above, VEC_ZERO, &out);
    assert_true(out.answered && out.overlap && out.axis.z > 0.999 && fabs(out.depth - 0.1) < 1e-3);
    ccd_bridge_mpr(&box, &box, &above, &out);
    assert_true(out.answered && out.overlap && out.axis.z > 0.9);
    above.t.z = 2.1;
    ccd_bridge_gjk(&box, &box, &above, VEC_ZERO, &out);
    assert_true(out.answered && !out.overlap && out.axis.z > 0);
}

static void a_seed_that_is_the_answer_is_quick_to_confirm(void **state)
{
    (void)state;
    uint64_t seed = 44;
    for (int i = 0; i < 500; i++) {
        hull *owned[2];
        shape a = random_solid(&seed, 1, &owned[0]), b = random_solid(&seed, 1, &owned[1]);
        transform t = pose_transform(random_pose(&seed, 3));
        ccd_proposal cold, warm;
        ccd_bridge_gjk(&a, &b, &t, VEC_ZERO, &cold);
        if (cold.answered && !cold.overlap) {
            ccd_bridge_gjk(&a, &b, &t, cold.axis, &warm);
            assert_true(warm.answered && !warm.overlap);
        }
        hull_destroy(owned[0]);
        hull_destroy(owned[1]);
    }
}

/* Concentric spheres: every direction is the least depth, and libccd's EPA refines the whole sphere. It must come back,
 * and where it was stopped it must say so. */
static void the_iteration_limit_ends_every_call(void **state)
{
    (void)state;
    uint64_t seed = 45;
    int ended = 0;
    for (int i = 0; i < 60; i++) {
        shape a = {.type = SHAPE_SPHERE, .radius = prng_in(&seed, 0.1, 1)}, b = a;
        b.radius = prng_in(&seed, 0.1, 1);
        transform t = pose_transform(POSE_IDENTITY);
        ccd_proposal out;
        ccd_bridge_gjk(&a, &b, &t, random_unit(&seed), &out);
        ended += !out.answered;
        assert_true(!out.answered || out.overlap);
    }
    assert_true(ended > 0);
}

static void degenerate_shapes_come_back(void **state)
{
    (void)state;
    const shape thin[] = {{.type = SHAPE_SPHERE}, {.type = SHAPE_SPHERE, .radius = 1}, {.type = SHAPE_CAPSULE},
        {.type = SHAPE_BOX}, {.type = SHAPE_BOX, .half = {1, 1, 0}}, {.type = SHAPE_BOX, .half = {0, 1, 0}},
        {.type = SHAPE_CYLINDER}, {.type = SHAPE_CYLINDER, .half = {1, 1, 0}},
        {.type = SHAPE_CYLINDER, .half = {0, 0, 1}}, {.type = SHAPE_CONE, .half = {1, 1, 0}}, {.type = SHAPE_ELLIPSOID},
        {.type = SHAPE_ELLIPSOID, .half = {1, 1, 0}}};
    uint64_t seed = 46;
    for (size_t i = 0; i < sizeof thin / sizeof *thin; i++)
        for (size_t j = 0; j < sizeof thin / sizeof *thin; j++)
            for (int k = 0; k < 40; k++) {
                pose at = k ? random_pose(&seed, k % 4) : POSE_IDENTITY;
                if (k % 5 == 0) at.q = POSE_IDENTITY.q;
                transform t = pose_transform(at);
                ccd_proposal gjk, mpr;
                ccd_bridge_gjk(&thin[i], &thin[j], &t, VEC_ZERO, &gjk);
                ccd_bridge_mpr(&thin[i], &thin[j], &t, &mpr);
                assert_true(vec_finite(gjk.axis) && isfinite(gjk.depth));
                assert_true(vec_finite(mpr.axis) && isfinite(mpr.depth));
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_of_misses_separate_at_any_scale),
        cmocka_unit_test(scaling_by_a_power_of_two_changes_nothing_else),
        cmocka_unit_test(a_common_centre_overlaps),
        cmocka_unit_test(the_depth_axis_points_from_a_to_b),
        cmocka_unit_test(a_seed_that_is_the_answer_is_quick_to_confirm),
        cmocka_unit_test(the_iteration_limit_ends_every_call),
        cmocka_unit_test(degenerate_shapes_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
