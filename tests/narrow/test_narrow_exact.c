/* The last bits: pairs that rounding of doubles leaves undecided are decided in double-double, against the oracle in
 * 113 bits; what doubles settle does not pay for it. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static narrow_result asked(const shape *a, pose pa, const shape *b, pose pb, double tolerance)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    request.tolerance = tolerance;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &r);
    return r;
}

static double ulp(double x)
{
    return nextafter(fabs(x), INFINITY) - fabs(x);
}

/* Without a turn, every number that enters is exact: so must the answer be, whatever the ratio of the sizes: to 4
 * ulp of itself, beside 94 bits of the size. */
static void unturned_pairs_are_exact_to_the_last_bits(void **state)
{
    (void)state;
    static const shape ball = {.type = SHAPE_SPHERE, .radius = 1}, planet = {.type = SHAPE_SPHERE, .radius = 1e9};
    static const shape box = {.type = SHAPE_BOX, .half = {.5, .5, .5}};
    static const shape ground = {.type = SHAPE_BOX, .half = {1e9, 1e9, 1e9}};
    static const shape rod = {.type = SHAPE_CYLINDER, .half = {1e6, 1e6, 1e9}};
    static const struct {
        const shape *a, *b;
        vec3 at;
        double expected;
    } cases[] = {
        {&ball, &ball, {2.0000000000000004, 0, 0}, 0x1p-51},
        {&planet, &ball, {1000000001 + 0x1p-20, 0, 0}, 0x1p-20},
        {&ground, &box, {0, 0, 1e9 + .5 - 0x1p-20}, -0x1p-20},
        {&ground, &box, {0, 0, 1e9 + .5 + 0x1p-20}, 0x1p-20},
        {&ball, &ground, {0, 0, 1e9 + 1 + 0x1p-20}, 0x1p-20},
        {&rod, &ball, {1e6 + 1 + 0x1p-20, 0, 0}, 0x1p-20},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        pose o = POSE_IDENTITY, at = {cases[i].at, {1, 0, 0, 0}};
        narrow_result r = asked(cases[i].a, o, cases[i].b, at, 0);
        double expected = cases[i].expected;
        assert_true(r.refined);
        assert_true(r.lo <= expected && expected <= r.hi);
        double size = shape_reach(cases[i].a) + shape_reach(cases[i].b) + vec_norm(at.p);
        if (!(r.hi - r.lo <= 4 * ulp(expected) + 0x1p-94 * size)) fail_msg("case %zu: [%.17g, %.17g]", i, r.lo, r.hi);
    }
}

/* At any turn the axis that is returned still proves lo, and no direction separates by more than hi. */
static void turned_pairs_are_proved_without_slack(void **state)
{
    (void)state;
    static const shape_type kinds[] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_HULL, SHAPE_CONE};
    double widest = 0;
    for (uint64_t seed = 1; seed <= 600; seed++) {
        random_state random = {seed};
        size_t i = seed % 4, k = seed / 4 % (i == 0 ? 5 : 4);
        shape a = random_shape(&random, kinds[i]), b = random_shape(&random, kinds[k]);
        pose pa, pb;
        random_poses(&random, &a, &b, (enum regime)(seed % REGIME_COUNT), &pa, &pb);
        narrow_result r = asked(&a, pa, &b, pb, 0);
        placed oa = oracle_place(&a, pa, pa.p), ob = oracle_place(&b, pb, pa.p);
        real s = oracle_separation(&oa, &ob, real3_of(r.axis));
        if (!r.refined || s < r.lo || !(r.lo <= r.hi)) fail_msg("seed %llu", (unsigned long long)seed);
        double size = shape_reach(&a) + shape_reach(&b) + vec_norm(vec_sub(pb.p, pa.p));
        bool hulls_overlap = (kinds[i] == SHAPE_HULL || kinds[k] == SHAPE_HULL) && r.hi < 0;
        if (!hulls_overlap) widest = fmax(widest, (r.hi - r.lo) / size);
    }
    if (!(widest <= 4e-15)) fail_msg("width %g of the size", widest);
}

/* B's frame is A's but for a turn that may be nothing, less than an ulp, or a little, and a quarter of a turn: so that
 * axes tie, and edges are parallel or nearly so. */
static quat nearly_aligned(random_state *r, quat q)
{
    static const quat QUARTERS[] = {{1, 0, 0, 0}, {0x1.6a09e667f3bcdp-1, 0x1.6a09e667f3bcdp-1, 0, 0},
        {0x1.6a09e667f3bcdp-1, 0, 0, 0x1.6a09e667f3bcdp-1}};
    double angle = random_bits(r) % 4 ? ldexp(random_unit(r), -(int)(random_bits(r) % 60)) : 0;
    vec3 turn = vec_scale(random_direction(r), angle);
    return quat_unit(quat_mul(quat_mul(q, (quat){1, turn.x, turn.y, turn.z}), QUARTERS[random_bits(r) % 3]));
}

