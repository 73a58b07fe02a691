/* unit_pair: normalisation of two shapes to unit size, their support points, and the bound of the rounding in them.
 *
 * Pure; any thread. The scale is a power of two, so every bit of an answer but the exponent is independent of it. */
#include "unit_pair.h"

#include "geom/support.h"

/* A separation is dot(n, b - a): the pose may be off by 9 u of position and rotation (product of two rounded unit
 * quaternions, and the matrix made of it), a support point by 4 u, difference, product and sum by 3 u. */
#define ERROR_ULPS 16

/* Keeps the scale and its inverse finite and normal. */
enum { EXPONENT_MAX = 1000 };

static double finite_or_zero(double x)
{
    return isfinite(x) ? x : 0;
}

static shape shape_scaled(const shape *s, double scale)
{
    shape out = *s;
    out.radius = s->radius * scale;
    out.half = vec_scale(s->half, scale);
    return out;
}

/* A core that is a smaller kind in disguise becomes that kind: fewer cases later, and closed forms for more of them. */
static void reduce(shape *s)
{
    if (s->type == SHAPE_ELLIPSOID && s->half.x == s->half.y && s->half.y == s->half.z) {
        s->radius += s->half.x;
        s->type = SHAPE_SPHERE;
    }
    if ((s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE) && s->half.x == 0) s->type = SHAPE_CAPSULE;
    if (s->type == SHAPE_CAPSULE && s->half.z == 0) s->type = SHAPE_SPHERE;
}

void unit_pair_init(unit_pair *p, const shape *a, const shape *b, const pose *b_in_a)
{
    double reach_a = finite_or_zero(shape_reach(a)), reach_b = finite_or_zero(shape_reach(b));
    double largest = fmax(fmax(reach_a, reach_b), vec_max_abs(b_in_a->p));
    int exponent = 0;
    if (largest > 0) (void)frexp(largest, &exponent);
    exponent = exponent < -EXPONENT_MAX ? -EXPONENT_MAX : exponent > EXPONENT_MAX ? EXPONENT_MAX : exponent;
    p->unit = ldexp(1, exponent);
    p->scale = ldexp(1, -exponent);
    p->a = shape_scaled(a, p->scale);
    p->b = shape_scaled(b, p->scale);
    reduce(&p->a);
    reduce(&p->b);
    p->b_in_a.r = quat_matrix(b_in_a->q);
    p->b_in_a.t = vec_scale(b_in_a->p, p->scale);
    p->radius = p->a.radius + p->b.radius;
    p->size = reach_a * p->scale + reach_b * p->scale + vec_norm(p->b_in_a.t);
    p->error = ERROR_ULPS * UNIT_ROUNDOFF * p->size;
    p->excess = (shape_excess(a) + shape_excess(b)) * p->scale;
}

static vec3 support(const unit_pair *p, const shape *s, vec3 direction, uint32_t *hint)
{
    vec3 x = support_core(s, direction, hint);
    return s->type == SHAPE_HULL ? vec_scale(x, p->scale) : x;
}

vec3 unit_pair_support_a(const unit_pair *p, vec3 direction, uint32_t *hint)
{
    return support(p, &p->a, direction, hint);
}

vec3 unit_pair_support_b(const unit_pair *p, vec3 direction, uint32_t *hint)
{
    return transform_point(&p->b_in_a, support(p, &p->b, mat_tmul(p->b_in_a.r, direction), hint));
}

minkowski unit_pair_nearest_along(const unit_pair *p, vec3 axis)
{
    minkowski m;
    m.a = unit_pair_support_a(p, axis, NULL);
    m.b_local = support(p, &p->b, mat_tmul(p->b_in_a.r, vec_neg(axis)), NULL);
    m.b = transform_point(&p->b_in_a, m.b_local);
    m.w = vec_sub(m.b, m.a);
    return m;
}

vec3 vec_unit_orthogonal(vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    vec3 least = x <= y && x <= z ? vec(1, 0, 0) : y <= z ? vec(0, 1, 0) : vec(0, 0, 1);
    return vec_unit(vec_cross(v, least));
}
