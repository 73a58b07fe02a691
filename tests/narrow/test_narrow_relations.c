/* Relations between answers that hold bit for bit: swap, scaling by 2^k, a representable shift; and with any cache. The
 * oracle is the answer itself, before the change. */
#include "cases.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { PAIRS_EACH = 12 };

typedef struct sample {
    shape a, b;
    pose pa, pb;
} sample;

static sample sample_of(int ta, int tb, int i)
{
    random_state r = {((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i + 4711};
    sample s = {.a = random_shape(&r, (shape_type)ta), .b = random_shape(&r, (shape_type)tb)};
    random_poses(&r, &s.a, &s.b, (enum regime)(i % REGIME_COUNT), &s.pa, &s.pb);
    return s;
}

typedef void relation(const sample *s, const narrow_result *r);

static void for_all_types(relation *holds)
{
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++)
            for (int i = 0; i < PAIRS_EACH; i++) {
                sample s = sample_of(ta, tb, i);
                narrow_request request = measure_exactly();
                narrow_result r;
                narrow_query_world(&s.a, s.pa, &s.b, s.pb, &request, case_scratch(), &r);
                holds(&s, &r);
            }
}

static bool same(double x, double y)
{
    return x == y;
}
static bool same_vec(vec3 x, vec3 y)
{
    return x.x == y.x && x.y == y.y && x.z == y.z;
}
static bool near_vec(vec3 x, vec3 y, double size)
{
    return vec_norm(vec_sub(x, y)) <= 1e-14 * size;
}

static narrow_result ask(const sample *s)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    narrow_query_world(&s->a, s->pa, &s->b, s->pb, &request, case_scratch(), &r);
    return r;
}

static void swap_negates_the_axis(const sample *s, const narrow_result *r)
{
    sample t = {s->b, s->a, s->pb, s->pa};
    narrow_result q = ask(&t);
    vec3 shift = vec_sub(s->pb.p, s->pa.p); /* the two answers have their origins at different shapes */
    assert_true(same(q.lo, r->lo) && same(q.hi, r->hi));
    assert_true(same_vec(vec_neg(q.axis), r->axis));
    double size = vec_norm(shift) + vec_norm(r->point_a) + vec_norm(r->point_b);
    assert_true(near_vec(vec_add(q.point_b, shift), r->point_a, size));
    assert_true(near_vec(vec_add(q.point_a, shift), r->point_b, size));
    assert_true(q.method == r->method && q.iterations == r->iterations && q.status == r->status);
}

static void swap_changes_nothing_else(void **state)
{
    (void)state;
    for_all_types(swap_negates_the_axis);
}

static void shift_is_invisible(const sample *s, const narrow_result *r)
{
    /* positions on a grid of 2^-20, so that the sums below are exact */
    sample t = *s;
    double grid = 0x1p-20;
    vec3 *p[2] = {&t.pa.p, &t.pb.p};
    (void)r;
    for (int i = 0; i < 2; i++)
        *p[i] = vec(floor(p[i]->x / grid) * grid, floor(p[i]->y / grid) * grid, floor(p[i]->z / grid) * grid);
    narrow_result before = ask(&t);
    for (int i = 0; i < 2; i++) *p[i] = vec_add(*p[i], vec(0x1p30 + 0.25, -0x1p25, 3 * 0x1p-20));
    narrow_result after = ask(&t);
    assert_memory_equal(&before.lo, &after.lo, offsetof(narrow_result, manifold));
}

static void a_representable_shift_changes_nothing(void **state)
{
    (void)state;
    for_all_types(shift_is_invisible);
}

static bool scaled(double x, double y, double f)
{
    return x * f == y;
}
static bool scaled_vec(vec3 x, vec3 y, double f)
{
    return scaled(x.x, y.x, f) && scaled(x.y, y.y, f) && scaled(x.z, y.z, f);
}

static hull *scaled_hull(const hull *h, double f)
{
    double points[3 * 64];
    hull *out;
    for (uint32_t i = 0; i < h->vertex_count; i++)
        points[3 * i] = h->x[i] * f, points[3 * i + 1] = h->y[i] * f, points[3 * i + 2] = h->z[i] * f;
    assert_int_equal(hull_build(points, h->vertex_count, 0, &out), HULL_OK);
    return out;
}

