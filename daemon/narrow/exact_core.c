/* exact_core: formulas for the cores in double-double. Pure; any thread. */
#include "exact_core.h"

#include "geom/hull.h"
#include "scalar.h"

/* Relative to the largest coordinate: vertices this close to the highest in doubles may be the highest. */
#define VERTEX_SLACK 0x1p-48

static vec3 half_of(const shape *s)
{
    if (s->type == SHAPE_SPHERE) return VEC_ZERO;
    return s->type == SHAPE_CAPSULE ? vec(0, 0, s->half.z) : s->half;
}

static dd times(double a, dd b)
{
    return dd_mul_double(b, a);
}

static dd length2(dd x, dd y)
{
    return dd_sqrt(dd_add(dd_mul(x, x), dd_mul(y, y)));
}

static dd hull_height(const hull *h, double scale, dd3 n)
{
    vec3 rough = dd3_round(n);
    double best = -INFINITY, slack = VERTEX_SLACK * h->max_abs * vec_norm(rough);
    for (uint32_t i = 0; i < h->vertex_count; i++) best = max_of(best, vec_dot(rough, hull_vertex(h, i)));
    dd top = dd_of(-INFINITY);
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        vec3 v = hull_vertex(h, i);
        if (vec_dot(rough, v) >= best - slack) top = dd_max(top, dd3_dot(n, dd3_of(vec_scale(v, scale))));
    }
    return top;
}

static dd ellipsoid_height(vec3 half, dd3 n)
{
    dd3 stretched = {times(half.x, n.x), times(half.y, n.y), times(half.z, n.z)};
    return dd3_norm(stretched);
}

dd exact_height(const shape *s, double scale, dd3 n)
{
    vec3 h = half_of(s);
    dd along = times(h.z, dd_abs(n.z));
    switch (s->type) {
    case SHAPE_CYLINDER:
        return dd_add(times(h.x, length2(n.x, n.y)), along);
    case SHAPE_CONE:
        return dd_max(times(h.z, n.z), dd_sub(times(h.x, length2(n.x, n.y)), times(h.z, n.z)));
    case SHAPE_ELLIPSOID:
        return ellipsoid_height(h, n);
    case SHAPE_HULL:
        return hull_height(s->hull, scale, n);
    default:
        return dd_add(dd_add(times(h.x, dd_abs(n.x)), times(h.y, dd_abs(n.y))), along);
    }
}

static dd clamp(dd x, double h)
{
    return dd_max(dd_min(x, dd_of(h)), dd_of(-h));
}

dd3 exact_clamp(const shape *s, dd3 point)
{
    vec3 h = half_of(s);
    return (dd3){clamp(point.x, h.x), clamp(point.y, h.y), clamp(point.z, h.z)};
}

/* From a box (a rectangle, without z) whose sides the point passes by so much: negative inside. */
static dd passed(dd x, dd y, dd z)
{
    dd most = dd_max(dd_max(x, y), z), zero = dd_of(0);
    if (!dd_less(zero, most)) return most;
    dd3 outside = {dd_max(x, zero), dd_max(y, zero), dd_max(z, zero)};
    return dd3_norm(outside);
}

/* In the half-plane (rho, z): the side runs from the apex (0, h) to the rim (r, -h), `length` long. */
static dd cone_distance(double r, double h, dd rho, dd z)
{
    dd below_apex = dd_sub(dd_of(h), z), length = length2(dd_of(r), dd_of(2 * h));
    dd off_side = dd_div(dd_sub(times(2 * h, rho), times(r, below_apex)), length);
    dd down_side = dd_div(dd_add(times(r, rho), times(2 * h, below_apex)), length);
    dd below_base = dd_sub(dd_of(-h), z);
    if (off_side.hi <= 0 && below_base.hi <= 0) return dd_max(off_side, below_base);
    if (off_side.hi > 0 && down_side.hi <= 0) return length2(rho, below_apex);
    if (off_side.hi > 0 && dd_less(down_side, length)) return off_side;
    return dd_less(rho, dd_of(r)) ? below_base : length2(dd_sub(rho, dd_of(r)), below_base);
}

bool exact_has_distance(const shape *s)
{
    return s->type <= SHAPE_CONE;
}

dd exact_distance(const shape *s, dd3 point)
{
    vec3 h = half_of(s);
    dd z = dd_sub(dd_abs(point.z), dd_of(h.z));
    if (s->type == SHAPE_CONE) return cone_distance(h.x, h.z, length2(point.x, point.y), point.z);
    if (s->type == SHAPE_CYLINDER) return passed(dd_sub(length2(point.x, point.y), dd_of(h.x)), dd_of(-INFINITY), z);
    return passed(dd_sub(dd_abs(point.x), dd_of(h.x)), dd_sub(dd_abs(point.y), dd_of(h.y)), z);
}