static void every_axis_of_boxes_is_within_hi(const placed *a, const placed *b, const narrow_result *r, uint64_t seed)
{
    const real3 axes_a[3] = {a->rx, a->ry, a->rz}, axes_b[3] = {b->rx, b->ry, b->rz};
    for (int i = 0; i < 15; i++) {
        real3 n = i < 3 ? axes_a[i] : i < 6 ? axes_b[i - 3] : real3_cross(axes_a[(i - 6) / 3], axes_b[(i - 6) % 3]);
        if (!(real3_dot(n, n) > 1e-50)) continue;
        for (int k = 0; k < 2; k++, n = real3_scale(n, -1))
            if (oracle_separation(a, b, n) > r->hi) fail_msg("seed %llu: axis %d", (unsigned long long)seed, i);
    }
}

/* Only the axes that doubles cannot rule out are looked at again: the greatest must be among them. */
static void no_axis_of_overlapping_boxes_is_forgotten(void **state)
{
    (void)state;
    unsigned overlapping = 0;
    for (uint64_t seed = 1; seed <= 2000; seed++) {
        random_state random = {seed};
        shape a = random_shape(&random, SHAPE_BOX), b = random_shape(&random, seed % 5 ? SHAPE_BOX : SHAPE_CAPSULE);
        if (seed % 3 == 0) b = a = (shape){.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}}; /* ties */
        pose pa = {random_direction(&random), seed % 2 ? random_rotation(&random) : (quat){1, 0, 0, 0}}, pb = pa;
        pb.q = nearly_aligned(&random, pa.q);
        vec3 along = seed % 2 ? random_direction(&random) : vec(0, 0, 1);
        pb.p = vec_madd(pb.p, random_in(&random, 0, 1) * fmin(shape_reach(&a), shape_reach(&b)), along);
        bool first = narrow_ordered(&a, 0, &b, 1);
        narrow_result r = first ? asked(&a, pa, &b, pb, 0) : asked(&b, pb, &a, pa, 0);
        vec3 origin = first ? pa.p : pb.p;
        placed oa = oracle_place(&a, pa, origin), ob = oracle_place(&b, pb, origin);
        if (r.hi >= 0) continue;
        every_axis_of_boxes_is_within_hi(first ? &oa : &ob, first ? &ob : &oa, &r, seed);
        assert_true(r.refined && r.lo <= r.hi);
        double size = shape_reach(&a) + shape_reach(&b) + vec_norm(vec_sub(pb.p, pa.p));
        if (!(r.hi - r.lo <= 1e-14 * size)) fail_msg("seed %llu: [%.17g, %.17g]", (unsigned long long)seed, r.lo, r.hi);
        overlapping++;
    }
    assert_true(overlapping > 1250);
}

/* A micrometre is not worth double-double; touching, for a verdict, is. */
static void only_what_doubles_cannot_settle_is_refined(void **state)
{
    (void)state;
    static const shape box = {.type = SHAPE_BOX, .half = {.5, .5, .5}};
    const pose o = POSE_IDENTITY, near = {{1.001, 0, 0}, {1, 0, 0, 0}}, touching = {{1, 0, 0}, {1, 0, 0, 0}};
    const narrow_request verdict = {.facts = NARROW_VERDICT, .range = INFINITY};
    narrow_result r = asked(&box, o, &box, near, 1e-6);
    assert_false(r.refined);
    assert_true(asked(&box, o, &box, near, 1e-18).refined);
    narrow_query(&box, &box, &near, &verdict, NULL, case_scratch(), &r);
    assert_false(r.refined);
    narrow_query(&box, &box, &touching, &verdict, NULL, case_scratch(), &r);
    assert_true(r.refined);
    assert_true(r.lo <= 0 && 0 <= r.hi && r.hi - r.lo <= 0x1p-52);
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

/* Points a few least numbers apart: bounds are rounded to whole ones, outwards. */
static void subnormal_bounds_hold(void **state)
{
    (void)state;
    const shape point = {.type = SHAPE_SPHERE}, box = {.type = SHAPE_BOX};
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    for (int x = 1; x < 60; x++) {
        for (int y = 0; y <= x; y++) {
            pose at = {{x * 0x1p-1074, y * 0x1p-1074, 0}, {1, 0, 0, 0}};
            for (int k = 0; k < 2; k++) {
                narrow_result r;
                narrow_query(&point, k ? &box : &point, &at, &request, NULL, case_scratch(), &r);
                double lo = r.lo * 0x1p1000 * 0x1p74, hi = r.hi * 0x1p1000 * 0x1p74;
                assert_true((lo <= 0 || lo * lo <= x * x + y * y) && hi * hi >= x * x + y * y);
            }
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unturned_pairs_are_exact_to_the_last_bits),
        cmocka_unit_test(turned_pairs_are_proved_without_slack),
        cmocka_unit_test(no_axis_of_overlapping_boxes_is_forgotten),
        cmocka_unit_test(only_what_doubles_cannot_settle_is_refined),
        cmocka_unit_test(subnormal_bounds_hold),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
