/* Properties of the boxes: every point of the shape is inside (sampled support points, in __float128), and each side is
 * touched to 1e-13 of the size. */
#include "geom/bounds.h"
#include "geom/support.h"
#include "random_shapes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

typedef __float128 wide;

/* p + R(q) v with q taken to unit norm: coordinate k, exactly enough. */
static wide posed(pose at, vec3 v, int k)
{
    wide w = at.q.w, x = at.q.x, y = at.q.y, z = at.q.z, n = w * w + x * x + y * y + z * z;
    if (k == 0)
        return at.p.x + ((n - 2 * (y * y + z * z)) * v.x + 2 * (x * y - w * z) * v.y + 2 * (x * z + w * y) * v.z) / n;
    if (k == 1)
        return at.p.y + (2 * (x * y + w * z) * v.x + (n - 2 * (x * x + z * z)) * v.y + 2 * (y * z - w * x) * v.z) / n;
    return at.p.z + (2 * (x * z - w * y) * v.x + 2 * (y * z + w * x) * v.y + (n - 2 * (x * x + y * y)) * v.z) / n;
}

/* Points that lie within the core for sure: support points, drawn in a little where they are computed by rounding. */
static vec3 sample(const shape *s, vec3 d)
{
    vec3 p = support_core(s, d, NULL);
    bool exact = s->type == SHAPE_BOX || s->type == SHAPE_CAPSULE || s->type == SHAPE_HULL;
    return exact ? p : vec_scale(p, 1 - 1e-15);
}

static void assert_contains(aabb b, pose at, vec3 v, double radius)
{
    const double lo[] = {b.lo.x, b.lo.y, b.lo.z}, hi[] = {b.hi.x, b.hi.y, b.hi.z};
    for (int k = 0; k < 3; k++) {
        assert_true(posed(at, v, k) - radius >= lo[k]);
        assert_true(posed(at, v, k) + radius <= hi[k]);
    }
}

static void assert_touches(aabb b, const shape *s, pose at)
{
    const double lo[] = {b.lo.x, b.lo.y, b.lo.z}, hi[] = {b.hi.x, b.hi.y, b.hi.z};
    const vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double slack = 1e-13 * (shape_reach(s) + vec_max_abs(at.p));
    mat3 r = quat_matrix(at.q);
    for (int k = 0; k < 3; k++) {
        vec3 up = mat_tmul(r, axes[k]);
        assert_true(posed(at, support_core(s, up, NULL), k) + s->radius >= hi[k] - slack);
        assert_true(posed(at, support_core(s, vec_neg(up), NULL), k) - s->radius <= lo[k] + slack);
    }
}

static void check_box(const shape *s, pose at, uint64_t *seed)
{
    aabb b = shape_bounds(s, at);
    mat3 r = quat_matrix(at.q);
    const vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int k = 0; k < 3; k++) {
        assert_contains(b, at, sample(s, mat_tmul(r, axes[k])), s->radius);
        assert_contains(b, at, sample(s, vec_neg(mat_tmul(r, axes[k]))), s->radius);
    }
    for (int k = 0; k < 20; k++) assert_contains(b, at, sample(s, random_unit(seed)), s->radius);
    assert_touches(b, s, at);
}

static void boxes_contain_their_shapes_and_are_tight(void **state)
{
    (void)state;
    uint64_t seed = 11;
    static const double sizes[] = {1e-6, 1, 1e6, 1e140, 1e-140};
    for (int i = 0; i < 3000; i++) {
        shape s = random_plain_shape(&seed, sizes[i % 5]);
        pose at = random_pose(&seed, i % 3 ? 10 * sizes[i % 5] : 0);
        if (i % 13 == 0) at.q = POSE_IDENTITY.q;
        check_box(&s, at, &seed);
    }
}

static void boxes_contain_their_hulls_and_are_tight(void **state)
{
    (void)state;
    uint64_t seed = 12;
    for (int i = 0; i < 40; i++) {
        hull *h = random_hull(&seed, 4 + prng_bits(&seed) % 100, i % 2 ? 1 : 1e-5, i % 3);
        assert_non_null(h);
        shape s = {.type = SHAPE_HULL, .hull = h, .radius = i % 4 ? 0 : 0.1};
        check_box(&s, random_pose(&seed, 3), &seed);
        hull_destroy(h);
    }
}

static void a_quaternion_off_unit_widens_the_box_enough(void **state)
{
    (void)state;
    uint64_t seed = 13;
    shape s = {.type = SHAPE_BOX, .half = {1, 2, 3}};
    for (int i = 0; i < 1000; i++) {
        pose at = random_pose(&seed, 1);
        double off = 1 + prng_in(&seed, -1e-6, 1e-6);
        at.q = (quat){at.q.w * off, at.q.x * off, at.q.y * off, at.q.z * off};
        aabb b = shape_bounds(&s, at);
        for (int k = 0; k < 8; k++) assert_contains(b, at, vec(k & 1 ? 1 : -1, k & 2 ? 2 : -2, k & 4 ? 3 : -3), 0);
    }
}

static void a_halfspace_is_bounded_only_where_it_faces_an_axis(void **state)
{
    (void)state;
    shape s = {.type = SHAPE_HALFSPACE, .radius = 0.5};
    aabb level = shape_bounds(&s, (pose){{1, 2, 3}, {1, 0, 0, 0}});
    assert_true(level.hi.z == 3.5 && isinf(level.lo.z) && isinf(level.hi.x) && isinf(level.lo.y));
    aabb upside_down = shape_bounds(&s, (pose){{1, 2, 3}, {0, 1, 0, 0}});
    assert_true(upside_down.lo.z == 2.5 && isinf(upside_down.hi.z));
    aabb tilted = shape_bounds(&s, (pose){{1, 2, 3}, quat_unit((quat){1, 1e-9, 0, 0})});
    assert_true(isinf(tilted.hi.z) && isinf(tilted.lo.z));
}

static void relations_of_boxes(void **state)
{
    (void)state;
    aabb a = {{0, 0, 0}, {1, 1, 1}}, touching = {{1, 0, 0}, {2, 1, 1}}, apart = {{0, 1.5, 0}, {1, 2, 1}};
    assert_true(aabb_overlap(a, touching));
    assert_false(aabb_overlap(a, apart));
    assert_true(aabb_overlap(a, aabb_grow(apart, 0.5)));
    assert_true(aabb_contains(aabb_union(a, apart), a));
    assert_true(aabb_contains(aabb_union(a, apart), apart));
    assert_false(aabb_contains(a, touching));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes_contain_their_shapes_and_are_tight),
        cmocka_unit_test(boxes_contain_their_hulls_and_are_tight),
        cmocka_unit_test(a_quaternion_off_unit_widens_the_box_enough),
        cmocka_unit_test(a_halfspace_is_bounded_only_where_it_faces_an_axis),
        cmocka_unit_test(relations_of_boxes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
