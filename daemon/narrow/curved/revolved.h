/* revolved: depths of bodies of revolution, of cylinders, and of either and boxes, by a search of few directions. Pure;
 * any thread. */
#ifndef COLLIDED_NARROW_CURVED_REVOLVED_H
#define COLLIDED_NARROW_CURVED_REVOLVED_H

#include "narrow/math/scalar.h"
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

#define OUTLINE_SURE (1 - 1e-9) /* covers the rounding of radii */

typedef struct end {
    double h, rise; /* the overlap along the end's normal, and how much it rises beside that, per tangent */
} end;

/* `lowest`: of the other body's, from the end's body. */
static inline end end_of(const outline *o, double side, vec3 normal, vec3 lowest)
{
    double along = vec_dot(lowest, normal), flat = o->cone && side > 0 ? 0 : o->r;
    return (end){o->h - along, OUTLINE_SURE * flat - vec_norm(vec_madd(lowest, -along, normal))};
}

/* The cosine, from the end on, up to which nothing is below `level`: H + rise T >= level sqrt(1 + T^2) from T = 0 to
 * the root of level^2 (1 + T^2) = (H + rise T)^2; 1 = nowhere, 0 = as far as the axis sees. */
static inline double outline_reach_of(const end *e, double level)
{
    double a = level * level - e->rise * e->rise, h2 = e->h * e->h - level * level, slope = e->h * e->rise;
    if (!(h2 >= 0) || (!(e->rise > 0) && !(h2 > 0))) return 1;
    if (e->rise > 0 && !(a > 0)) return 0;
    double root = sqrt(max_of(slope * slope + a * h2, 0));
    double tangent = OUTLINE_SURE * (e->rise > 0 ? (slope + root) / a : h2 / (root - slope));
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

/* ==== arcs of directions ==== */

/* The least overlap of two cores over arcs of great circles of directions, along which the one that is
 * turned shows a rim: for box_revolved.c and cylinder_pair.c.
 *
 * Along a unit direction m from A towards B the cores overlap by h(m), the support function of C = A - B. On a great
 * circle it is that of the projection of C along the circle's axis. Where B shows a rim, that is the sum of an ellipse,
 * a disc (or, of a box, a corner: a disc of no radius) and a point, whose radius of curvature is
 *     rho(m) = round + r u_i^2 / (1 - y^2)^(3/2),   y = m.u, i along the circle's axis.
 * Over an arc where rho is at least rho_0, h - rho_0 is the support function of a convex curve, too; it holds
 * q_k = p_k - rho_0 n_k, p_k the support points at the ends n_k of the arc: so
 *     h(n) >= rho_0 + q_1.n   and   h(n) >= rho_0 + q_2.n,
 * and the least of the greater of them has a closed form. Where it falls short of the least h found by more than is
 * allowed, the arc is cut there. About a least rho > h: then q_k lies behind the origin, and the bound of an arc that
 * ends there is h. It takes two or three cuts. */

static inline plane2 madd2(plane2 a, double s, plane2 b)
{
    return (plane2){a.x + s * b.x, a.y + s * b.y};
}
static inline plane2 unit2(plane2 a)
{
    double per = 1 / sqrt(dot2(a, a));
    return (plane2){per * a.x, per * a.y};
}

/* What a search for the least h knows. */
typedef struct arc_search {
    double size;
    double least;
    vec3 axis;     /* where the least h was found */
    double proved; /* of what was left out */
    double short_by, enough;
    uint32_t steps;
} arc_search;

arc_search arc_search_of(const unit_pair *p, const narrow_goal *goal);

static inline void arc_take(arc_search *x, double h, vec3 m)
{
    if (!(h < x->least)) return;
    x->least = h;
    x->axis = m;
}

/* Less depth, or none, is found by other means. */
static inline bool arc_is_deep(const arc_search *x)
{
    return x->least > 0x1p-24 * x->size;
}

/* A bound that is not below it need not be raised. */
static inline double arc_level(const arc_search *x)
{
    return min_of(x->least - x->short_by, x->enough);
}

/* What was found, and what was proved, as an answer but for the points, and the support points along its axis. False:
 * it is wider than the goal, and than rounding. */
bool arc_search_report(const arc_search *x, const unit_pair *p, const narrow_goal *goal, minkowski *top, span *out);

/* A quarter of a great circle: its directions are n.x along[0] + n.y along[1], n.x, n.y >= 0. */
typedef struct quadrant {
    vec3 along[2];
    plane2 u, v, c, d; /* v: A's corner or the centre of its disc, less B's centre; c: unit, along u; d: a quarter turn
                         from there */
    double ui2;        /* u_i^2 */
    double s;          /* |u| in the plane */
    double r, round;   /* of B's rim, and of A's disc */
} quadrant;

typedef struct tip { /* a direction, the support point there of the piece that the arc is of, and the cosine and sine */
    plane2 n, p;
    double y, sine;
} tip;

/* `slope`: f is r sine + slope y on the piece. */
static inline tip arc_tip(const quadrant *q, double slope, plane2 n)
{
    tip t = {.n = n, .y = dot2(q->u, n)};
    double along = dot2(q->c, n), beside = dot2(q->d, n);
    t.sine = sqrt(q->ui2 * along * along + beside * beside);
    double per = t.sine > 0 ? q->r / t.sine : 0, on_c = per * q->ui2 * along, off_c = per * beside;
    t.p = madd2(madd2(q->v, slope, q->u), on_c, q->c);
    t.p = madd2(madd2(t.p, off_c, q->d), q->round, n);
    return t;
}

static inline void arc_take_at(arc_search *x, const quadrant *q, plane2 n, double h)
{
    if (h < x->least) arc_take(x, h, vec_madd(vec_scale(q->along[0], n.x), n.y, q->along[1]));
}

/* All of an arc of a rim, counter-clockwise. False: too many cuts, or not deep. */
bool arc_close(arc_search *x, const quadrant *q, double slope, const tip *from, const tip *to);

#endif
