/* Hulls of many nearly coplanar points, of which qhull leaves out some that are outside of what it keeps: the bounds
 * hold for all the points that were given, by an oracle in 113 bits that knows nothing else. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { POINTS_MAX = 200, STEPS_MAX = 200, KINDS = 5 };

typedef struct given {
    int count;
    vec3 at[POINTS_MAX];
    hull *hull;
} given;

static const real DOUBT = 1e-28Q; /* of the oracle, at offsets of 1,000 */

typedef struct interval {
    real lo, hi;
} interval;

static int rounds(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 4000 : getenv("COLLIDED_BRIEF") ? 24 : 120;
}

static vec3 surface_point(random_state *r, int kind)
{
    double a = random_in(r, 0, 1), b = random_in(r, 0, 1);
    switch (kind % KINDS) {
    case 0: /* a grid over a plate */
        return vec((double)(random_bits(r) % 9) / 8, (double)(random_bits(r) % 9) / 8, random_bits(r) % 2 ? 0.25 : 0);
    case 1: { /* a box, all over */
        double s = (double)(random_bits(r) % 2);
        uint64_t k = random_bits(r) % 3;
        return k == 0 ? vec(s, a, b) : k == 1 ? vec(a, s, b) : vec(a, b, s);
    }
    case 2: { /* a prism of twelve sides, in levels */
        double angle = (double)(random_bits(r) % 12) * 0x1.0c152382d7366p-1;
        return vec(cos(angle) / 2, sin(angle) / 2, (double)(random_bits(r) % 7) / 6);
    }
    case 3: /* lines along the edges of a wedge */
        return random_bits(r) % 3 ? vec(a, random_bits(r) % 2 ? 0 : 0.125, 0) : vec(a, 0.0625, 0.5);
    default: /* an octahedron: faces of three sides, planes of three coordinates */
        if (a + b > 1) a = 1 - a, b = 1 - b;
        return vec(
            random_bits(r) % 2 ? a : -a, random_bits(r) % 2 ? b : -b, random_bits(r) % 2 ? 1 - a - b : -(1 - a - b));
    }
}

/* Noise of a few roundoffs, now and then of up to 1e-9, on what a turn and an offset of up to 1,000 have rounded. */
static void make(random_state *r, int kind, given *out)
{
    quat q = random_bits(r) % 4 ? random_rotation(r) : (quat){1, 0, 0, 0};
    pose at = {vec_scale(random_direction(r), random_bits(r) % 3 ? 0 : random_in(r, 0, 1000)), q};
    double noise = random_bits(r) % 4 ? 0x1p-52 * (double)(random_bits(r) % 4) : pow(10, -random_in(r, 9, 15));
    out->count = 40 + (int)(random_bits(r) % (POINTS_MAX - 40));
    for (int i = 0; i < out->count; i++)
        out->at[i] = vec_madd(pose_point(at, surface_point(r, kind)), noise * random_in(r, 0, 1), random_direction(r));
    assert_int_equal(hull_build(&out->at[0].x, (size_t)out->count, 0, &out->hull), HULL_OK);
}

/* The shares of the corners in the point nearest to the origin of the plane, line or point through them. */
static bool shares_of(const real3 *v, int count, real *share)
{
    real m[5][6] = {{0}};
    int n = count + 1;
    for (int i = 0; i < count; i++) {
        for (int j = 0; j < count; j++) m[i][j] = real3_dot(v[i], v[j]);
        m[i][count] = m[count][i] = 1;
    }
    m[count][n] = 1;
    for (int c = 0; c < n; c++) {
        int pivot = c;
        for (int i = c; i < n; i++)
            if (m[i][c] * m[i][c] > m[pivot][c] * m[pivot][c]) pivot = i;
        if (m[pivot][c] == 0) return false;
        for (int j = 0; j <= n; j++) {
            real swap = m[c][j];
            m[c][j] = m[pivot][j];
            m[pivot][j] = swap;
        }
        for (int i = 0; i < n; i++) {
            real factor = m[i][c] / m[c][c];
            for (int j = c; i != c && j <= n; j++) m[i][j] -= factor * m[c][j];
        }
    }
    bool inside = true;
    real whole = 0;
    for (int i = 0; i < count; i++) {
        share[i] = m[i][n] / m[i][i];
        whole += share[i];
        inside = inside && share[i] >= 0;
    }
    for (int i = 0; i < count; i++) share[i] /= whole; /* so that, however they were rounded, it is a point inside */
    return inside && whole > 0;
}

typedef struct simplex {
    int count;
    real3 at[5], nearest;
} simplex;

/* Of all sub-simplices the nearest point; false if none is nearer than it was. */
static bool reduce(simplex *s)
{
    simplex best = {.nearest = s->nearest};
    for (int mask = 1; mask < 1 << s->count; mask++) {
        simplex part = {.count = 0};
        real share[5];
        for (int i = 0; i < s->count; i++)
            if (mask >> i & 1) part.at[part.count++] = s->at[i];
        if (part.count > 4 || !shares_of(part.at, part.count, share)) continue;
        for (int i = 0; i < part.count; i++) part.nearest = real3_sub(part.nearest, real3_scale(part.at[i], -share[i]));
        if (real3_dot(part.nearest, part.nearest) < real3_dot(best.nearest, best.nearest)) best = part;
    }
    bool nearer = best.count > 0;
    if (nearer) *s = best;
    return nearer;
}

