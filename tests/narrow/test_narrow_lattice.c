/* Pairs as machines are built and things are stacked: parallel edges and faces, common centres and axes, equal sizes,
 * exactly or but for 1e-16 to 1e-3. What is never drawn at random, and what most scenes are made of. Of each: the proof
 * holds (113 bits), polytopes are told their truth, what the pair remembers of another place changes no bit, nor does
 * the order of the two; and few intervals are wider than was asked. */
#include "cases.h"
#include "oracle.h"
#include "polytope_oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { EXACTLY_EVERY = 8 };

typedef struct pair {
    shape a, b;
    pose at_a, at_b;
    double size;
    uint64_t seed;
} pair;

static int pairs_each(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 10000 : getenv("COLLIDED_BRIEF") ? 60 : 600;
}

static bool is_plane(const shape *s)
{
    return s->type == SHAPE_HALFSPACE;
}

static double reach(const shape *s)
{
    return is_plane(s) ? 1 : shape_reach(s);
}

static pair draw(int type_a, int type_b, int i)
{
    pair x = {.seed = ((uint64_t)type_a << 40) + ((uint64_t)type_b << 32) + (uint64_t)i};
    random_state r = {x.seed};
    x.a = lattice_shape(&r, (shape_type)type_a);
    x.b = lattice_shape(&r, (shape_type)type_b);
    lattice_poses(&r, &x.a, &x.b, &x.at_a, &x.at_b);
    x.size = reach(&x.a) + reach(&x.b) + vec_norm(vec_sub(x.at_b.p, x.at_a.p));
    return x;
}

static narrow_result ask(const pair *x, double tolerance)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result r;
    narrow_query_world(&x->a, x->at_a, &x->b, x->at_b, &request, case_scratch(), &r);
    return r;
}

static void fail_pair(const char *why, const pair *x, const narrow_result *r, double by)
{
    fail_msg("%s: %s-%s, seed %llu: [%.17g, %.17g] by %s, off by %g", why, shape_type_name(x->a.type),
        shape_type_name(x->b.type), (unsigned long long)x->seed, r->lo, r->hi, narrow_method_name(r->method), by);
}

static bool is_polytope(const shape *s)
{
    return s->type <= SHAPE_BOX || s->type == SHAPE_HULL;
}

static void check_proof(const pair *x, const narrow_result *r, bool exactly)
{
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    if (!(fabs(vec_norm(r->axis) - 1) <= 1e-14)) fail_pair("the axis is not unit", x, r, vec_norm(r->axis) - 1);
    if (!(r->lo <= r->hi)) fail_pair("lo above hi", x, r, r->lo - r->hi);
    double proved = (double)(oracle_separation(&a, &b, real3_of(r->axis)) - r->lo);
    if (!(proved >= 0)) fail_pair("the axis does not prove lo", x, r, proved);
    if (r->lo < -0.01 * x->size && r->hi > 0) fail_pair("deep, and perhaps apart", x, r, r->hi);
    random_state random = {x->seed};
    for (int i = 0; i < 4 && !is_plane(&x->a) && !is_plane(&x->b); i++) {
        double by = (double)(oracle_separation(&a, &b, real3_of(random_direction(&random))) - r->hi);
        if (by > 0) fail_pair("a direction separates by more than hi", x, r, by);
    }
    if (!exactly || !is_polytope(&x->a) || !is_polytope(&x->b)) return;
    real truth = polytope_signed_distance(&a, &b);
    if (!((real)r->lo <= truth && truth <= (real)r->hi))
        fail_pair("the truth is missed", x, r, (double)(truth - (truth > (real)r->hi ? (real)r->hi : (real)r->lo)));
}

static bool same_bits(const narrow_result *x, const narrow_result *y)
{
    return x->lo == y->lo && x->hi == y->hi && memcmp(&x->axis, &y->axis, sizeof x->axis) == 0 &&
           memcmp(&x->point_a, &y->point_a, sizeof x->point_a) == 0 &&
           memcmp(&x->point_b, &y->point_b, sizeof x->point_b) == 0 && x->status == y->status;
}

/* `before`: of the same two types; its poses are where the pair was looked at last. */
static void check_memory(const pair *x, const pair *before, double tolerance)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    bool straight = narrow_ordered(&x->a, 0, &x->b, 1);
    const shape *a = straight ? &x->a : &x->b, *b = straight ? &x->b : &x->a;
    pose was = pose_relative(straight ? before->at_a : before->at_b, straight ? before->at_b : before->at_a);
    pose is = pose_relative(straight ? x->at_a : x->at_b, straight ? x->at_b : x->at_a);
    narrow_cache cache = {.lower = 0};
    narrow_result cold, again, twice;
    narrow_query(a, b, &was, &request, &cache, case_scratch(), &again);
    narrow_query(a, b, &is, &request, &cache, case_scratch(), &again);
    narrow_query(a, b, &is, &request, &cache, case_scratch(), &twice);
    narrow_query(a, b, &is, &request, NULL, case_scratch(), &cold);
    if (!same_bits(&cold, &again))
        fail_pair("what it remembers of another place changes it", x, &again, again.lo - cold.lo);
    if (!same_bits(&cold, &twice)) fail_pair("what it remembers changes it", x, &twice, twice.lo - cold.lo);
}

static void check_order(const pair *x, const narrow_result *r, double tolerance)
{
    const pair turned = {x->b, x->a, x->at_b, x->at_a, x->size, x->seed};
    narrow_result other = ask(&turned, tolerance);
    if (other.lo != r->lo || other.hi != r->hi) fail_pair("in the other order it differs", x, &other, other.lo - r->lo);
}

static void each_proof_holds(void **state)
{
    (void)state;
    size_t all = 0, wide = 0;
    cases_create();
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++) {
            pair before = draw(ta, tb, 0);
            for (int i = 0; i < pairs_each(); i++) {
                static const double TOLERANCES[] = {1e-6, 0, 1e-9, 1e-12};
                pair x = draw(ta, tb, i);
                double tolerance = TOLERANCES[i % 4] * x.size;
                narrow_result r = ask(&x, tolerance);
                if (isinf(r.lo)) { /* planes that meet: nothing separates them */
                    assert_true(is_plane(&x.a) && is_plane(&x.b) && r.lo < 0);
                    continue;
                }
                check_proof(&x, &r, i % EXACTLY_EVERY < 2);
                check_memory(&x, &before, tolerance);
                check_order(&x, &r, tolerance);
                before = x;
                all++;
                wide += !(r.hi - r.lo <= 1e-6 * x.size);
            }
        }
    cases_destroy();
    print_message("%zu pairs, %zu wider than 1e-6 of their size\n", all, wide);
    assert_true(wide <= all / 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_proof_holds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
