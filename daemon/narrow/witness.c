/* witness: deepest points of overlapping cores. A depth search proves an axis by support points, but the points that
 * it interpolates may belong to an older facet, or to another of several equally deep ones. Pure; any thread. */
#include "witness.h"

#include "gjk.h"
#include "scalar.h"

void witness_apart(const unit_pair *p, span *s)
{
    unit_pair apart = *p;
    vec3 shift = vec_scale(s->axis, -s->lo);
    apart.b_in_a.t = vec_add(p->b_in_a.t, shift);
    double closely = 0.25 * (s->hi - s->lo);
    narrow_goal exactly = {closely, closely, INFINITY, -INFINITY, INFINITY, INFINITY};
    gjk_result touch;
    gjk_distance(&apart, &exactly, s->axis, &touch);
    s->point_a = touch.span.point_a;
    s->point_b = vec_sub(touch.span.point_b, shift);
    s->iterations += touch.span.iterations;
}

/* How far the two points together fall short of the support planes, of which `top` holds a point each. */
static double shortfall(const span *s, const minkowski *top)
{
    return max_of(vec_dot(s->axis, vec_sub(top->a, s->point_a)), vec_dot(s->axis, vec_sub(s->point_b, top->b)));
}

void witness_deepest(const unit_pair *p, span *s)
{
    minkowski top = unit_pair_nearest_along(p, s->axis);
    double slack = (s->hi - s->lo) + p->error;
    if (shortfall(s, &top) <= slack) return;
    witness_apart(p, s);
    if (shortfall(s, &top) <= slack) return;
    s->point_a = top.a;
    s->point_b = top.b;
}
