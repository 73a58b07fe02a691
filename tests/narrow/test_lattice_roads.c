/* Pairs on a lattice (cases.h), asked where they stand, for a verdict, or only whether they are apart: what is told
 * holds the truth, as the general answer does; what is remembered of another place changes no bit. */
#include "cases.h"
#include "polytope_oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "findings.h"
#include "primitive_cases.h"
#include "where_they_stand.h"

enum { EXACTLY_EVERY = 8 };

typedef struct lattice_case {
    pair x;
    uint64_t seed;
    double size;
    narrow_result measured; /* in world axes, as narrow as it goes */
} lattice_case;

static bool is_plane(const shape *s)
{
    return s->type == SHAPE_HALFSPACE;
}

static double reach(const shape *s)
{
    return is_plane(s) ? 1 : shape_reach(s);
}

static lattice_case draw(int ta, int tb, int i)
{
    lattice_case c = {.seed = ((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i + (1u << 24)};
    random_state r = {c.seed};
    pair *x = &c.x;
    x->a = lattice_shape(&r, (shape_type)ta);
    x->b = lattice_shape(&r, (shape_type)tb);
    put_in_order(x);
    lattice_poses(&r, &x->a, &x->b, &x->at_a, &x->at_b);
    c.size = reach(&x->a) + reach(&x->b) + vec_norm(vec_sub(x->at_b.p, x->at_a.p));
    return c;
}

static void report(const lattice_case *c, const char *kind, const narrow_result *r, double by)
{
    char text[256];
    snprintf(text, sizeof text, "%s-%s, seed %llu: [%.17g, %.17g] by %s, off by %g; measured [%.17g, %.17g]",
        shape_type_name(c->x.a.type), shape_type_name(c->x.b.type), (unsigned long long)c->seed, r->lo, r->hi,
        narrow_method_name(r->method), by, c->measured.lo, c->measured.hi);
    found(kind, text);
}

static bool is_polytope(const shape *s)
{
    return s->type <= SHAPE_BOX || s->type == SHAPE_HULL;
}

/* Along the axes of either, which such pairs are deepest along, they are no farther apart than hi. */
static void check_directions(const lattice_case *c, const narrow_result *r, double rounded)
{
    const pair *x = &c->x;
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    const real3 axes[6] = {a.rx, a.ry, a.rz, b.rx, b.ry, b.rz};
    for (int k = 0; k < 12; k++) {
        double by = (double)(oracle_separation(&a, &b, real3_scale(axes[k / 2], k % 2 ? -1 : 1)) - r->hi);
        if (by > rounded) report(c, "a direction separates by more than hi", r, by);
    }
}

/* `r` in world axes with its origin at A's. */
static void check_proof(const lattice_case *c, const narrow_result *r, bool exactly)
{
    const pair *x = &c->x;
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    if (!(fabs(vec_norm(r->axis) - 1) <= 1e-14)) report(c, "the axis is not unit", r, vec_norm(r->axis) - 1);
    if (!(r->lo <= r->hi)) report(c, "lo above hi", r, r->lo - r->hi);
    /* refined it may be of the relative pose, as that is rounded */
    double slack = 256 * 0x1p-53 * c->size, rounded = r->refined ? 0x1p-50 * c->size : 0;
    double proved = (double)(oracle_separation(&a, &b, real3_of(r->axis)) - r->lo);
    if (!(proved >= -rounded)) report(c, "the axis does not prove lo", r, proved);
    if (!(r->lo - rounded <= c->measured.hi && c->measured.lo <= r->hi + rounded))
        report(c, "not what is measured", r, 0);
    if (r->refined) slack = 1e-9 * c->size; /* points are those of doubles, drawn together */
    double line = vec_norm(vec_sub(r->point_b, r->point_a));
    double out_a = (double)oracle_outside(&a, r->point_a), out_b = (double)oracle_outside(&b, r->point_b);
    if (!(out_a <= slack)) report(c, "the point of A is outside", r, out_a);
    if (!(out_b <= slack)) report(c, "the point of B is outside", r, out_b);
    if (r->lo > 0 && !(line <= r->hi + rounded)) report(c, "the points do not prove hi", r, line - r->hi);
    if (exactly && !is_plane(&x->a) && !is_plane(&x->b)) check_directions(c, r, rounded);
    if (!exactly || !is_polytope(&x->a) || !is_polytope(&x->b)) return;
    real truth = polytope_signed_distance(&a, &b);
    if (!((real)r->lo - rounded <= truth && truth <= (real)r->hi + rounded))
        report(c, "the truth is missed", r, (double)truth);
}

static narrow_result ask_placed(const pair *x, const narrow_request *request, narrow_cache *cache)
{
    narrow_result r;
    query_where_they_stand(&x->a, x->at_a, &x->b, x->at_b, request, cache, &r);
    return r;
}

static bool same_bits(const narrow_result *x, const narrow_result *y)
{
    return memcmp(&x->lo, &y->lo, offsetof(narrow_result, manifold)) == 0 && x->status == y->status;
}

static void check_placed(const lattice_case *c, const lattice_case *before, int i)
{
    static const double TOLERANCES[] = {1e-6, 0, 1e-9, 1e-12};
    const narrow_request request = {
        .facts = NARROW_DISTANCE, .tolerance = TOLERANCES[i % 4] * c->size, .range = INFINITY};
    pair elsewhere = c->x;
    elsewhere.at_a = before->x.at_a, elsewhere.at_b = before->x.at_b;
    narrow_cache cache = {.lower = 0};
    narrow_result cold = ask_placed(&c->x, &request, NULL), kept;
    check_proof(c, &cold, i % EXACTLY_EVERY == 0);
    (void)ask_placed(&elsewhere, &request, &cache);
    kept = ask_placed(&c->x, &request, &cache);
    if (!same_bits(&cold, &kept)) report(c, "what it remembers of another place changes it", &kept, kept.lo - cold.lo);
    kept = ask_placed(&c->x, &request, &cache);
    if (!same_bits(&cold, &kept)) report(c, "what it remembers changes it", &kept, kept.lo - cold.lo);
    lattice_case in_a = *c;
    put_in_frame_of_a(&in_a.x);
    if (ask_with(&in_a.x, &request, NULL, NULL, &kept)) check_proof(&in_a, &kept, false);
}

static void check_verdict(const lattice_case *c, const narrow_result *r, double threshold)
{
    const narrow_result *m = &c->measured;
    double slack = 1e-13 * c->size; /* what roundings leave open */
    bool undecided = !(r->lo > threshold || r->hi <= threshold);
    if (undecided && (m->lo > threshold + slack || m->hi <= threshold - slack))
        report(c, "undecided, though it is plain", r, threshold);
}

static void check_verdicts(const lattice_case *c, int i)
{
    static const double THRESHOLDS[] = {0, 0.125, -0.125, 0.25, 0.5, -0.25};
    narrow_request request = {.facts = NARROW_VERDICT, .tolerance = INFINITY, .range = INFINITY};
    for (int k = 0; k < 3; k++) {
        request.threshold = k == 2 ? c->measured.lo : THRESHOLDS[(i + k) % 6];
        narrow_result placed = ask_placed(&c->x, &request, NULL), world;
        narrow_query_world(&c->x.a, c->x.at_a, &c->x.b, c->x.at_b, &request, case_scratch(), &world);
        check_proof(c, &placed, false);
        check_proof(c, &world, false);
        check_verdict(c, &placed, request.threshold);
        check_verdict(c, &world, request.threshold);
    }
}

/* Of the relative pose, as it is rounded. */
static void check_apart(const lattice_case *c, const lattice_case *before, int i, size_t *apart, size_t *proven)
{
    static const double LIMITS[] = {0, 0.125, -0.125, 0.25};
    const pair *x = &c->x;
    pose b_in_a = pose_relative(x->at_a, x->at_b), was = pose_relative(before->x.at_a, before->x.at_b);
    double limit = LIMITS[i % 4];
    narrow_cache cache = {.lower = 0};
    narrow_result r = c->measured;
    if (i % 2) (void)narrow_apart(&x->a, &x->b, &was, limit, &cache);
    bool said = narrow_apart(&x->a, &x->b, &b_in_a, limit, &cache);
    *apart += r.lo > limit + 1e-13 * c->size;
    *proven += said;
    if (!said) return;
    if (!(cache.lower > limit && cache.lower <= r.hi + 0x1p-50 * c->size)) report(c, "apart: not so", &r, cache.lower);
    if (is_plane(&x->a) || is_plane(&x->b)) return; /* the axis is the plane's normal */
    placed a = oracle_place(&x->a, POSE_IDENTITY, VEC_ZERO), b = oracle_place(&x->b, b_in_a, VEC_ZERO);
    double proved = (double)(oracle_separation(&a, &b, real3_of(cache.axis)) - cache.lower);
    if (!(fabs(vec_norm(cache.axis) - 1) <= 1e-14)) report(c, "apart: the axis is not unit", &r, 0);
    if (!(proved >= 0)) report(c, "apart: the axis does not prove it", &r, proved);
}

static void each_road_leads_to_the_truth(void **state)
{
    (void)state;
    size_t apart = 0, proven = 0;
    cases_create();
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++) {
            lattice_case before = draw(ta, tb, -1);
            for (int i = 0, n = count_of(300); i < n; i++) {
                lattice_case c = draw(ta, tb, i);
                const narrow_request exactly = measure_exactly();
                narrow_query_world(&c.x.a, c.x.at_a, &c.x.b, c.x.at_b, &exactly, case_scratch(), &c.measured);
                if (isinf(c.measured.lo)) continue; /* planes that meet: nothing separates them */
                check_placed(&c, &before, i);
                check_verdicts(&c, i);
                check_apart(&c, &before, i, &apart, &proven);
                before = c;
            }
        }
    cases_destroy();
    print_message("%zu are apart, of %zu it was proven without a search\n", apart, proven);
    assert_nothing_found();
    assert_true(10 * proven > 7 * apart);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_road_leads_to_the_truth)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
