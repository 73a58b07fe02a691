/* Random pairs of every two types, apart, near, shallow and deep, 10^5 of them, and 10^6 with COLLIDED_NIGHTLY=1: each
 * interval is checked as a client would check it, with 113-bit support functions (oracle.c): the axis proves lo, no
 * direction contradicts hi, witnesses are in the shapes; what the general search says of the pair agrees; and B moved
 * along the axis by a little more than the depth is apart, by a little less it is not. Half of the pairs are brought to
 * where they touch, but for 1e-15 to 1e-8 of their size, and looked at there, too. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <stdio.h>

enum { PAIRS_EACH = 1080, SEARCH_EVERY = 96, DIRECTIONS = 6, ITERATIONS_MAX = 4000 };

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
    uint32_t wide, iterations, count, held, moved; /* held: deep enough; moved: out of it, and that could be told */
} tally;

static void fail_pair(const char *why, const shape *a, const shape *b, uint64_t seed, const narrow_result *r, double by)
{
    fail_msg("%s: %s-%s, seed %llu: [%.17g, %.17g] by %s, off by %g", why, shape_type_name(a->type),
        shape_type_name(b->type), (unsigned long long)seed, r->lo, r->hi, narrow_method_name(r->method), by);
}

static bool is_plane(const shape *s)
{
    return s->type == SHAPE_HALFSPACE;
}

/* Of a half-space and another shape: the height of the other above the plane. */
static real above_plane(const placed *a, const placed *b)
{
    return oracle_separation(a, b, is_plane(a->s) ? a->rz : real3_scale(b->rz, -1));
}

/* The greatest separation along the axis, near it, and anywhere: what hi must not be below. */
static real separated_by(const placed *a, const placed *b, vec3 axis, random_state *random)
{
    real best = oracle_separation(a, b, real3_of(axis));
    for (int i = 0; i < DIRECTIONS; i++) {
        static const double AWAY[] = {1e-4, 1e-2, 1e9};
        real s = oracle_separation(a, b, real3_of(vec_madd(axis, AWAY[i % 3], random_direction(random))));
        best = s > best ? s : best;
    }
    return best;
}

static narrow_result ask(const shape *a, pose pa, const shape *b, pose pb, narrow_engine engine)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    request.engine = engine;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &r);
    return r;
}

/* By 1.001 of the depth: apart. By 0.999: not. Where the interval is too wide to say so, it must not say otherwise. */
static void move_out(const shape *a, pose pa, const shape *b, pose pb, uint64_t seed, const narrow_result *r, tally *t)
{
    pose more = {vec_madd(pb.p, 1.001 * -r->lo, r->axis), pb.q}, less = {vec_madd(pb.p, 0.999 * -r->hi, r->axis), pb.q};
    narrow_result apart = ask(a, pa, b, more, NARROW_ENGINE_AUTO), held = ask(a, pa, b, less, NARROW_ENGINE_AUTO);
    double margin = 1e-3 * -r->hi, wide = apart.hi - apart.lo;
    if (!(apart.hi > 0) || (wide < margin && !(apart.lo > 0)))
        fail_pair("moved by 1.001 of the depth, it is not apart", a, b, seed, &apart, r->lo);
    if (!(held.lo < 0) || (held.hi - held.lo < margin && !(held.hi < 0)))
        fail_pair("moved by 0.999 of the depth, it is apart", a, b, seed, &held, r->hi);
    t->moved += wide < margin;
}

static void check_truth(const placed *a, const placed *b, uint64_t seed, bool search, const narrow_result *r)
{
    random_state random = {seed};
    if (is_plane(a->s) || is_plane(b->s)) {
        real truth = above_plane(a, b);
        if (!((real)r->lo <= truth && truth <= (real)r->hi))
            fail_pair("the height above the plane is missed", a->s, b->s, seed, r,
                (double)(truth - (truth > (real)r->hi ? (real)r->hi : (real)r->lo)));
        return;
    }
    double proved = (double)(oracle_separation(a, b, real3_of(r->axis)) - r->lo);
    if (!(proved >= 0)) fail_pair("the axis does not prove lo", a->s, b->s, seed, r, proved);
    double over = (double)((search ? oracle_search(a, b) : separated_by(a, b, r->axis, &random)) - r->hi);
    if (!(over <= 0)) fail_pair("a direction separates by more than hi", a->s, b->s, seed, r, over);
}

