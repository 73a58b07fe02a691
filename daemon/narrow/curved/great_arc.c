/* great_arc: arcs are cut until nothing on them is below what is allowed. Pure; any thread. */
#include "revolved.h"

#include "narrow/convex/gjk.h"

enum { ARCS_MAX = 32 /* open at a time */, STEPS_MAX = 200 };

static const double NOISE = 24;                    /* rounding of a bound, in units of the last place, rounded up */
static const double FLATTEST = 4;                  /* of the size: no greater radius of curvature is of use */
static const double LESS = 1 - 16 * UNIT_ROUNDOFF; /* a radius of curvature, rounded down */
static const double EDGE = 1e-9;                   /* an arc is not cut nearer to its end than this */
static const double CLOSE = 0x1p-20; /* of the size: the search goes on to here, for its last steps cost less than to
                                        look for points that face each other along an axis that is a little off */

typedef struct arc { /* counter-clockwise */
    tip a, b;
    double bound; /* no h on the arc is less */
    plane2 at;    /* where the bound is */
} arc;

arc_search arc_search_of(const unit_pair *p, const narrow_goal *goal)
{
    double tolerance = min_of(goal->tolerance, CLOSE * p->size);
    return (arc_search){.size = p->size,
        .least = INFINITY,
        .axis = VEC_ZERO,
        .proved = INFINITY,
        .short_by = max_of(0.5 * tolerance, 2 * NOISE * UNIT_ROUNDOFF * p->size),
        .enough = -goal->near};
}

bool arc_search_report(const arc_search *x, const unit_pair *p, const narrow_goal *goal, minkowski *top, span *out)
{
    double noise = NOISE * UNIT_ROUNDOFF * p->size;
    *top = unit_pair_nearest_along(p, x->axis);
    double lo = vec_dot(x->axis, top->w), hi = max_of(lo, noise - min_of(x->proved, x->least));
    if (!narrow_goal_reached(goal, lo, hi) && !(hi - lo <= 4 * noise)) return false;
    *out = (span){.lo = lo, .hi = hi, .axis = x->axis, .method = NARROW_BY_CLOSED_FORM, .iterations = x->steps};
    return true;
}

static bool is_closed(arc_search *x, double bound)
{
    if (!(bound >= arc_level(x))) return false;
    x->proved = min_of(x->proved, bound);
    return true;
}

/* The least p.n from n1 to n2. */
static double least_between(plane2 p, plane2 n1, plane2 n2, plane2 *at)
{
    if (cross2(n1, p) < 0 && cross2(n2, p) > 0) {
        double length = sqrt(dot2(p, p));
        *at = (plane2){-p.x / length, -p.y / length};
        return -length;
    }
    double at_1 = dot2(p, n1), at_2 = dot2(p, n2);
    *at = at_1 < at_2 ? n1 : n2;
    return min_of(at_1, at_2);
}

/* Where one point takes over from the other, if that is in the arc; any direction of it would do. */
static plane2 change_at(const arc *a, plane2 from, plane2 to)
{
    plane2 n = {to.y - from.y, from.x - to.x};
    if (!(cross2(a->a.n, n) > 0 && cross2(n, a->b.n) > 0)) n = madd2(a->a.n, 1, a->b.n);
    return unit2(n);
}

static void bound_arc(arc_search *x, const quadrant *q, arc *a)
{
    bool turns = (a->a.y < 0) != (a->b.y < 0);
    double sine = turns ? 1 : max_of(a->a.sine, a->b.sine), cube = sine * sine * sine;
    double rho = cube > 0 ? min_of(LESS * (q->round + q->r * q->ui2 / cube), FLATTEST * x->size) : 0;
    plane2 from = madd2(a->a.p, -rho, a->a.n), to = madd2(a->b.p, -rho, a->b.n), n = change_at(a, from, to), at;
    a->bound = least_between(from, a->a.n, n, &a->at);
    double other = least_between(to, n, a->b.n, &at);
    if (other < a->bound) a->bound = other, a->at = at;
    a->bound += rho;
    x->steps++;
}

static plane2 cut_at(const arc *a)
{
    double before = cross2(a->a.n, a->at), behind = cross2(a->at, a->b.n);
    return before > EDGE && behind > EDGE ? a->at : unit2(madd2(a->a.n, 1, a->b.n));
}

bool arc_close(arc_search *x, const quadrant *q, double slope, const tip *from, const tip *to)
{
    arc open[ARCS_MAX];
    int count = 1;
    open[0] = (arc){.a = *from, .b = *to};
    bound_arc(x, q, &open[0]);
    while (count) {
        arc a = open[--count];
        if (is_closed(x, a.bound)) continue;
        if (count + 2 > ARCS_MAX || x->steps > STEPS_MAX) return false;
        tip cut = arc_tip(q, slope, cut_at(&a));
        arc_take_at(x, q, cut.n, dot2(cut.p, cut.n));
        if (!arc_is_deep(x)) return false;
        arc *l = &open[count++], *r = &open[count++];
        l->a = a.a, l->b = r->a = cut, r->b = a.b;
        bound_arc(x, q, l);
        bound_arc(x, q, r);
    }
    return true;
}
