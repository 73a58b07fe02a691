/* outline: bodies of revolution seen along a direction, by the cosine between it and their axis: for revolved_pair.c
 * and box_revolved.c. Plain values.
 *
 * The support function of a cylinder is h |x| + r sqrt(1 - x^2), of a cone max(h x, r sqrt(1 - x^2) - h x), of a
 * capsule's segment h |x|; all are concave on both sides of a kink.
 *
 * At a flat end the outline rises too steeply for chords to be of use (of revolved_pair.c). For n = z or -z and a
 * direction along n + d, d orthogonal to n, the overlap with another body that is lowest along n at the point b (seen
 * from this body's centre) is h(n + d) |n + d| >= H + (r - |b - (b.n) n|) |d|,   H = h(n), which is at least L |n + d|
 * up to a |d| that follows from a quadratic: so far nothing is below L. */
#ifndef COLLIDED_NARROW_OUTLINE_H
#define COLLIDED_NARROW_OUTLINE_H

#include "unit_pair.h"

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
static inline double reach_of(const end *e, double level)
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
    double from = -reach_of(&ends[0], level), to = reach_of(&ends[1], level);
    double kink = min_of(max_of(o->kink, from), to);
    return (range){{mark_at(o, from), mark_at(o, kink), mark_at(o, to)}};
}

#endif
