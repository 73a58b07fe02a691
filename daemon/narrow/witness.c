/* witness: deepest points of overlapping cores. A depth search proves an axis by support points, but the points that
 * it interpolates may belong to an older facet, or to another of several equally deep ones. Pure; any thread. */
#include "witness.h"

#include "facing.h"
#include "gjk.h"
#include "scalar.h"

static void apart_by(const unit_pair *p, double way, span *s)
{
    unit_pair apart = *p;
    vec3 shift = vec_scale(s->axis, way);
    apart.b_in_a.t = vec_add(p->b_in_a.t, shift);
    double closely = 0.25 * (s->hi - s->lo);
    narrow_goal exactly = {closely, closely, INFINITY, -INFINITY, INFINITY, INFINITY, false};
    gjk_result touch;
    gjk_distance(&apart, &exactly, s->axis, &touch);
    s->point_a = touch.span.point_a;
    s->point_b = vec_sub(touch.span.point_b, shift);
    s->iterations += touch.span.iterations;
}

void witness_apart(const unit_pair *p, span *s)
{
    apart_by(p, -s->lo, s);
}

/* How far the two points together fall short of the support planes, of which `top` holds a point each. */
static double shortfall(const span *s, const minkowski *top)
{
    return max_of(vec_dot(s->axis, vec_sub(top->a, s->point_a)), vec_dot(s->axis, vec_sub(s->point_b, top->b)));
}

/* Of the size: how far apart, across the axis, two points that face each other may be. */
#define ASIDE 0x1p-10

/* Of the size: between two curved cores that a search can tell where they are nearest. */
#define ROOM 0x1p-32

static double aside(const span *s)
{
    vec3 line = vec_sub(s->point_b, s->point_a);
    return vec_norm(vec_madd(line, -vec_dot(line, s->axis), s->axis));
}

/* The slack of the points: support planes are known to no better. */
static double slack_of(const unit_pair *p, const span *s)
{
    return (s->hi - s->lo) + p->error;
}

static bool are_deepest(const unit_pair *p, const span *s, const minkowski *top)
{
    return shortfall(s, top) <= slack_of(p, s) && aside(s) <= ASIDE * p->size;
}

static void search_deepest(const unit_pair *p, const minkowski *top, span *s)
{
    double slack = slack_of(p, s);
    witness_apart(p, s);
    if (shortfall(s, top) <= slack) return;
    const double rooms[] = {2 * slack, ROOM * p->size}; /* rounding has them overlap still, or hides where they touch */
    for (int i = 0; i < 2; i++) {
        apart_by(p, rooms[i] - s->lo, s);
        if (shortfall(s, top) <= 2 * rooms[i]) return;
    }
    s->point_a = top->a;
    s->point_b = top->b;
}

void witness_deepest(const unit_pair *p, span *s)
{
    minkowski top = unit_pair_nearest_along(p, s->axis);
    if (are_deepest(p, s, &top)) return;
    if (facing_points(p, slack_of(p, s), s) && are_deepest(p, s, &top)) return;
    search_deepest(p, &top, s);
}

bool witness_facing(const unit_pair *p, const minkowski *top, span *s)
{
    if (facing_points(p, slack_of(p, s), s) && are_deepest(p, s, top)) return true;
    s->point_a = top->a;
    s->point_b = top->b;
    return false;
}
