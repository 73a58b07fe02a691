/* separation: proofs that two shapes are apart, along one axis or a few, without a search. Pure; any thread. */
#include "narrow.h"
#include "narrow/closed/closed.h"
#include "narrow/convex/gjk.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/core.h"
#include "narrow/pair/finish.h"

/* ---- along one axis ---- */

/* The separation along one axis, and how far a pair may have moved since it was proven. */

static double plane_separation(const unit_pair *p)
{
    span s;
    if (p->a.type != SHAPE_HALFSPACE)
        closed_any_halfspace(p, NULL, &s);
    else if (p->b.type != SHAPE_HALFSPACE)
        closed_halfspace_any(p, NULL, &s);
    else
        closed_halfspace_halfspace(p, NULL, &s);
    return s.lo;
}

double unit_pair_separation(const unit_pair *p, vec3 axis, uint32_t *hint_a, uint32_t *hint_b)
{
    double separation;
    if (p->a.type == SHAPE_HALFSPACE || p->b.type == SHAPE_HALFSPACE)
        separation = plane_separation(p);
    else
        separation =
            vec_dot(axis, vec_sub(unit_pair_support_b(p, vec_neg(axis), hint_b), unit_pair_support_a(p, axis, hint_a)));
    return (separation - p->radius - p->error - p->excess) * p->unit;
}

/* Hulls of these sizes, whose heights are normal numbers, and which have no tree for their support points. */
static inline bool apart_is_everyday(const shape *a, const shape *b, double size)
{
    bool small = a->hull->padded_count <= HULL_SCAN_MAX && b->hull->padded_count <= HULL_SCAN_MAX;
    return small && size > 0x1p-300 && size < 0x1p300;
}

/* Does what unit_pair_separation does, for two hulls at their real size: their greatest heights are enough, and their
 * support points are not needed. Rounding is the same except for B's heights: the direction is turned into B's frame
 * (3 u), products and sums are its own (3 u), and there is one sum more. Half of that bound on top is more than enough.
 */
static double hulls_separation(const shape *a, const shape *b, const pose *b_in_a, double size, vec3 axis)
{
    vec3 back = mat_tmul(quat_matrix(b_in_a->q), vec_neg(axis));
    double between = vec_dot(axis, b_in_a->p), reached = hull_scan_top(a->hull, axis) + hull_scan_top(b->hull, back);
    double radius = a->radius + b->radius, excess = a->hull->excess + b->hull->excess;
    return between - reached - radius - 1.5 * unit_error(size) - excess;
}

double narrow_separation(
    const shape *a, const shape *b, const pose *b_in_a, vec3 axis, uint32_t *hint_a, uint32_t *hint_b)
{
    if (a->type == SHAPE_HULL && b->type == SHAPE_HULL) {
        double size = shape_reach(a) + shape_reach(b) + vec_norm(b_in_a->p);
        if (apart_is_everyday(a, b, size)) return hulls_separation(a, b, b_in_a, size, axis);
    }
    unit_pair p;
    unit_pair_init(&p, a, b, b_in_a);
    return unit_pair_separation(&p, axis, hint_a, hint_b);
}

/* The cores are no farther apart than their two support points. No translation shorter than the sum of the radii less
 * that distance separates the rounded shapes, because a translation changes a distance by at most its own length. */
void narrow_bounds(const shape *a, const shape *b, const pose *b_in_a, vec3 axis, narrow_result *result)
{
    unit_pair p;
    unit_pair_init(&p, a, b, b_in_a);
    minkowski m = unit_pair_nearest_along(&p, axis);
    span s = {.lo = vec_dot(axis, m.w),
        .hi = vec_norm(m.w),
        .axis = axis,
        .point_a = m.a,
        .point_b = m.b,
        .method = NARROW_BY_CLOSED_FORM};
    finish(&p, &s, result);
    result->status = NARROW_WIDE;
    double deviation = a->deviation + b->deviation;
    if (deviation > 0) result->hi = (max_of(result->hi, 0) + deviation) * (1 + 4 * UNIT_ROUNDOFF);
}

/* The vector to `p` from the nearest point of the box with half extents `half`. */
static vec3 apart_outside(vec3 half, vec3 p)
{
    return vec_sub(p, vec_max(vec_min(p, half), vec_neg(half)));
}

vec3 narrow_guess_axis(const shape *a, const shape *b, const pose *b_in_a)
{
    vec3 a_in_b = quat_rotate(quat_conj(b_in_a->q), vec_neg(b_in_a->p));
    vec3 from_a = apart_outside(a->half, b_in_a->p),
         from_b = vec_neg(quat_rotate(b_in_a->q, apart_outside(b->half, a_in_b)));
    return vec_unit(vec_norm2(from_a) > vec_norm2(from_b) ? from_a : from_b);
}

