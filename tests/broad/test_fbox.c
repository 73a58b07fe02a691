/* Float boxes: outward, inward, and exact at any distance. */
#include "broad/simd.h"
#include "broad_world.h"

#include <float.h>

static double random_double(prng *r)
{
    double x = prng_between(r, -1, 1);
    return ldexp(x, (int)prng_below(r, 120) - 60); /* up to 1e18, down to 1e-18 */
}

static void rounding_is_the_nearest_float_on_its_side(void **state)
{
    (void)state;
    prng r = {1};
    for (int i = 0; i < 100000; i++) {
        double x = random_double(&r);
        float down = float_down(x), up = float_up(x);
        assert_true((double)down <= x && x <= (double)up);
        assert_true((double)nextafterf(down, INFINITY) > x);
        assert_true((double)nextafterf(up, -INFINITY) < x);
    }
}

static void floats_stay_as_they_are(void **state)
{
    (void)state;
    static const float kept[] = {0, 1, -1, FLT_MAX, -FLT_MAX, FLT_MIN, 0x1p-149F, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof kept / sizeof *kept; i++) {
        assert_true(float_down(kept[i]) == kept[i]);
        assert_true(float_up(kept[i]) == kept[i]);
    }
}

static void beyond_the_greatest_float_it_is_still_outward(void **state)
{
    (void)state;
    assert_true(float_down(1e300) == FLT_MAX);
    assert_true(float_up(1e300) == INFINITY);
    assert_true(float_down(-1e300) == -INFINITY);
    assert_true(float_up(-1e300) == -FLT_MAX);
    assert_true(float_down(1e-300) == 0);
    assert_true(float_up(1e-300) == 0x1p-149F);
}

static aabb random_box(prng *r, double center, double reach)
{
    vec3 c = random_vec(r, reach), half = vec(prng_between(r, 0, 1), prng_between(r, 0, 1), prng_between(r, 0, 1));
    return box_at(vec_add(c, vec(center, -center, center)), half);
}

/* The inward box is the double box, as far as float boxes can tell. Oracle: the comparison in doubles. */
static void the_inward_box_meets_the_same_float_boxes(void **state)
{
    (void)state;
    static const double centers[] = {0, 1000, 1e9, 1e12};
    prng r = {2};
    int met = 0;
    for (int i = 0; i < 100000; i++) {
        double center = centers[i % 4];
        aabb query = random_box(&r, center, 1);
        fbox stored = fbox_outward(random_box(&r, center, 1)), inward = fbox_inward(query);
        bool expected = aabb_overlap(fbox_aabb(&stored), query);
        assert_int_equal(fbox_overlap(&inward, &stored), expected);
        met += expected;
    }
    assert_in_range(met, 20000, 99999);
}

static void the_outward_box_contains_the_box(void **state)
{
    (void)state;
    prng r = {3};
    for (int i = 0; i < 100000; i++) {
        aabb box = random_box(&r, ldexp(1, (int)prng_below(&r, 50)), 1);
        fbox outward = fbox_outward(box);
        assert_true(fbox_contains_aabb(&outward, &box));
    }
}

static bool simd_says(const fbox *a, const fbox *b)
{
    struct {
        fbox box;
        float beyond; /* read, and ignored */
    } p = {*a, NAN}, q = {*b, -INFINITY};
    return simd_overlap(simd_load_box(p.box.lo, p.box.hi), simd_load_box(q.box.lo, q.box.hi));
}

static void four_comparisons_at_once_say_what_six_say(void **state)
{
    (void)state;
    prng r = {4};
    int met = 0;
    for (int i = 0; i < 100000; i++) {
        fbox a = fbox_outward(random_box(&r, 0, 1)), b = fbox_outward(random_box(&r, 0, 1));
        int axis = (int)prng_below(&r, 3);
        uint32_t kind = prng_below(&r, 8);
        if (kind == 0) a.lo[axis] = -INFINITY;
        if (kind == 1) a.hi[axis] = b.lo[axis]; /* they touch */
        if (kind == 2) a.hi[axis] = nextafterf(b.lo[axis], -INFINITY);
        assert_int_equal(simd_says(&a, &b), fbox_overlap(&a, &b));
        assert_int_equal(simd_says(&b, &a), fbox_overlap(&b, &a));
        met += fbox_overlap(&a, &b);
    }
    assert_in_range(met, 20000, 80000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rounding_is_the_nearest_float_on_its_side),
        cmocka_unit_test(floats_stay_as_they_are),
        cmocka_unit_test(beyond_the_greatest_float_it_is_still_outward),
        cmocka_unit_test(the_inward_box_meets_the_same_float_boxes),
        cmocka_unit_test(the_outward_box_contains_the_box),
        cmocka_unit_test(four_comparisons_at_once_say_what_six_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