static real3 extreme(const real3 *points, int count, real3 n)
{
    int best = 0;
    for (int i = 1; i < count; i++)
        if (real3_dot(n, points[i]) > real3_dot(n, points[best])) best = i;
    return points[best];
}

/* The least of dot(n, b - a), over |n|. */
static real separation(const real3 *a, int count_a, const real3 *b, int count_b, real3 n)
{
    real3 low = extreme(b, count_b, real3_scale(n, -1)), high = extreme(a, count_a, n);
    return real3_dot(n, real3_sub(low, high)) / real_sqrt(real3_dot(n, n));
}

/* Wolfe's nearest point of B - A: its length is not below the distance, its direction proves another not above it. */
static interval distance_of(const real3 *a, int count_a, const real3 *b, int count_b)
{
    simplex s = {1, {real3_sub(b[0], a[0])}, real3_sub(b[0], a[0])};
    interval d = {0, 0};
    for (int i = 0; i < STEPS_MAX; i++) {
        real far2 = real3_dot(s.nearest, s.nearest);
        d.hi = real_sqrt(far2);
        if (d.hi < 1e-30Q) break;
        real3 towards = s.nearest, back = real3_scale(towards, -1);
        real3 next = real3_sub(extreme(b, count_b, back), extreme(a, count_a, towards));
        real lo = real3_dot(next, towards) / d.hi;
        if (lo > d.lo) d.lo = lo;
        if (d.hi - d.lo < 1e-30Q * d.hi) break;
        s.at[s.count++] = next;
        if (!reduce(&s)) break;
    }
    return d;
}

static void kept_points(const hull *h, real3 *out)
{
    for (uint32_t i = 0; i < h->vertex_count; i++) out[i] = real3_of(hull_vertex(h, i));
}

static real length_of_points(const given *g)
{
    real most = 0;
    for (int i = 1; i < g->count; i++) {
        real3 d = real3_sub(real3_of(g->at[i]), real3_of(g->at[0]));
        most = real3_dot(d, d) > most ? real3_dot(d, d) : most;
    }
    return real_sqrt(most);
}

/* The excess is not below what the farthest point is out by, nor more than twice that and a few roundoffs. */
static void the_excess_is_what_is_left_out(void **state)
{
    (void)state;
    int some = 0, none = 0;
    for (int i = 0; i < rounds(); i++) {
        random_state random = {(uint64_t)i};
        given g;
        real3 kept[POINTS_MAX];
        make(&random, i, &g);
        kept_points(g.hull, kept);
        interval most = {0, 0};
        for (int k = 0; k < g.count; k++) {
            real3 p = real3_of(g.at[k]);
            interval out = distance_of(kept, (int)g.hull->vertex_count, &p, 1);
            most.lo = out.lo > most.lo ? out.lo : most.lo;
            most.hi = out.hi > most.hi ? out.hi : most.hi;
        }
        real excess = g.hull->excess, rounding = 0x1p-51 * length_of_points(&g);
        if (excess < most.lo - DOUBT || excess > 2 * most.hi + rounding)
            fail_msg("%d: excess %g, truth %g to %g", i, (double)excess, (double)most.lo, (double)most.hi);
        some += most.lo > 0;
        none += excess == 0;
        hull_destroy(g.hull);
    }
    assert_true(some > rounds() / 4 && none > 0);
}

/* Points that are on the faces exactly, and points within, are not outside. */
static void what_is_in_the_hull_adds_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < rounds(); i++) {
        random_state random = {(uint64_t)i};
        vec3 at[POINTS_MAX], from = vec_scale(random_direction(&random), i % 3 ? 0 : 1000);
        int axis = i % 3;
        for (int k = 0; k < POINTS_MAX; k++) {
            vec3 p = {(double)(k % 6) / 8 + (double)(k / 6 % 6) / 16, (double)(k / 6 % 6) / 8, (double)(k / 36) / 4};
            at[k] = axis == 0 ? p : axis == 1 ? vec(p.y, p.z, p.x) : vec(p.z, p.x, p.y);
            vec3 whole = {rint(from.x), rint(from.y), rint(from.z)};
            at[k] = vec_add(at[k], whole);
        }
        hull *h;
        assert_int_equal(hull_build(&at[0].x, 180, 0, &h), HULL_OK);
        assert_true(h->excess == 0);
        assert_int_equal(h->vertex_count, 8);
        hull_destroy(h);
    }
}

static void scaling_scales_the_excess(void **state)
{
    (void)state;
    for (int i = 0; i < rounds(); i++) {
        random_state random = {(uint64_t)i};
        given g;
        make(&random, i, &g);
        double scale = ldexp(1, (int)(random_bits(&random) % 801) - 400);
        for (int k = 0; k < g.count; k++) g.at[k] = vec_scale(g.at[k], scale);
        hull *h;
        assert_int_equal(hull_build(&g.at[0].x, (size_t)g.count, 0, &h), HULL_OK);
        assert_true(h->excess == g.hull->excess * scale);
        assert_true(h->reach == g.hull->reach * scale);
        hull_destroy(h);
        hull_destroy(g.hull);
    }
}

