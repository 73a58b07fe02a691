/* Two ellipsoids, or a ball and one: what one proof says of all directions at once (narrow/closed/closed.h) holds, by
 * 113-bit support functions, along every direction tried; it answers nearly all pairs, and those of one centre; the
 * general method gives an interval that meets its own. */
#include "cases.h"
#include "oracle.h"

#include "narrow/closed/closed.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { PAIRS = 2000, DIRECTIONS = 30, SEARCH_EVERY = 100 };

static const narrow_goal GOAL = {1e-6, 1e-15, INFINITY, -INFINITY, INFINITY, INFINITY, false};

typedef struct pair {
    shape a, b;
    pose b_in_a;
    unit_pair p;
    placed oa, ob;
} pair;

static void prepare(pair *x, const shape *a, const shape *b, pose b_in_a)
{
    x->a = *a;
    x->b = *b;
    x->b_in_a = b_in_a;
    unit_pair_init(&x->p, &x->a, &x->b, &x->b_in_a);
    x->oa = oracle_place(&x->a, POSE_IDENTITY, VEC_ZERO);
    x->ob = oracle_place(&x->b, b_in_a, VEC_ZERO);
}

/* Of the shapes, in units of the pair. */
static double separation(const pair *x, vec3 n)
{
    return (double)oracle_separation(&x->oa, &x->ob, real3_of(n)) * x->p.scale;
}

/* Half of the directions are near the axis, where a bound that is wrong is wrong first. */
static void check(const pair *x, const span *s, random_state *r, bool search, uint64_t seed)
{
    double hi = s->hi - x->p.radius + x->p.error;
    assert_true(s->hi - s->lo <= GOAL.tolerance && separation(x, s->axis) >= s->lo - x->p.radius - x->p.error);
    for (int i = 0; i < DIRECTIONS; i++) {
        vec3 n = i % 2 ? random_direction(r) : vec_unit(vec_madd(s->axis, random_unit(r), random_direction(r)));
        if (separation(x, n) > hi) fail_msg("seed %llu: a direction is beyond hi", (unsigned long long)seed);
    }
    if (search) assert_true((double)oracle_search(&x->oa, &x->ob) * x->p.scale <= hi);
}

static bool measure(const pair *x, span *s)
{
    return ellipsoid_pair_measure(&x->p, &GOAL, s);
}

static void what_is_proved_holds_along_every_direction(void **state)
{
    (void)state;
    unsigned proved = 0;
    for (uint64_t seed = 1; seed <= PAIRS; seed++) {
        random_state r = {seed};
        shape a = random_shape(&r, seed % 4 ? SHAPE_ELLIPSOID : SHAPE_SPHERE), b = random_shape(&r, SHAPE_ELLIPSOID);
        pose pa, pb;
        random_poses(&r, &a, &b, (enum regime)(seed / 4 % REGIME_COUNT), &pa, &pb);
        pair x;
        span s;
        prepare(&x, &a, &b, pose_relative(pa, pb));
        if (!measure(&x, &s)) continue;
        proved++;
        check(&x, &s, &r, seed % SEARCH_EVERY == 0, seed);
    }
    if (proved < PAIRS * 9 / 10) fail_msg("only %u of %d are proved", proved, PAIRS);
}

/* The depth is the sum of the two least half axes when those are along one line, and never less. */
static void one_centre_is_no_obstacle(void **state)
{
    (void)state;
    unsigned proved = 0;
    for (uint64_t seed = 1; seed <= 200; seed++) {
        random_state r = {seed};
        shape a = {.type = SHAPE_ELLIPSOID, .half = {0.5, 0.75, 1.25}}, b = {.type = SHAPE_ELLIPSOID};
        b.half = vec(random_in(&r, 0.3, 1), random_in(&r, 0.3, 1), random_in(&r, 0.3, 1));
        bool aligned = seed % 2;
        pair x;
        span s;
        prepare(&x, &a, &b, (pose){VEC_ZERO, aligned ? (quat){1, 0, 0, 0} : random_rotation(&r)});
        if (!measure(&x, &s)) continue;
        proved++;
        check(&x, &s, &r, false, seed);
        if (!aligned) continue;
        double least = fmin(0.5 + b.half.x, fmin(0.75 + b.half.y, 1.25 + b.half.z)) * x.p.scale;
        assert_true(fabs(s.lo - x.p.radius + least) <= 1e-6 && s.hi - x.p.radius + x.p.error >= -least);
    }
    if (proved < 150) fail_msg("only %u are proved", proved);
}

static void the_general_method_agrees(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 400; seed++) {
        random_state r = {seed};
        shape a = random_shape(&r, SHAPE_ELLIPSOID), b = random_shape(&r, SHAPE_ELLIPSOID);
        pose pa, pb;
        random_poses(&r, &a, &b, (enum regime)(seed % REGIME_COUNT), &pa, &pb);
        narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY};
        narrow_result x, y;
        narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &x);
        request.engine = NARROW_ENGINE_GJK;
        narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &y);
        assert_true(x.lo <= y.hi && y.lo <= x.hi);
        assert_true(x.hi - x.lo <= 1e-6 && y.hi - y.lo <= 1e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_proved_holds_along_every_direction),
        cmocka_unit_test(one_centre_is_no_obstacle),
        cmocka_unit_test(the_general_method_agrees),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
