/* verify: is a claimed interval of the signed distance proven by its axis and its points? Pure; any thread.
 *
 * Lower bound: along any unit n, the gap between B's nearest and A's farthest plane, sep(n) = min n.b - max n.a, is at
 * most the signed distance (which is the greatest sep when the shapes overlap, and when they do not). So sep(axis) >=
 * lo proves lo. Upper bound: two points, one of each shape, are at least the distance apart; so |pb - pa| <= hi proves
 * a hi that is not negative. A negative hi (at least so deep) cannot be proven by two points; it is refused when its
 * points are not the shapes' or not so deep along the axis, or when the axis contradicts it. Of shapes with deviations,
 * the sum of these must fit between the points' distance and hi; shapes that overlap count as 0 apart, which again is
 * not proven.
 *
 * A compound is the union of its children: their convex hull's sep proves what it proves, the points may be any
 * child's. It says nothing of what lies in the hollows, so that a true claim may be neither proven nor contradicted.
 *
 * Sizes whose squares overflow prove nothing. Rounding is allowed for by SLACK unit roundoffs of a double times the
 * sizes that entered: the shapes' reaches and the exact distance of the bodies for lo; for points, which are world
 * coordinates, the bodies' positions too. */
#include "collided.h"
#include "verify_hull.h"
#include "verify_shape.h"

#include <math.h>

#define SLACK (64 * 0x1p-53)
static const real unit_tolerance = 1e-9; /* of the axis' length, and of its agreement with a half-space's normal */

typedef struct pair {
    placed a, b;
    vec between; /* from A's body to B's */
    real reach;
    vec axis; /* the proper axis of the claim; zero if it has none */
    bool has_axis;
} pair;

static bool is_halfspace(const placed *p)
{
    return p->shape->type == COLLIDED_HALFSPACE;
}

/* Of shapes that are convex the axis and the points say all. */
static collided_status unproven(const pair *p)
{
    bool hollow = p->a.shape->type == COLLIDED_COMPOUND || p->b.shape->type == COLLIDED_COMPOUND;
    return hollow ? COLLIDED_UNSUPPORTED : COLLIDED_REJECTED;
}

/* The claimed axis made exactly unit; beside a half-space, which reaches infinitely far along all directions but one,
 * its normal. False if it is not a proper axis. */
static bool proper_axis(const pair *p, const double claimed[3], vec *n)
{
    *n = vec_of(claimed);
    real norm = length(*n);
    if (!(fabs(norm - 1) <= unit_tolerance)) return false;
    *n = scale(1 / norm, *n);
    if (!is_halfspace(&p->a) && !is_halfspace(&p->b)) return true;
    vec normal = is_halfspace(&p->a) ? placed_normal(&p->a) : scale(-1, placed_normal(&p->b));
    if (!(length(sub(normal, *n)) <= unit_tolerance)) return false;
    *n = normal;
    bool both = is_halfspace(&p->a) && is_halfspace(&p->b);
    return !both || length(add(placed_normal(&p->b), normal)) <= SLACK;
}

static real separation(const pair *p, vec n)
{
    return dot(n, p->between) - placed_support(&p->a, n) - placed_support(&p->b, scale(-1, n));
}

/* Of the sizes: how far points named as the deepest may fall short of it, where a search found them. They prove nothing
 * of how deep the shapes are in each other; they say where. */
#define SHORT_OF_DEEPEST 0x1p-31

/* And by as much as the depth is unknown. */
static double width(const collided_certificate *claim)
{
    return claim->lo > -INFINITY ? claim->hi - claim->lo : 0;
}

