/* Random pairs of every two types, apart, near, shallow and deep: each interval is checked as a client would check it,
 * with 113-bit support functions (oracle.c): the axis proves lo, no direction contradicts hi, witnesses are in the
 * shapes. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <stdio.h>

enum { PAIRS_EACH = 240, SEARCH_EVERY = 15 }; /* NARROW_PAIRS in the environment: more, for the nightly size */

static double sizes(const shape *a, const shape *b, pose pa, pose pb)
{
    double ra = shape_reach(a), rb = shape_reach(b);
    return (isfinite(ra) ? ra : 0) + (isfinite(rb) ? rb : 0) + vec_norm(vec_sub(pb.p, pa.p));
}

static bool polytope(const shape *s)
{
    return s->type <= SHAPE_BOX || s->type == SHAPE_HULL;
}

typedef struct tally {
    double width, outside;
    uint32_t wide, iterations, count;
} tally;

static void fail_pair(const char *why, const shape *a, const shape *b, uint64_t seed, const narrow_result *r, double by)
{
    fail_msg("%s: %s-%s, seed %llu: [%.17g, %.17g] by %s, off by %g", why, shape_type_name(a->type),
        shape_type_name(b->type), (unsigned long long)seed, r->lo, r->hi, narrow_method_name(r->method), by);
}

static void check(const shape *a, pose pa, const shape *b, pose pb, uint64_t seed, bool search, tally *t)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &r);
    double size = sizes(a, b, pa, pb);
    placed oa = oracle_place(a, pa, pa.p), ob = oracle_place(b, pb, pa.p);
    if (isinf(r.lo)) { /* planes that meet: nothing separates them */
        assert_true(a->type == SHAPE_HALFSPACE && b->type == SHAPE_HALFSPACE);
        return;
    }
    if (fabs(vec_norm(r.axis) - 1) > 1e-14) fail_pair("axis is not unit", a, b, seed, &r, vec_norm(r.axis) - 1);
    if (!(r.lo <= r.hi)) fail_pair("lo above hi", a, b, seed, &r, r.lo - r.hi);
    double proved = (double)(oracle_separation(&oa, &ob, real3_of(r.axis)) - r.lo);
    bool plane = a->type == SHAPE_HALFSPACE || b->type == SHAPE_HALFSPACE;
    if (!plane && proved < 0) fail_pair("the axis does not prove lo", a, b, seed, &r, proved);
    if (search && !plane) {
        double over = (double)(oracle_search(&oa, &ob) - r.hi);
        if (over > 0) fail_pair("a direction separates by more than hi", a, b, seed, &r, over);
    }
    double outside = (double)oracle_outside(&oa, r.point_a) + (double)oracle_outside(&ob, r.point_b);
    if (outside > 1e-13 * size) fail_pair("a witness is outside its shape", a, b, seed, &r, outside);
    double gap = vec_norm(vec_sub(r.point_b, r.point_a));
    if (r.lo > 0 && gap > r.hi * (1 + 1e-15)) fail_pair("the witnesses do not prove hi", a, b, seed, &r, gap - r.hi);
    t->width = fmax(t->width, (r.hi - r.lo) / size);
    t->outside = fmax(t->outside, outside / size);
    t->wide += r.status == NARROW_WIDE;
    t->iterations += r.iterations;
    t->count++;
    if (polytope(a) && polytope(b) && r.hi - r.lo > 1e-14 * size) fail_pair("wide", a, b, seed, &r, r.hi - r.lo);
    if (r.hi - r.lo > 1e-5 * size) fail_pair("wide", a, b, seed, &r, r.hi - r.lo);
}

static void random_pairs_are_certified(void **state)
{
    (void)state;
    const char *more = getenv("NARROW_PAIRS");
    int pairs = more ? atoi(more) : PAIRS_EACH;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++) {
            tally t[REGIME_COUNT] = {{0}};
            for (int i = 0; i < pairs; i++) {
                uint64_t seed = ((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i;
                random_state r = {seed};
                shape a = random_shape(&r, (shape_type)ta), b = random_shape(&r, (shape_type)tb);
                enum regime where = (enum regime)(i % REGIME_COUNT);
                pose pa, pb;
                random_poses(&r, &a, &b, where, &pa, &pb);
                check(&a, pa, &b, pb, seed, i / REGIME_COUNT % SEARCH_EVERY == 0, &t[where]);
            }
            if (getenv("NARROW_TALLY"))
                for (int k = 0; k < REGIME_COUNT; k++)
                    printf("%-10s %-10s regime %d: width %.1e wide %u of %u, iterations %.1f\n",
                        shape_type_name((shape_type)ta), shape_type_name((shape_type)tb), k, t[k].width, t[k].wide,
                        t[k].count, t[k].count ? (double)t[k].iterations / t[k].count : 0);
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
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_pairs_are_certified)};
    return cmocka_run_group_tests(tests, create, destroy);
}
