/* great_arc: the least overlap of two cores over arcs of great circles of directions, along which the one that is
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
 * ends there is h. It takes two or three cuts. Pure; any thread. */
#ifndef COLLIDED_NARROW_CURVED_GREAT_ARC_H
#define COLLIDED_NARROW_CURVED_GREAT_ARC_H

#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

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
bool arc_search_tell(const arc_search *x, const unit_pair *p, const narrow_goal *goal, minkowski *top, span *out);

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
