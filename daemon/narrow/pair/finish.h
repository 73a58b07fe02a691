/* finish: turns a request into the stopping criteria of a search, and the interval between two cores into the answer.
 * All of it is inlined, because it is a large part of the shortest queries. Pure; any thread. */
#ifndef COLLIDED_NARROW_PAIR_FINISH_H
#define COLLIDED_NARROW_PAIR_FINISH_H

#include "narrow/math/scalar.h"
#include "unit_pair.h"

/* With tolerance 0 an interval of this width, relative to the pair's size, is narrow enough: curved pairs get no
 * further. */
#define FINEST 1e-12

/* Bounds in metres, rounded down or up. The product rounds subnormal numbers; scaling back is exact and shows it. */
static inline double real_below(const unit_pair *p, double lo)
{
    double real = lo * p->unit;
    return p->unit < LEAST_EXACT_UNIT && real * p->scale > lo ? real - LEAST_NUMBER : real;
}
static inline double real_above(const unit_pair *p, double hi)
{
    double real = hi * p->unit;
    return p->unit < LEAST_EXACT_UNIT && real * p->scale < hi ? real + LEAST_NUMBER : real;
}

/* Writes the bounds of the shapes, widened by rounding, and the fields that are the same in every answer of doubles. */
static inline void set_bounds(const unit_pair *p, const span *s, narrow_result *out)
{
    double lo = s->lo - p->radius - p->error - p->excess, hi = s->hi - p->radius + p->error;
    out->lo = real_below(p, lo);
    out->hi = real_above(p, hi);
    out->method = s->method;
    out->iterations = s->iterations;
    out->manifold.count = 0;
    out->peer_failures = 0;
    out->refined = false;
}

/* Turns the answer about two cores into that about the shapes, at real size. Radii are added along the line between the
 * points if the shapes are apart, or may be, else along the axis. */
static inline void finish(const unit_pair *p, const span *s, narrow_result *out)
{
    vec3 towards = s->axis;
    if (s->hi + p->error > p->radius && p->radius > 0) {
        vec3 line = direction_of(vec_sub(s->point_b, s->point_a));
        if (vec_norm2(line) > 0) towards = line;
    }
    set_bounds(p, s, out);
    out->axis = direction_again(s->axis);
    out->point_a = vec_scale(vec_madd(s->point_a, p->a.radius, towards), p->unit);
    out->point_b = vec_scale(vec_madd(s->point_b, -p->b.radius, towards), p->unit);
}

/* Is the interval, widened by the rounding of doubles on both sides, as narrow as asked? With tolerance 0 an interval
 * that could not be narrower is. */
static inline bool is_narrow(const unit_pair *p, const narrow_request *r, const span *s)
{
    double asked = r->tolerance > 0 ? r->tolerance * p->scale : FINEST * p->size;
    if (s->hi - s->lo + 2 * p->error + p->excess <= asked) return true;
    return (r->tolerance == 0 || isinf(s->hi)) && s->lo == s->hi; /* last: nobody can guess whether they are equal */
}

/* How wide the interval may be, in metres. */
static inline double asked_width(const unit_pair *p, const narrow_request *r)
{
    return r->tolerance > 0 ? r->tolerance : FINEST * p->size * p->unit;
}

/* The stopping criteria that follow from the request. */
static inline narrow_goal goal_of(const unit_pair *p, const narrow_request *r)
{
    bool decide = r->facts == 0 || (r->facts & (NARROW_VERDICT | NARROW_MANIFOLD));
    bool measure = r->facts & (NARROW_DISTANCE | NARROW_MANIFOLD);
    double margin = p->radius + p->error, threshold = r->threshold * p->scale;
    /* The same sums in another order, when the answer is made, are to come to the same verdict. */
    double sums = 4 * UNIT_ROUNDOFF * (min_of(fabs(threshold), p->size) + margin + p->excess + p->deviation);
    double above = threshold + margin + p->excess + sums;
    double below = threshold + margin - 2 * p->error - p->deviation - sums;
    double finest = 2 * UNIT_ROUNDOFF * p->size, range = r->range * p->scale + margin + p->excess;
    double tolerance = r->tolerance * p->scale - 2 * p->error - p->excess;
    if (p->deviation < tolerance) tolerance -= p->deviation; /* where it is more, no search makes up for it */
    double far = decide ? above : -INFINITY;
    if (r->facts & NARROW_DISTANCE) far = max_of(far, range);
    return (narrow_goal){
        .tolerance = max_of(tolerance, finest),
        .finest = finest,
        .far = far,
        .near = measure ? -INFINITY : below,
        .above = above,
        .below = decide ? below : INFINITY,
        .brief = r->brief,
    };
}

static inline narrow_status status_of(const unit_pair *p, const narrow_goal *g, const narrow_request *r, const span *s)
{
    return is_narrow(p, r, s) || s->lo > g->far || s->hi <= g->near ? NARROW_CERTAIN : NARROW_WIDE;
}

#endif
