/* primitive_pair: what the formulas of two primitives share (primitives.h). Pure; any thread.
 *
 * If both shapes have ordinary sizes, whose squares are in range, a formula takes lengths as they are; if not, it takes
 * them at unit size. The two differ by a power of two, so that where both can answer they give the same bits.
 *
 * Rounding: the bound is unit_pair's, of which these use less, for no quaternions are multiplied: a matrix is off by
 * 6 u, products and sums by 3 u each; and the sum of the sizes by a few u of itself. */
#ifndef COLLIDED_NARROW_PRIMITIVES_PRIMITIVE_PAIR_H
#define COLLIDED_NARROW_PRIMITIVES_PRIMITIVE_PAIR_H

#include "geom/round.h"
#include "narrow/convex/epa.h"
#include "narrow/pair/finish.h"

#define INLINE __attribute__((always_inline)) static inline

/* Sizes (m) between these are ordinary: with them no number below is subnormal or infinite, except for a distance of
 * cores below NOTICEABLE. */
#define LEAST_EVERYDAY 0x1p-32
#define GREATEST_EVERYDAY 0x1p32
#define NOTICEABLE 0x1p-150
#define LEAST_UNIT_SQUARE 0x1p-900 /* the least square of such a distance at unit size */

/* All vectors are in the frame of the answer, whose origin is A's centre. For two ellipsoids and for two boxes that is
 * A's frame. Vectors are read as four doubles, so a number has to follow each. */
typedef struct primitive_pair {
    const shape *a, *b;
    const narrow_request *request;
    vec3 between; /* from A's centre to B's */
    vec3 along_a; /* A's z axis */
    mat3 turn_b;  /* B's axes; not of spheres */
    double reach_a, reach_b;
    bool everyday;
    bool outside; /* set by a formula that gives up because the sizes are not ordinary */
} primitive_pair;

/* A formula returns false if a search has to answer, or if the pair is `outside`; then *out is not valid. */
typedef bool primitive_formula(primitive_pair *q, narrow_result *out);
primitive_formula capsule_beside_box;    /* primitives.c */
primitive_formula ellipsoids_by_verdict; /* primitives.c */

/* box_box.c: with the cache of the pair, and with scratch memory for a search; both may be NULL. */
bool box_beside_box(primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out);

/* Does the request need more than a verdict? Contact points need the depth. */
INLINE bool is_measured(const narrow_request *r)
{
    return r->facts & (NARROW_DISTANCE | NARROW_MANIFOLD);
}

INLINE bool suffices(const narrow_request *r, const narrow_result *out)
{
    double beyond = r->facts & NARROW_DISTANCE ? r->range : r->threshold;
    bool measured = out->hi - out->lo <= r->tolerance || out->lo > beyond || !is_measured(r);
    bool decided = out->lo > r->threshold || out->hi <= r->threshold || r->facts == NARROW_DISTANCE;
    return measured && decided;
}

/* Does what unit_pair_init does, except for the size. */
INLINE void begin(const primitive_pair *q, unit_pair *p)
{
    p->unit = p->scale = 1;
    if (!q->everyday) unit_of(max_of(max_of(q->reach_a, q->reach_b), vec_greatest(q->between)), &p->unit, &p->scale);
    p->a.radius = q->a->radius * p->scale;
    p->b.radius = q->b->radius * p->scale;
    p->b_in_a.t = vec_scale(q->between, p->scale);
    p->radius = p->a.radius + p->b.radius;
    p->excess = 0;
}

INLINE bool is_everyday(primitive_pair *q, double size, double norm2)
{
    bool in_range = !q->everyday || (size > LEAST_EVERYDAY && max_of(size, norm2) < GREATEST_EVERYDAY);
    q->outside = !in_range;
    return in_range;
}

INLINE bool is_in_range(primitive_pair *q, unit_pair *p)
{
    p->size = (q->reach_a + q->reach_b) * p->scale + vec_norm(p->b_in_a.t);
    p->error = unit_error(p->size);
    return is_everyday(q, p->size, 0);
}

/* Is the root of this square, the distance of the cores, exact but for its rounding? */
INLINE bool is_noticed(primitive_pair *q, double norm2)
{
    bool noticed = norm2 > (q->everyday ? NOTICEABLE * NOTICEABLE : LEAST_UNIT_SQUARE);
    q->outside = q->everyday && !noticed;
    return noticed;
}

/* Writes the answer. The points of the shapes are those of the cores, moved by the radii along `towards`. */
INLINE bool end(const primitive_pair *q, const unit_pair *p, const span *s, vec3 towards, narrow_result *out)
{
    set_bounds(p, s, out);
    out->axis = s->axis;
    out->point_a = vec_scale(vec_madd(s->point_a, p->a.radius, towards), p->unit);
    out->point_b = vec_scale(vec_madd(s->point_b, -p->b.radius, towards), p->unit);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

#endif
