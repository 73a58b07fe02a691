/* bounds: the signed distance of any two convex cores, between a bound from inside and a bound from outside.
 *
 * W = B - A is known by its support points only. Their convex hull lies inside W; the planes through them bound W from
 * outside. Apart: the point of the inner hull that is nearest to the origin bounds the distance from above, its plane
 * from below. Overlapping: the inner hull is grown at the facet nearest to the origin until no facet can be nearer.
 * Both bounds are proofs by themselves, however the search went; half their difference is the reported error. */
#include "expand.h"

/* The point of W = B - A that is lowest along n. */
static qvec lowest(const oracle_body *a, const oracle_body *b, qvec n)
{
    return q_sub(oracle_support(b, q_neg(n)), oracle_support(a, n));
}

typedef struct simplex {
    qvec w[4];
    int count;
    qvec nearest; /* to the origin */
} simplex;

/* Keeps the points of the mask if the origin's foot on their affine hull lies within them and is nearer than before. */
static void keep_if_nearer(simplex *best, const simplex *s, unsigned mask, qvec foot, bool within)
{
    if (!within || (best->count > 0 && q_dot(foot, foot) >= q_dot(best->nearest, best->nearest))) return;
    best->count = 0;
    best->nearest = foot;
    for (int i = 0; i < s->count; i++)
        if (mask >> i & 1) best->w[best->count++] = s->w[i];
}

static void try_segment(simplex *best, const simplex *s, int i, int j)
{
    qvec d = q_sub(s->w[j], s->w[i]);
    quad length2 = q_dot(d, d);
    if (!(length2 > 0)) return;
    quad t = -q_dot(d, s->w[i]) / length2;
    keep_if_nearer(best, s, 1U << i | 1U << j, q_add(s->w[i], q_scale(d, t)), t >= 0 && t <= 1);
}

static void try_triangle(simplex *best, const simplex *s, int i, int j, int k)
{
    qvec a = s->w[i], b = s->w[j], c = s->w[k];
    qvec n = q_cross(q_sub(b, a), q_sub(c, a));
    quad n2 = q_dot(n, n);
    if (!(n2 > 0)) return;
    qvec foot = q_scale(n, q_dot(n, a) / n2);
    bool within = q_dot(q_cross(q_sub(b, a), q_sub(foot, a)), n) >= 0 &&
                  q_dot(q_cross(q_sub(c, b), q_sub(foot, b)), n) >= 0 &&
                  q_dot(q_cross(q_sub(a, c), q_sub(foot, c)), n) >= 0;
    keep_if_nearer(best, s, 1U << i | 1U << j | 1U << k, foot, within);
}

static bool same_side(qvec a, qvec b, qvec c, qvec apex)
{
    qvec n = q_cross(q_sub(b, a), q_sub(c, a));
    return q_dot(n, q_sub(apex, a)) * -q_dot(n, a) > 0;
}

static bool holds_origin(const simplex *s)
{
    const qvec *w = s->w;
    return s->count == 4 && same_side(w[0], w[1], w[2], w[3]) && same_side(w[0], w[1], w[3], w[2]) &&
           same_side(w[0], w[2], w[3], w[1]) && same_side(w[1], w[2], w[3], w[0]);
}

/* Reduces the simplex to the points that carry the one nearest to the origin. */
static void reduce(simplex *s)
{
    simplex best = {.count = 0};
    for (int i = 0; i < s->count; i++) keep_if_nearer(&best, s, 1U << i, s->w[i], true);
    for (int i = 0; i < s->count; i++)
        for (int j = i + 1; j < s->count; j++) {
            try_segment(&best, s, i, j);
            for (int k = j + 1; k < s->count; k++) try_triangle(&best, s, i, j, k);
        }
    *s = best;
}

enum { NEAREST_STEPS_MAX = 2000 };

/* Bounds [lo, hi] of the distance of the cores; lo < 0 or hi = 0 when they may overlap. */
static void nearest_bounds(const oracle_body *a, const oracle_body *b, quad tiny, quad *lo, quad *hi, qvec *axis)
{
    simplex s = {.count = 1};
    s.w[0] = s.nearest = lowest(a, b, qv(1, 0, 0));
    *lo = -INFINITY;
    *hi = q_norm(s.nearest);
    *axis = qv(1, 0, 0);
    for (int step = 0; step<NEAREST_STEPS_MAX && * hi> tiny && *hi - *lo > tiny; step++) {
        qvec n = q_unit(s.nearest), w = lowest(a, b, n);
        if (q_dot(n, w) > *lo) {
            *lo = q_dot(n, w);
            *axis = n;
        }
        s.w[s.count++] = w;
        if (holds_origin(&s)) {
            *hi = 0;
            return;
        }
        reduce(&s);
        if (!(q_norm(s.nearest) < *hi)) return; /* arithmetic ends here */
        *hi = q_norm(s.nearest);
    }
    if (*hi <= tiny) *hi = 0;
}

/* Climbs f from `axis` by steps across it that halve when none helps: the last digits, where the bounds from inside
 * come too slowly. */
static quad polish(const oracle_body *a, const oracle_body *b, quad f, qvec *axis)
{
    static const int around[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    quad step = 0x1p-6;
    for (int halvings = 0; halvings < 54; halvings++, step /= 2) {
        qvec side = q_unit(q_cross(*axis, q_abs(axis->x) < 0.5 ? qv(1, 0, 0) : qv(0, 1, 0)));
        qvec other = q_cross(*axis, side), best = *axis;
        for (int i = 0; i < 8; i++) {
            qvec aside = q_add(q_scale(side, step * around[i][0]), q_scale(other, step * around[i][1]));
            qvec n = q_unit(q_add(*axis, aside));
            quad here = q_dot(n, lowest(a, b, n));
            if (here > f) f = here, best = n;
        }
        *axis = best;
    }
    return f;
}

oracle_truth oracle_distance_bounds(const oracle_body *a, const oracle_body *b)
{
    return oracle_distance_bounds_in(a, b, EXPAND_STEPS_MAX);
}

oracle_truth oracle_distance_bounds_in(const oracle_body *a, const oracle_body *b, int steps)
{
    quad size = oracle_size(a, b), tiny = (quad)1e-26 * size, lo, hi;
    qvec axis;
    nearest_bounds(a, b, tiny, &lo, &hi, &axis);
    if (!(lo > 0)) {
        quad depth_lo = 0, depth_hi = 0;
        if (expand_depth(a, b, lowest, steps, &depth_lo, &depth_hi, &axis)) {
            lo = -depth_hi;
            hi = q_min(hi, -depth_lo);
            if (hi - lo > (quad)1e-18 * size) lo = polish(a, b, lo, &axis);
        } else {
            lo = q_max(lo, 0); /* W is flat: nothing has depth in it */
        }
    }
    quad radius = a->radius + b->radius;
    return (oracle_truth){.lo = lo - tiny - radius, .hi = q_max(hi, lo) + tiny - radius, .axis = axis};
}
