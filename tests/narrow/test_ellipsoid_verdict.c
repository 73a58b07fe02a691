/* Verdicts of two ellipsoids (narrow/primitives/primitives.c): what is told holds by 113-bit support
 * functions, down to gaps and overlaps of a few roundings, at every size the same; most pairs are answered
 * without being measured. */
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "primitive_cases.h"

static pair random_pair(random_state *r, enum regime regime)
{
    pair x = {.a = random_shape(r, SHAPE_ELLIPSOID), .b = random_shape(r, SHAPE_ELLIPSOID)};
    if (random_bits(r) % 2) x.a.radius = x.b.radius = 0;
    put_in_order(&x);
    random_poses(r, &x.a, &x.b, regime, &x.at_a, &x.at_b);
    put_in_frame_of_a(&x);
    return x;
}

static narrow_request verdict_at(double threshold)
{
    return (narrow_request){.facts = NARROW_VERDICT, .tolerance = INFINITY, .range = INFINITY, .threshold = threshold};
}

/* By the formula alone: false where it leaves the pair to others. */
static bool ask(const pair *x, const narrow_request *request, narrow_result *r)
{
    return ask_with(x, request, NULL, NULL, r);
}

static narrow_result measure(const pair *x)
{
    const narrow_request request = measure_exactly();
    narrow_result r;
    narrow_query_world(&x->a, x->at_a, &x->b, x->at_b, &request, case_scratch(), &r);
    return r;
}

/* `other`: an axis that separates most, or nearly, so that hi cannot be below it. */
static void check(const pair *x, const narrow_request *request, const narrow_result *r, vec3 other, uint64_t seed)
{
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    double size = size_of(x);
    if (!(oracle_separation(&a, &b, real3_of(r->axis)) >= r->lo))
        fail_msg("seed %llu: the axis does not prove %.17g", (unsigned long long)seed, r->lo);
    if (!(oracle_separation(&a, &b, real3_of(other)) <= r->hi))
        fail_msg("seed %llu: an axis separates by more than %.17g", (unsigned long long)seed, r->hi);
    assert_true(r->lo > request->threshold || r->hi <= request->threshold);
    assert_true(r->status == NARROW_CERTAIN && r->method == NARROW_BY_CLOSED_FORM && !r->refined);
    assert_true(fabs(vec_norm(r->axis) - 1) <= 1e-15);
    assert_true(oracle_outside(&a, r->point_a) <= 1e-14 * size && oracle_outside(&b, r->point_b) <= 1e-14 * size);
    if (r->lo > 0) assert_true(vec_norm(vec_sub(r->point_b, r->point_a)) <= r->hi);
}

static void what_is_told_holds(void **state)
{
    (void)state;
    unsigned asked = 0, answered = 0, overlapping = 0;
    for (int i = 1, n = count_of(6000); i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, (enum regime)(i % REGIME_COUNT));
        narrow_request request = verdict_at(i % 3 ? 0 : random_in(&r, -0.2, 0.3));
        narrow_result told, measured = measure(&x);
        asked += request.threshold == 0;
        if (!ask(&x, &request, &told)) continue;
        answered += request.threshold == 0;
        overlapping += told.hi <= 0;
        check(&x, &request, &told, measured.axis, (uint64_t)i);
        assert_true(told.lo <= measured.hi && measured.lo <= told.hi);
        placed a = oracle_place(&x.a, x.at_a, x.at_a.p), b = oracle_place(&x.b, x.at_b, x.at_a.p);
        if (i % 40 == 0) assert_true(oracle_search(&a, &b) <= told.hi);
    }
    if (answered < asked * 0.75 || overlapping < asked / 5)
        fail_msg("%u of %u are answered, of which %u overlap", answered, asked, overlapping);
}

/* Tip to tip, but for `gap`: along the x axes of both, in which B is turned by any angle. */
static pair tip_to_tip(random_state *r, double gap)
{
    pair x = random_pair(r, REGIME_NEAR);
    double angle = random_in(r, 0, 3), reach = x.a.half.x + x.a.radius + x.b.half.x + x.b.radius;
    x.at_b.q = quat_unit((quat){cos(angle), sin(angle), 0, 0});
    x.at_b.p = vec(reach + gap, 0, 0);
    return x;
}

static void it_holds_to_the_last_roundings(void **state)
{
    (void)state;
    static const double GAPS[] = {1e-16, 1e-15, 3e-15, 1e-14, 1e-13, 1e-11, 1e-9};
    int apart = 0, overlap = 0;
    for (int i = 1, n = count_of(7000); i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = tip_to_tip(&r, GAPS[i % 7] * (i / 7 % 2 ? 1 : -1));
        narrow_request request = verdict_at(0);
        narrow_result told;
        if (!ask(&x, &request, &told)) continue;
        check(&x, &request, &told, quat_rotate(x.at_a.q, vec(1, 0, 0)), (uint64_t)i);
        apart += told.lo > 0;
        overlap += told.hi <= 0;
    }
    int least = count_of(500);
    if (apart < least || overlap < least) fail_msg("%d are apart, %d overlap", apart, overlap);
}

static void at_every_size_it_is_the_same(void **state)
{
    (void)state;
    for (int i = 1, n = count_of(2000); i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, (enum regime)(i % REGIME_COUNT));
        if (i % 50 == 0) x.at_b.p = x.at_a.p; /* no line of the centres */
        narrow_request request = verdict_at(i % 3 ? 0 : random_in(&r, -0.2, 0.3));
        assert_same_at_every_size(&x, &request, NULL);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_told_holds),
        cmocka_unit_test(it_holds_to_the_last_roundings),
        cmocka_unit_test(at_every_size_it_is_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
