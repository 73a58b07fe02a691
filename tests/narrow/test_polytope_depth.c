/* polytope_depth by itself, beside epa_depth and in each width of its registers. That depths are true is asked of
 * narrow_query by test_narrow_polytopes, in 113 bits; here it is which machine answers, and that the two agree. */
#include "cases.h"
#include "geom/simd.h"
#include "narrow/convex/epa.h"
#include "narrow/convex/polytope_depth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const narrow_goal FINEST = {0, 0x1p-50, INFINITY, -INFINITY, INFINITY, INFINITY, false};

static hull *ball(random_state *r, size_t count, vec3 half)
{
    vec3 *points = malloc(count * sizeof *points);
    hull *h = NULL;
    assert_non_null(points);
    for (size_t i = 0; i < count; i++) {
        vec3 v = random_direction(r);
        points[i] = vec(half.x * v.x, half.y * v.y, half.z * v.z);
    }
    assert_int_equal(hull_build(&points->x, count, 0, &h), HULL_OK);
    free(points);
    return h;
}

static vec3 random_half(random_state *r)
{
    double x = random_in(r, 0.3, 1), y = random_in(r, 0.3, 1);
    return vec(x, y, random_in(r, 0.3, 1));
}

static epa_scratch *epa_memory(void)
{
    static _Alignas(64) epa_scratch memory;
    return &memory;
}

/* *answered: whether polytope_depth did. False when the pair is apart. */
static bool compare_machines(const shape *a, const shape *b, pose at, bool *answered)
{
    unit_pair p;
    gjk_result start;
    unit_pair_init(&p, a, b, &at);
    gjk_distance(&p, &FINEST, VEC_ZERO, &start);
    if (start.state != GJK_INSIDE) return false;
    span by_epa, narrow = start.span, wide = start.span;
    *answered = polytope_depth_by(false, &p, &FINEST, &start, &narrow);
    if (lanes_wide()) {
        assert_int_equal(polytope_depth_by(true, &p, &FINEST, &start, &wide), *answered);
        assert_memory_equal(&narrow.lo, &wide.lo, offsetof(span, method));
        assert_int_equal(narrow.iterations, wide.iterations);
    }
    if (!*answered) {
        narrow.iterations = start.span.iterations;
        assert_memory_equal(&narrow.lo, &start.span.lo, offsetof(span, method));
        return true;
    }
    epa_depth(&p, &FINEST, &start, epa_memory(), &by_epa);
    assert_true(narrow.lo <= narrow.hi && narrow.hi <= 0 && narrow.hi - narrow.lo <= p.error);
    assert_true(narrow.lo <= by_epa.hi + p.error && by_epa.lo <= narrow.hi + p.error);
    assert_true(fabs(vec_dot(narrow.axis, unit_pair_nearest_along(&p, narrow.axis).w) - narrow.lo) <= p.error);
    return true;
}

static void agrees_with_the_general_machine_in_every_width(void **state)
{
    (void)state;
    random_state r = {41};
    static const size_t SIZES[] = {4, 8, 16, 64, 256};
    size_t asked = 0, answered = 0;
    for (int i = 0; i < 400; i++) {
        hull *a = ball(&r, SIZES[i % 5], random_half(&r)), *b = ball(&r, SIZES[i / 5 % 5], random_half(&r));
        shape sa = {.type = SHAPE_HULL, .hull = a}, sb = {.type = SHAPE_HULL, .hull = b};
        if (i % 7 == 0) sa = random_shape(&r, i % 2 ? SHAPE_BOX : SHAPE_CAPSULE);
        for (int k = 0; k < 5; k++) {
            bool done = false;
            vec3 far = vec_scale(random_direction(&r), random_in(&r, 0.05, 1));
            asked += compare_machines(&sa, &sb, (pose){far, random_rotation(&r)}, &done);
            answered += done;
        }
        hull_destroy(a);
        hull_destroy(b);
    }
    assert_true(asked > 1000);
    assert_true(20 * answered > 19 * asked); /* the rest are slivers and deep pairs of large hulls */
}

/* Cubes as hulls, their corners on a grid: all faces parallel, every tie there is; the depth is exact. */
static void cubes_in_line_have_their_exact_depth(void **state)
{
    (void)state;
    static const double CORNERS[8][3] = {
        {-1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {-1, 1, 1}, {1, -1, -1}, {1, -1, 1}, {1, 1, -1}, {1, 1, 1}};
    hull *cube = NULL;
    assert_int_equal(hull_build(&CORNERS[0][0], 8, 0, &cube), HULL_OK);
    shape s = {.type = SHAPE_HULL, .hull = cube};
    for (int i = 0; i < 343; i++) {
        vec3 at = vec(0.25 * (i / 49) - 0.75, 0.25 * (i / 7 % 7) - 0.75, 0.25 * (i % 7) - 0.75);
        pose b_in_a = {at, {1, 0, 0, 0}};
        narrow_request request = measure_exactly();
        narrow_result x;
        narrow_query(&s, &s, &b_in_a, &request, NULL, case_scratch(), &x);
        double depth = 2 - fmax(fabs(at.x), fmax(fabs(at.y), fabs(at.z)));
        assert_true(x.lo <= -depth && -depth <= x.hi && x.hi - x.lo <= 1e-13);
    }
    hull_destroy(cube);
}

/* Two balls of many vertices, one in the other's middle: no surface of few points shows where it is nearest. */
static void what_takes_too_many_points_is_left_to_the_general_machine(void **state)
{
    (void)state;
    random_state r = {43};
    hull *a = ball(&r, 1000, vec(1, 1, 1)), *b = ball(&r, 1000, vec(1, 1, 1));
    shape sa = {.type = SHAPE_HULL, .hull = a}, sb = {.type = SHAPE_HULL, .hull = b};
    bool answered = true;
    assert_true(compare_machines(&sa, &sb, POSE_IDENTITY, &answered));
    assert_false(answered);
    hull_destroy(a);
    hull_destroy(b);
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
        cmocka_unit_test(agrees_with_the_general_machine_in_every_width),
        cmocka_unit_test(cubes_in_line_have_their_exact_depth),
        cmocka_unit_test(what_takes_too_many_points_is_left_to_the_general_machine),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
