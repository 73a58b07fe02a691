/* revolved: depths of bodies of revolution, of cylinders, and of either and boxes, by a search of few directions. Pure;
 * any thread. */
#ifndef COLLIDED_NARROW_CURVED_REVOLVED_H
#define COLLIDED_NARROW_CURVED_REVOLVED_H

#include "narrow/pair/unit_pair.h"

/* ==== outlines ==== */

/* Bodies of revolution seen along a direction, by the cosine between it and their axis: for revolved_pair.c
 * and box_revolved.c. Plain values.
 *
 * The support function of a cylinder is h |x| + r sqrt(1 - x^2), of a cone max(h x, r sqrt(1 - x^2) - h x), of a
 * capsule's segment h |x|; all are concave on both sides of a kink.
 *
 * At a flat end the outline rises too steeply for chords to be of use (of revolved_pair.c). For n = z or -z and a
 * direction along n + d, d orthogonal to n, the overlap with another body that is lowest along n at the point b (seen
 * from this body's centre) is h(n + d) |n + d| >= H + (r - |b - (b.n) n|) |d|,   H = h(n), which is at least L |n + d|
 * up to a |d| that follows from a quadratic: so far nothing is below L. */

typedef struct outline {
    bool cone;
    double h, r, kink; /* kink: the cosine at which f has one */
} outline;

typedef struct mark { /* a cosine, f there, and the sine */
    double v, f, sine;
} mark;

static inline outline outline_of(const shape *s)
{
    double r = s->type == SHAPE_CAPSULE ? 0 : s->half.x, h = s->half.z;
    bool cone = s->type == SHAPE_CONE;
    return (outline){cone, h, r, cone ? r / sqrt(r * r + 4 * h * h) : 0};
}

static inline double height(const outline *o, double v, double sine)
{
    double rim = o->r * sine;
    return o->cone ? max_of(o->h * v, rim - o->h * v) : o->h * fabs(v) + rim;
}

static inline mark mark_at(const outline *o, double v)
{
    double sine = sqrt(max_of((1 - v) * (1 + v), 0));
    return (mark){v, height(o, v, sine), sine};
}

/* ---- flat ends ---- */

#define OUTLINE_SURE (1 - 1e-9) /* room for the rounding of radii */

typedef struct end {
    double h, room; /* the overlap along the end's normal, and by what it rises beside it, per tangent */
} end;

/* `lowest`: of the other body's, from the end's body. */
static inline end end_of(const outline *o, double side, vec3 normal, vec3 lowest)
{
    double along = vec_dot(lowest, normal), flat = o->cone && side > 0 ? 0 : o->r;
    return (end){o->h - along, OUTLINE_SURE * flat - vec_norm(vec_madd(lowest, -along, normal))};
}

/* Up to which cosine from the end nothing is below `level`: H + room T >= level sqrt(1 + T^2) from T = 0 to the root of
 * level^2 (1 + T^2) = (H + room T)^2; 1 = nowhere, 0 = as far as the axis sees. */
static inline double outline_reach_of(const end *e, double level)
{
    double a = level * level - e->room * e->room, h2 = e->h * e->h - level * level, slope = e->h * e->room;
    if (!(h2 >= 0) || (!(e->room > 0) && !(h2 > 0))) return 1;
    if (e->room > 0 && !(a > 0)) return 0;
    double root = sqrt(max_of(slope * slope + a * h2, 0));
    double tangent = OUTLINE_SURE * (e->room > 0 ? (slope + root) / a : h2 / (root - slope));
    return 1 / sqrt(1 + tangent * tangent);
}

typedef struct range {
    mark at[3];
} range;

static inline range range_of(const outline *o, const end ends[2], double level)
{
    double from = -outline_reach_of(&ends[0], level), to = outline_reach_of(&ends[1], level);
    double kink = min_of(max_of(o->kink, from), to);
    return (range){{mark_at(o, from), mark_at(o, kink), mark_at(o, to)}};
}

/* ==== bodies of revolution ==== */

/* The depth of two overlapping bodies of revolution about axes that are not parallel: cylinders, cones
 * and capsules. A search over two cosines, with a proof; revolved_pair.c derives it. */

/* False when the cores do not overlap by a tenth of the pair's size, when the axes are nearly parallel, or when the
 * search reached neither the goal nor what its rounding leaves, 2^-50 (64 + 16 / sine) of the size, of the sine of the
 * angle between the axes: then out->axis is zero, and nothing else of *out is written. */
bool revolved_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out);

/* ==== cylinders ==== */

/* The depth of two overlapping cylinders, or of a cylinder and a capsule, about axes that are not
 * parallel. It is found on two great circles of directions, along the axes, or between two rims, with a proof;
 * cylinder_pair.c derives it. */

/* What that leaves open revolved.h is asked about: false as there. */
bool cylinder_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out);

/* ==== boxes and bodies of revolution ==== */

/* The depth of a box and an overlapping cylinder or cone. It is found on three great circles of
 * directions, on one small circle or along the axis, with a proof; box_revolved.c derives it. */

/* False when the cores do not overlap by 2^-24 of the pair's size, or when the search did not reach the goal:
 * then out->axis is zero, and nothing else of *out is written. */
bool box_revolved_measure(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