static shape scaled_shape(const shape *s, double f)
{
    shape t = *s;
    t.radius *= f;
    t.half = vec_scale(s->half, f);
    if (s->hull) t.hull = scaled_hull(s->hull, f);
    return t;
}

static void scale_is_only_scale(const sample *s, const narrow_result *r)
{
    static const int POWERS[] = {-300, -77, 1, 40, 300};
    for (int i = 0; i < 5; i++) {
        double f = ldexp(1, POWERS[i]);
        sample t = {scaled_shape(&s->a, f), scaled_shape(&s->b, f), s->pa, s->pb};
        t.pa.p = vec_scale(s->pa.p, f);
        t.pb.p = vec_scale(s->pb.p, f);
        narrow_result q = ask(&t);
        if (!scaled(r->lo, q.lo, f) || !scaled(r->hi, q.hi, f))
            fail_msg("%s-%s times 2^%d: [%a, %a] became [%a, %a] by %s", shape_type_name(s->a.type),
                shape_type_name(s->b.type), POWERS[i], r->lo, r->hi, q.lo / f, q.hi / f, narrow_method_name(q.method));
        assert_true(same_vec(q.axis, r->axis));
        assert_true(scaled_vec(r->point_a, q.point_a, f) && scaled_vec(r->point_b, q.point_b, f));
        if (s->a.hull) hull_destroy((hull *)(uintptr_t)t.a.hull);
        if (s->b.hull) hull_destroy((hull *)(uintptr_t)t.b.hull);
    }
}

static void a_power_of_two_scales_every_bit(void **state)
{
    (void)state;
    for_all_types(scale_is_only_scale);
}

static void cache_is_ignored(const sample *s, const narrow_result *r)
{
    pose relative = pose_relative(s->pa, s->pb);
    narrow_request request = measure_exactly();
    narrow_cache cold = {.lower = 0}, warm = {.axis = {0.6, 0, 0.8}, .lower = 1e9, .hint_a = 3, .hint_b = 2};
    narrow_result x, y, z;
    (void)r;
    if (!narrow_ordered(&s->a, 0, &s->b, 1)) return;
    narrow_query(&s->a, &s->b, &relative, &request, NULL, case_scratch(), &x);
    narrow_query(&s->a, &s->b, &relative, &request, &cold, case_scratch(), &y);
    narrow_query(&s->a, &s->b, &relative, &request, &warm, case_scratch(), &z);
    assert_memory_equal(&x.lo, &y.lo, offsetof(narrow_result, manifold));
    assert_memory_equal(&x.lo, &z.lo, offsetof(narrow_result, manifold));
    assert_true(cold.lower == x.lo && warm.lower == x.lo && same_vec(cold.axis, x.axis));
}

static void any_cache_gives_the_same_bits(void **state)
{
    (void)state;
    for_all_types(cache_is_ignored);
}

/* Moving B along the axis by depth x 1.001 separates, by depth x 0.999 does not. */
static void the_depth_separates(const sample *s, const narrow_result *r)
{
    if (!(r->hi < 0) || isinf(r->lo)) return;
    sample t = *s;
    t.pb.p = vec_madd(s->pb.p, -r->lo * 1.001, r->axis);
    narrow_result apart = ask(&t);
    assert_true(apart.lo > 0);
    t.pb.p = vec_madd(s->pb.p, -r->hi * 0.999, r->axis);
    narrow_result inside = ask(&t);
    assert_true(inside.hi < 0);
}

static void moving_by_the_depth_just_separates(void **state)
{
    (void)state;
    for_all_types(the_depth_separates);
}

static void order_is_total(void **state)
{
    (void)state;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++) {
            sample s = sample_of(ta, tb, 1);
            assert_true(narrow_ordered(&s.a, 1, &s.b, 2) != narrow_ordered(&s.b, 2, &s.a, 1));
            assert_true(narrow_ordered(&s.a, 1, &s.a, 2) && !narrow_ordered(&s.a, 2, &s.a, 1));
        }
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
        cmocka_unit_test(swap_changes_nothing_else),
        cmocka_unit_test(a_representable_shift_changes_nothing),
        cmocka_unit_test(a_power_of_two_scales_every_bit),
        cmocka_unit_test(any_cache_gives_the_same_bits),
        cmocka_unit_test(moving_by_the_depth_just_separates),
        cmocka_unit_test(order_is_total),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