/* The general search knows nothing of closed forms: both intervals hold the same truth. */
static void check_general(const shape *a, pose pa, const shape *b, pose pb, uint64_t seed, const narrow_result *r)
{
    narrow_result general = ask(a, pa, b, pb, NARROW_ENGINE_GJK);
    if (!(general.lo <= r->hi && r->lo <= general.hi))
        fail_pair("the general search disagrees", a, b, seed, r, general.lo - r->lo);
    if (!(general.lo <= general.hi)) fail_pair("of the general search, lo above hi", a, b, seed, &general, 0);
}

static void check(const shape *a, pose pa, const shape *b, pose pb, uint64_t seed, bool search, tally *t)
{
    narrow_result r = ask(a, pa, b, pb, NARROW_ENGINE_AUTO);
    double size = sizes(a, b, pa, pb);
    placed oa = oracle_place(a, pa, pa.p), ob = oracle_place(b, pb, pa.p);
    if (isinf(r.lo)) { /* planes that meet: nothing separates them */
        assert_true(is_plane(a) && is_plane(b) && r.lo < 0);
        return;
    }
    if (!(fabs(vec_norm(r.axis) - 1) <= 1e-14)) fail_pair("axis is not unit", a, b, seed, &r, vec_norm(r.axis) - 1);
    if (!(r.lo <= r.hi)) fail_pair("lo above hi", a, b, seed, &r, r.lo - r.hi);
    if (r.iterations > ITERATIONS_MAX) fail_pair("it hardly ends", a, b, seed, &r, r.iterations);
    check_truth(&oa, &ob, seed, search, &r);
    double outside = (double)oracle_outside(&oa, r.point_a) + (double)oracle_outside(&ob, r.point_b);
    if (!(outside <= 1e-13 * size)) fail_pair("a witness is outside its shape", a, b, seed, &r, outside);
    double gap = vec_norm(vec_sub(r.point_b, r.point_a));
    if (r.lo > 0 && !(gap <= r.hi * (1 + 1e-15)))
        fail_pair("the witnesses do not prove hi", a, b, seed, &r, gap - r.hi);
    if (polytope(a) && polytope(b) && r.hi - r.lo > 1e-14 * size) fail_pair("wide", a, b, seed, &r, r.hi - r.lo);
    if (!(r.hi - r.lo <= 1e-5 * size)) fail_pair("wide", a, b, seed, &r, r.hi - r.lo);
    if (!is_plane(a) && !is_plane(b)) check_general(a, pa, b, pb, seed, &r);
    bool deep = r.hi < -1e-9 * size; /* deep enough for a thousandth of it to be a step for the coordinates */
    if (deep) move_out(a, pa, b, pb, seed, &r, t);
    t->width = fmax(t->width, (r.hi - r.lo) / size);
    t->outside = fmax(t->outside, outside / size);
    t->wide += r.status == NARROW_WIDE;
    t->iterations += r.iterations;
    t->count++;
    t->held += deep;
}

/* B where it just touches, or nearly: there the origin is on the surface of B - A, and rounding on both sides of it. */
static pose touching(const shape *a, pose pa, const shape *b, pose pb, int i)
{
    static const double OFF[] = {0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-8};
    narrow_result r = ask(a, pa, b, pb, NARROW_ENGINE_AUTO);
    double off = OFF[i % 8] * sizes(a, b, pa, pb) * (i & 8 ? -1 : 1);
    return isinf(r.lo) ? pb : (pose){vec_madd(pb.p, off - r.lo, r.axis), pb.q};
}

static void random_pairs_are_certified(void **state)
{
    (void)state;
    int pairs = getenv("COLLIDED_NIGHTLY") ? 10 * PAIRS_EACH : PAIRS_EACH;
    uint64_t checked = 0, held = 0, moved = 0;
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
                if (i % 2 == 0) check(&a, pa, &b, touching(&a, pa, &b, pb, i / 2), seed, false, &t[where]);
            }
            for (int k = 0; k < REGIME_COUNT; k++) {
                checked += t[k].count;
                held += t[k].held;
                moved += t[k].moved;
                if (getenv("NARROW_TALLY"))
                    printf("%-10s %-10s regime %d: width %.1e wide %u of %u, iterations %.1f\n",
                        shape_type_name((shape_type)ta), shape_type_name((shape_type)tb), k, t[k].width, t[k].wide,
                        t[k].count, t[k].count ? (double)t[k].iterations / t[k].count : 0);
            }
        }
    print_message("%llu pairs, %llu overlap, %llu of them surely moved out of it\n", (unsigned long long)checked,
        (unsigned long long)held, (unsigned long long)moved);
    assert_true(checked >= 100000 && held > checked / 4 && moved > held - held / 50);
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