static void place_points(const given *g, const placed *at, real3 *out)
{
    for (int i = 0; i < g->count; i++) out[i] = oracle_point(at, real3_of(g->at[i]));
}

/* B with one of its corners above, on or in A, there where a point of A is that was left out, or anywhere. */
static pose put_near(random_state *r, const given *a, const pose *pose_a, const given *b)
{
    static const double gaps[] = {1e-2, 1e-6, 1e-12, 0x1p-52, 0, -1e-12, -1e-3};
    const hull *h = a->hull;
    uint32_t face = (uint32_t)(random_bits(r) % h->face_count);
    vec3 n = h->faces[face].normal, target = a->at[random_bits(r) % (uint64_t)a->count];
    double most = -INFINITY;
    for (int i = 0; i < a->count; i++) { /* of those that are left out over this face, mostly the farthest out */
        double height = vec_dot(n, a->at[i]) - h->faces[face].offset;
        if (height > most && random_bits(r) % 8) most = height, target = a->at[i];
    }
    quat q = random_rotation(r);
    vec3 outward = quat_rotate(pose_a->q, n), low = VEC_ZERO;
    double least = INFINITY;
    for (uint32_t i = 0; i < b->hull->vertex_count; i++) {
        vec3 v = quat_rotate(q, hull_vertex(b->hull, i));
        if (vec_dot(v, outward) < least) least = vec_dot(v, outward), low = v;
    }
    vec3 corner = vec_madd(pose_point(*pose_a, target), gaps[random_bits(r) % 7], outward);
    return (pose){vec_sub(corner, low), q};
}

static void make_corner(random_state *r, given *out)
{
    out->count = 4;
    for (int i = 0; i < 4; i++) out->at[i] = random_direction(r);
    assert_int_equal(hull_build(&out->at[0].x, 4, 0, &out->hull), HULL_OK);
}

/* Also of overlap the axis proves lo; and no axis of a face separates by more than hi. */
static void holds(const narrow_result *r, const real3 *a, int count_a, const real3 *b, int count_b, int seed)
{
    real by_axis = separation(a, count_a, b, count_b, real3_of(r->axis));
    interval d = distance_of(a, count_a, b, count_b);
    if (by_axis < r->lo - DOUBT) fail_msg("%d: axis %.17g, lo %.17g", seed, (double)by_axis, r->lo);
    if (by_axis > r->hi + DOUBT) fail_msg("%d: axis %.17g, hi %.17g", seed, (double)by_axis, r->hi);
    if (d.hi < r->lo - DOUBT) fail_msg("%d: truth %.17g, lo %.17g", seed, (double)d.hi, r->lo);
    if (d.lo > DOUBT && d.lo > r->hi + DOUBT) fail_msg("%d: truth %.17g, hi %.17g", seed, (double)d.lo, r->hi);
}

static void bounds_hold_for_all_points_given(void **state)
{
    (void)state;
    int refined = 0, above = 0;
    for (int i = 0; i < 2 * rounds(); i++) {
        random_state random = {(uint64_t)i};
        given a, b;
        real3 points_a[POINTS_MAX], points_b[POINTS_MAX];
        make(&random, i, &a);
        if (i % 3)
            make_corner(&random, &b);
        else
            make(&random, i / 3, &b);
        pose pa = {vec_scale(random_direction(&random), i % 2), i % 4 ? random_rotation(&random) : (quat){1, 0, 0, 0}};
        pose pb = put_near(&random, &a, &pa, &b);
        shape sa = {.type = SHAPE_HULL, .hull = a.hull}, sb = {.type = SHAPE_HULL, .hull = b.hull};
        placed oa = oracle_place(&sa, pa, pa.p), ob = oracle_place(&sb, pb, pa.p);
        place_points(&a, &oa, points_a);
        place_points(&b, &ob, points_b);
        narrow_request fine = measure_exactly(), exact = fine, verdict = {.facts = NARROW_VERDICT, .range = INFINITY};
        fine.tolerance = 1e-12;
        exact.tolerance = 0;
        verdict.threshold = (double)distance_of(points_a, a.count, points_b, b.count).lo;
        const narrow_request *requests[] = {&fine, &exact, &verdict};
        for (int k = 0; k < 3; k++) {
            narrow_result r;
            narrow_query_world(&sa, pa, &sb, pb, requests[k], case_scratch(), &r);
            holds(&r, points_a, a.count, points_b, b.count, i);
            refined += r.refined;
            above += r.lo > 0;
        }
        hull_destroy(a.hull);
        hull_destroy(b.hull);
    }
    assert_true(refined > rounds() && above > rounds());
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_excess_is_what_is_left_out),
        cmocka_unit_test(what_is_in_the_hull_adds_nothing),
        cmocka_unit_test(scaling_scales_the_excess),
        cmocka_unit_test(bounds_hold_for_all_points_given),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