static bool is_finite_point(const double v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

/* Is one of the points, or what lies midway, in both? Then the shapes overlap, whatever the axis says. */
static bool points_overlap(const pair *p, vec a, vec b, vec n, real slack)
{
    vec midway = scale(0.5, add(a, b)), back = scale(-1, n);
    real unused;
    return placed_holds(&p->b, a, back, slack, &unused) || placed_holds(&p->a, b, n, slack, &unused) ||
           (placed_holds(&p->a, midway, n, slack, &unused) && placed_holds(&p->b, midway, back, slack, &unused));
}

/* The points belong to the shapes and are near enough to each other, or deep enough in each other; and not nearer than
 * lo says, which a compound's axis need not prove. */
static collided_status judge_points(const pair *p, const collided_certificate *claim, vec n)
{
    if (!is_finite_point(claim->point_a) || !is_finite_point(claim->point_b)) return COLLIDED_REJECTED;
    vec a = vec_of(claim->point_a), b = vec_of(claim->point_b);
    real slack = SLACK * (p->reach + length(p->a.body) + length(p->b.body) + length(a) + length(b));
    real deviation_a, deviation_b;
    if (!(slack < INFINITY) || !placed_holds(&p->a, a, n, slack, &deviation_a) ||
        !placed_holds(&p->b, b, scale(-1, n), slack, &deviation_b))
        return COLLIDED_REJECTED;
    real apart = length(sub(b, a)), along = dot(n, sub(b, a)), deviation = deviation_a + deviation_b;
    if (claim->hi < 0 && deviation == 0)
        return along <= claim->hi + width(claim) + SHORT_OF_DEEPEST * p->reach + slack ? COLLIDED_OK : unproven(p);
    real nearest = deviation > 0 && along < 0 && points_overlap(p, a, b, n, slack) ? 0 : apart;
    return nearest + deviation <= claim->hi + slack && apart >= claim->lo - slack ? COLLIDED_OK : COLLIDED_REJECTED;
}

static collided_status judge_axis(const pair *p, const collided_certificate *claim)
{
    bool bounded_below = claim->lo > -INFINITY;
    if (!bounded_below && claim->hi >= 0) return COLLIDED_OK;
    if (!p->has_axis) return COLLIDED_REJECTED;
    real slack = SLACK * (p->reach + length(p->between));
    real gap = separation(p, p->axis);
    if (!(slack < INFINITY) || !(gap <= claim->hi + slack)) return COLLIDED_REJECTED;
    return bounded_below && !(gap >= claim->lo - slack) ? unproven(p) : COLLIDED_OK;
}

static collided_status judge(const pair *p, const collided_certificate *claim)
{
    if (!(claim->lo <= claim->hi)) return COLLIDED_REJECTED; /* NaN, too */
    if (claim->lo == INFINITY || claim->hi == -INFINITY) return COLLIDED_REJECTED;
    collided_status below = judge_axis(p, claim);
    if (below == COLLIDED_REJECTED || claim->hi == INFINITY) return below;
    collided_status above = judge_points(p, claim, p->axis);
    return above == COLLIDED_OK ? below : above;
}

static collided_status verify(const collided_shape *a, const collided_pose *pose_a, hull_points hull_a,
    const collided_shape *b, const collided_pose *pose_b, hull_points hull_b, const collided_certificate *claim)
{
    pair p;
    if (!placed_make(&p.a, a, pose_a, hull_a) || !placed_make(&p.b, b, pose_b, hull_b)) return COLLIDED_BAD_ARGUMENT;
    p.has_axis = proper_axis(&p, claim->axis, &p.axis);
    if (!p.has_axis) p.axis = (vec){0, 0, 0};
    if (!placed_look(&p.a, p.axis) || !placed_look(&p.b, scale(-1, p.axis))) return COLLIDED_BAD_ARGUMENT;
    p.between = sub(p.b.body, p.a.body);
    p.reach = placed_reach(&p.a) + placed_reach(&p.b);
    return judge(&p, claim);
}

collided_status collided_verify(const collided_shape *a, const collided_pose *pose_a, const double *hull_a,
    size_t hull_a_count, const collided_shape *b, const collided_pose *pose_b, const double *hull_b,
    size_t hull_b_count, const collided_certificate *claim)
{
    return verify(a, pose_a, (hull_points){hull_a, hull_a_count, NULL}, b, pose_b,
        (hull_points){hull_b, hull_b_count, NULL}, claim);
}

static hull_points points_of(const collided_prepared_hull *h)
{
    return h ? (hull_points){h->points, h->count, h} : (hull_points){NULL, 0, NULL};
}

collided_status collided_verify_prepared(const collided_shape *a, const collided_pose *pose_a,
    const collided_prepared_hull *hull_a, const collided_shape *b, const collided_pose *pose_b,
    const collided_prepared_hull *hull_b, const collided_certificate *claim)
{
    return verify(a, pose_a, points_of(hull_a), b, pose_b, points_of(hull_b), claim);
}
