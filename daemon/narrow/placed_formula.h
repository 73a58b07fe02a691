/* placed_formula: what the formulas of placed_road.h share. Each is one function a pair of types, inlined twice: for
 * sizes of everyday, whose squares are in range as they are, and for all others, which are first brought to unit size.
 * All that is between the two is a power of two: where both can answer, they do with the same bits. Pure; any thread.
 *
 * Rounding: the bound is unit_pair's, of which these use less, for no quaternions are multiplied: a matrix is off by
 * 6 u, products and sums by 3 u each; and the sum of the sizes by a few u of itself. */
#ifndef COLLIDED_NARROW_PLACED_FORMULA_H
#define COLLIDED_NARROW_PLACED_FORMULA_H

#include "finish.h"
#include "formulas.h"
#include "geom/round.h"
#include "placed_road.h"

#define INLINE __attribute__((always_inline)) static inline
#define APART __attribute__((noinline, cold)) static

/* Sizes (m) between these are everyday; with them nothing below leaves the normal numbers, except a distance between
 * cores that is less than NOTICEABLE. */
#define LEAST_EVERYDAY 0x1p-32
#define GREATEST_EVERYDAY 0x1p32
#define NOTICEABLE 0x1p-150
#define LEAST_UNIT_SQUARE 0x1p-900 /* and of pairs of unit size, of which the square may be less */

typedef struct placed {
    const shape *a, *b;
    const narrow_placed *at_a, *at_b;
    const narrow_request *request;
    bool everyday;
} placed;

INLINE bool suffices(const narrow_request *r, const narrow_result *out)
{
    bool measured = out->hi - out->lo <= r->tolerance || out->lo > r->range || !(r->facts & NARROW_DISTANCE);
    bool decided = out->lo > r->threshold || out->hi <= r->threshold || r->facts == NARROW_DISTANCE;
    return measured && decided;
}

/* What unit_pair_init does but for the size. */
INLINE void begin(const placed *q, unit_pair *p)
{
    vec3 between = vec_sub(q->at_b->at.p, q->at_a->at.p);
    p->unit = p->scale = 1;
    if (!q->everyday)
        unit_of(max_of(max_of(q->at_a->reach, q->at_b->reach), vec_greatest(between)), &p->unit, &p->scale);
    p->a.radius = q->at_a->radius * p->scale;
    p->b.radius = q->at_b->radius * p->scale;
    p->b_in_a.t = vec_scale(between, p->scale);
    p->radius = p->a.radius + p->b.radius;
    p->excess = 0;
}

INLINE bool is_in_range(const placed *q, unit_pair *p)
{
    p->size = (q->at_a->reach + q->at_b->reach) * p->scale + vec_norm(p->b_in_a.t);
    p->error = unit_error(p->size);
    return !q->everyday || (p->size > LEAST_EVERYDAY && p->size < GREATEST_EVERYDAY);
}

/* Is the root of this square, the distance of the cores, exact but for its rounding? */
INLINE bool is_noticed(const placed *q, double norm2)
{
    return norm2 > (q->everyday ? NOTICEABLE * NOTICEABLE : LEAST_UNIT_SQUARE);
}

/* The shapes' points, on from those of the cores, `towards` each other. */
INLINE bool end(const placed *q, const unit_pair *p, const span *s, vec3 towards, narrow_result *out)
{
    set_bounds(p, s, out);
    out->axis = s->axis;
    out->point_a = vec_scale(vec_madd(s->point_a, p->a.radius, towards), p->unit);
    out->point_b = vec_scale(vec_madd(s->point_b, -p->b.radius, towards), p->unit);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

/* Two functions of a formula, bool formula(const placed *, narrow_result *): the one for the table, formula_placed, and
 * the one for sizes that are not of everyday. */
#define ROAD(formula)                                                                                                  \
    APART bool formula##_of_any_size(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,    \
        narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)                                           \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, false};                                                   \
        (void)cache, (void)scratch;                                                                                    \
        return formula(&q, result);                                                                                    \
    }                                                                                                                  \
    bool formula##_placed(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,               \
        narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)                                           \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, true};                                                    \
        return formula(&q, result) || formula##_of_any_size(a, b, request, cache, scratch, result);                    \
    }

/* The same of a formula that may fail for other reasons than the size: then there is nothing to try again. */
#define ROAD_AT_ONCE(formula)                                                                                          \
    APART bool formula##_otherwise(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,      \
        narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)                                           \
    {                                                                                                                  \
        unit_pair p;                                                                                                   \
        placed q = {a->shape, b->shape, a, b, request, true};                                                          \
        begin(&q, &p);                                                                                                 \
        bool tried = is_in_range(&q, &p);                                                                              \
        q.everyday = false;                                                                                            \
        (void)cache, (void)scratch;                                                                                    \
        return !tried && formula(&q, result);                                                                          \
    }                                                                                                                  \
    bool formula##_placed(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,               \
        narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)                                           \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, true};                                                    \
        return formula(&q, result) || formula##_otherwise(a, b, request, cache, scratch, result);                      \
    }

placed_road ball_and_capsule_placed; /* placed_road.c */
placed_road capsule_and_box_placed;  /* placed_capsule_box.c */
placed_road two_boxes_placed;        /* placed_boxes.c */
placed_road two_ellipsoids_placed;   /* placed_ellipsoids.c */

#endif
