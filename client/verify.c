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
 * Rounding is allowed for by SLACK unit roundoffs of a double times the sizes that entered: the shapes' reaches and the
 * exact distance of the bodies for lo; for points, which are world coordinates, the bodies' positions too. */
#include "collided.h"
#include "verify_shape.h"

#include <math.h>

#define SLACK (64 * 0x1p-53L)
static const real unit_tolerance = 1e-9L; /* of the axis' length, and of its agreement with a half-space's normal */

typedef struct pair {
    placed a, b;
    vec between; /* from A's body to B's */
    real reach;
} pair;

static bool is_halfspace(const placed *p)
{
    return p->shape->type == COLLIDED_HALFSPACE;
}

/* The claimed axis made exactly unit; beside a half-space, which reaches infinitely far along all directions but one,
 * its normal. False if it is not a proper axis. */
static bool proper_axis(const pair *p, const double claimed[3], vec *n)
{
    *n = vec_of(claimed);
    real norm = length(*n);
    if (!(fabsl(norm - 1) <= unit_tolerance)) return false;
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

static bool all_finite(const double v[3])
{
    return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}

/* The points belong to the shapes and are near enough to each other, or deep enough in each other. */
static bool points_prove(const pair *p, const collided_certificate *claim, vec n)
{
    if (!all_finite(claim->point_a) || !all_finite(claim->point_b)) return false;
    vec a = vec_of(claim->point_a), b = vec_of(claim->point_b);
    real slack = SLACK * (p->reach + length(p->a.body) + length(p->b.body) + length(a) + length(b));
    if (!(placed_distance(&p->a, a) <= slack) || !(placed_distance(&p->b, b) <= slack)) return false;
    real deviation = (real)p->a.shape->deviation + p->b.shape->deviation, along = dot(n, sub(b, a));
    if (deviation > 0) return (along < 0 ? 0 : length(sub(b, a))) + deviation <= claim->hi + slack;
    if (claim->hi >= 0) return length(sub(b, a)) <= claim->hi + slack;
    return along <= claim->hi + slack;
}

static bool is_proven(const pair *p, const collided_certificate *claim)
{
    if (!(claim->lo <= claim->hi)) return false; /* NaN, too */
    if (claim->lo == INFINITY || claim->hi == -INFINITY) return false;
    bool bounded_below = claim->lo > -INFINITY;
    vec n = {0, 0, 0};
    if (bounded_below || claim->hi < 0) {
        if (!proper_axis(p, claim->axis, &n)) return false;
        real slack = SLACK * (p->reach + length(p->between));
        real gap = separation(p, n);
        if (bounded_below && !(gap >= claim->lo - slack)) return false;
        if (!(gap <= claim->hi + slack)) return false;
    }
    return claim->hi == INFINITY || points_prove(p, claim, n);
}

collided_status collided_verify(const collided_shape *a, const collided_pose *pose_a, const double *hull_a,
    size_t hull_a_count, const collided_shape *b, const collided_pose *pose_b, const double *hull_b,
    size_t hull_b_count, const collided_certificate *claim)
{
    pair p;
    if (!placed_make(&p.a, a, pose_a, hull_a, hull_a_count) || !placed_make(&p.b, b, pose_b, hull_b, hull_b_count))
        return COLLIDED_BAD_ARGUMENT;
    p.between = sub(p.b.body, p.a.body);
    p.reach = placed_reach(&p.a) + placed_reach(&p.b);
    return is_proven(&p, claim) ? COLLIDED_OK : COLLIDED_REJECTED;
}
