/* narrow_apart: what it says is so, its proof holds, and it finds most of what there is to find. */
#include "cases.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static size_t rounds_of(size_t ci)
{
    return getenv("COLLIDED_NIGHTLY") ? 60 * ci : getenv("COLLIDED_BRIEF") ? ci / 8 : ci;
}

static void a_proof_is_true_and_can_be_checked(void **state)
{
    (void)state;
    random_state r = {91};
    size_t apart = 0, proven = 0;
    cases_create();
    for (size_t i = 0; i < rounds_of(40000); i++) {
        shape a = random_shape(&r, (shape_type)(i % SHAPE_CONVEX_COUNT)),
              b = random_shape(&r, (shape_type)(i / SHAPE_CONVEX_COUNT % SHAPE_CONVEX_COUNT));
        pose at_a, at_b;
        if (!narrow_ordered(&a, 0, &b, 1)) continue;
        bool planes = a.type == SHAPE_HALFSPACE || b.type == SHAPE_HALFSPACE;
        random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &at_a, &at_b);
        pose b_in_a = pose_relative(at_a, at_b);
        narrow_cache cache = {.axis = i % 3 ? VEC_ZERO : random_direction(&r), .hint_a = 7, .hint_b = 1 << 20},
                     before = cache;
        narrow_request exactly = measure_exactly();
        narrow_result truth;
        double limit = i % 2 ? 0 : random_in(&r, -0.2, 0.2);
        narrow_query(&a, &b, &b_in_a, &exactly, NULL, case_scratch(), &truth);
        bool said = narrow_apart(&a, &b, &b_in_a, limit, &cache);
        apart += truth.lo > limit;
        proven += said;
        if (!said) {
            assert_memory_equal(&cache.axis, &before.axis, sizeof cache.axis);
            assert_true(cache.lower == before.lower);
            continue;
        }
        assert_true(truth.hi > limit && cache.lower > limit && cache.lower <= truth.hi);
        assert_memory_equal(&cache.b_in_a, &b_in_a, sizeof b_in_a);
        uint32_t hint_a = 0, hint_b = 0;
        if (planes) continue;
        double separation = narrow_separation(&a, &b, &b_in_a, cache.axis, &hint_a, &hint_b);
        double rounding = 0x1p-47 * (shape_reach(&a) + shape_reach(&b) + vec_norm(b_in_a.p)); /* hulls: added up anew */
        assert_true(fabs(separation - cache.lower) <= (a.type == SHAPE_HULL && b.type == SHAPE_HULL ? rounding : 0));
    }
    cases_destroy();
    assert_true(10 * proven > 9 * apart && apart > rounds_of(40000) / 16);
}

/* A remembered axis that still parts them is the one that is told, and nothing beside it is looked at. */
static void what_is_remembered_comes_first(void **state)
{
    (void)state;
    shape box = {.type = SHAPE_BOX, .half = {1, 1, 1}};
    pose at = {{4, 1, 0}, {1, 0, 0, 0}};
    vec3 slanted = vec_unit(vec(1, 0.5, 0.25));
    narrow_cache cache = {.axis = slanted, .lower = 3};
    assert_true(narrow_apart(&box, &box, &at, 0.1, &cache));
    assert_memory_equal(&cache.axis, &slanted, sizeof slanted);
    assert_false(narrow_apart(&box, &box, &at, 2.5, &cache));
    assert_true(narrow_apart(&box, &box, &at, 1.99, &cache));
    assert_true(cache.lower > 1.99 && cache.lower <= 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_proof_is_true_and_can_be_checked),
        cmocka_unit_test(what_is_remembered_comes_first),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