/* A vector out of range is brought to unit size first, which changes no bit but the exponent. */
static inline double length(vec3 v)
{
    double norm2 = vec_norm2(v), unit, scale;
    if (norm2 > 0x1p-900 && norm2 < 0x1p900) return sqrt(norm2);
    unit_of(vec_greatest(v), &unit, &scale);
    return vec_norm(vec_scale(v, scale)) * unit;
}

/* The rounding of both poses (9 u each, see unit_pair.c) and of the sums here. */
#define MOTION_ULPS 32

static inline bool are_same(const pose *a, const pose *b)
{
    return a->p.x == b->p.x && a->p.y == b->p.y && a->p.z == b->p.z && a->q.w == b->q.w && a->q.x == b->q.x &&
           a->q.y == b->q.y && a->q.z == b->q.z;
}

double narrow_motion_bound(const pose *before, const pose *now, double reach_b)
{
    if (isinf(reach_b)) return INFINITY;
    if (are_same(before, now)) return 0;
    quat turn = quat_mul(quat_conj(before->q), now->q);
    double shift = length(vec_sub(now->p, before->p));
    double moved = shift + 2 * length(vec(turn.x, turn.y, turn.z)) * reach_b;
    double scale = 2 * length(now->p) + shift + reach_b; /* no position is farther out */
    return moved + MOTION_ULPS * UNIT_ROUNDOFF * (moved + scale);
}

/* ---- along a few axes ---- */

/* The points of B - A found along the first axes form a simplex, as in GJK (gjk.h); the next axis is the direction of
 * its nearest point. If a few axes prove nothing, the query has to measure. It also has to measure a pair that was
 * together at its last query, unless one of the first axes separates it. */

enum { AXES_MAX = 4 };

static const double NEAR = 0x1p-5; /* of the size: whether two that may be this near are apart takes more axes than it
                                      is worth to try before they are measured */

typedef struct trial {
    unit_pair p;
    support_hints hints;
    simplex points;
    double limit, lower; /* m */
    vec3 axis;
    int tried;
} trial;

/* Tries one more axis. The separation has the bits that narrow_separation gives. */
static bool apart_try_axis(trial *t, vec3 axis)
{
    minkowski *m = &t->points.v[t->points.count++];
    unit_pair_nearest_to(&t->p, axis, &t->hints, m);
    t->axis = axis;
    t->tried++;
    t->lower = (vec_dot(axis, m->w) - t->p.radius - t->p.error - t->p.excess) * t->p.unit;
    return t->lower > t->limit;
}

static bool is_axis(vec3 v)
{
    return v.x != 0 || v.y != 0 || v.z != 0;
}

static bool apart_search(trial *t, const shape *a, const shape *b, const pose *b_in_a, const narrow_cache *cache)
{
    bool remembers = is_axis(cache->axis), met = remembers && !(cache->lower > t->limit);
    if (remembers && apart_try_axis(t, cache->axis)) return true;
    vec3 guess = narrow_guess_axis(a, b, b_in_a);
    if (is_axis(guess) && apart_try_axis(t, guess)) return true;
    double near = NEAR * t->p.size + t->p.radius;
    while (!met && t->tried > 0 && t->tried < AXES_MAX) {
        nearest_feature n = simplex_reduce(&t->points);
        if (n.inside || !((n.norm - near) * t->p.unit > t->limit)) return false;
        if (apart_try_axis(t, n.axis)) return true;
    }
    return false;
}

bool narrow_apart(const shape *a, const shape *b, const pose *b_in_a, double limit, narrow_cache *cache)
{
    trial t;
    unit_pair_init(&t.p, a, b, b_in_a);
    t.hints = (support_hints){cache->hint_a, cache->hint_b};
    t.points.count = 0;
    t.limit = limit;
    t.tried = 0;
    bool found = false;
    if (shape_is_plane(a) || shape_is_plane(b)) {
        t.axis = cache->axis;
        t.lower = unit_pair_separation(&t.p, t.axis, NULL, NULL);
        found = t.lower > limit;
    } else {
        found = apart_search(&t, a, b, b_in_a, cache);
        cache->hint_a = t.hints.a, cache->hint_b = t.hints.b;
    }
    if (!found) return false;
    cache->axis = t.axis;
    cache->lower = t.lower;
    cache->b_in_a = *b_in_a;
    return true;
}
