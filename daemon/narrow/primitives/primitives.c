/* primitives: the formulas of spheres and capsules, and which pair of types has which. Pure; any thread. */
#include "primitives.h"

#include "primitive_pair.h"

/* ---- spheres ----
 *
 * A sphere's centre is all of its core: the line from there to the nearest point of the other core is the axis.
 *
 * Rounding, in u = 2^-53. Two spheres: the distance by 3.5 u, the axis by 7 u of its length: less than the 16 u of
 * unit_error. A sphere and a box, with r the sphere's radius, g the half diagonal of the box, e the gap between the
 * centre and the box, |t| <= e + g; a matrix R is off by less than 6.5 u (test_primitive_boxes), a product with it by
 * 3.7 u.
 *   hi: t by 1 u, R't by 10.2, v by e, |v| by 2.5 e, set_bounds by 2 e + 2 r: less than 17 e + 12 g + 2 r.
 *   lo, along n = R v / e: n is off by 5.7 by the product and two roundings, so that n.t is off by 9.4 |t| from v.R't /
 *     e, t itself by 1 u, the box's height by 6.5 g + 5.7 g; v.R't less the height of v is v^2 but for a rounding, and
 *     over e 6 e; set_bounds by 2 e + 2 r; n is longer than 1 by less than 16 u, times r; made 1, its length takes
 *     another 10 e: less than 28 e + 24 g + 18 r.
 *   The centre in the box: R't by 11.2 g, its height and sum by 3 g; along a column of R the product by 4.7 g, the
 *     height by 6.5 g, and its length, made 1, by 6.5 g: less than 24 g + 9 r.
 * The error is 28 e + 24 (g + r). */

/* `distance` is that of the centre from the other core, along `axis`. */
INLINE bool end_of_sphere(const primitive_pair *q, const unit_pair *p, double distance, vec3 axis, narrow_result *out)
{
    const span s = {.lo = distance, .hi = distance, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    set_bounds(p, &s, out);
    out->axis = axis;
    out->point_a = vec_scale(axis, p->a.radius * p->unit);
    out->point_b = vec_scale(axis, (distance - p->b.radius) * p->unit);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

/* 1 / distance: the quotient and the root are found side by side. */
INLINE double inverse_of(double norm2, double distance)
{
    return distance * (1 / norm2);
}

/* Centres that (nearly) coincide have no line. */
INLINE bool two_spheres(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    vec3 t = p.b_in_a.t;
    double norm2 = vec_norm2(t), distance = sqrt(norm2);
    if (!is_noticed(q, norm2)) return false;
    if (norm2 > GREATEST_EVERYDAY) {
        q->outside = q->everyday;
        return false;
    }
    p.error = unit_error(p.radius + distance);
    return end_of_sphere(q, &p, distance, vec_scale(t, inverse_of(norm2, distance)), out);
}

/* From the point in a box to its nearest face, ties in the order of the axes; `at`: the box seen from the point, along
 * the box's axes; `beyond`: |at| less the half sides. */
INLINE double through_face(const mat3 *turn, vec3 at, vec3 beyond, vec3 *axis)
{
    double most = beyond.x, side = at.x;
    const vec3 *face = &turn->x;
    if (beyond.y > most) most = beyond.y, side = at.y, face = &turn->y;
    if (beyond.z > most) most = beyond.z, side = at.z, face = &turn->z;
    *axis = vec_scale(*face, side <= 0 ? -1 : 1);
    return most;
}

INLINE double outer(double beyond, double at)
{
    return copysign(max_of(beyond, 0), at);
}

/* The error does not wait for the root, nor does the range. */
INLINE bool sphere_beside_box(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    vec3 at = mat_tmul(q->turn_b, p.b_in_a.t), half = vec_scale(q->b->half, p.scale);
    vec3 beyond = vec(fabs(at.x) - half.x, fabs(at.y) - half.y, fabs(at.z) - half.z);
    vec3 v = vec(outer(beyond.x, at.x), outer(beyond.y, at.y), outer(beyond.z, at.z));
    double norm2 = vec_norm2(v), distance = sqrt(norm2);
    p.size = p.a.radius + q->reach_b * p.scale;
    if (!is_everyday(q, p.size, norm2)) return false;
    p.error = unit_error(1.5) * p.size + unit_error(1.75) * distance;
    if (__builtin_expect(is_noticed(q, norm2), true))
        return end_of_sphere(q, &p, distance, vec_scale(mat_mul(q->turn_b, v), inverse_of(norm2, distance)), out);
    vec3 axis;
    distance = through_face(&q->turn_b, at, beyond, &axis);
    if (distance > 0) return false; /* outside, and lost */
    q->outside = false;
    return end_of_sphere(q, &p, distance, axis, out);
}

INLINE bool sphere_beside_capsule(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    span s;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    p.b_in_a.r.z = q->turn_b.z;
    p.b.half.z = q->b->half.z * p.scale;
    formula_sphere_capsule(&p, &s);
    vec3 towards = s.hi > p.radius ? vec_scale(s.point_b, 1 / s.hi) : s.axis;
    q->outside = q->everyday && !(s.hi > NOTICEABLE);
    return !q->outside && end(q, &p, &s, towards, out);
}

/* ---- two capsules ---- */

/* Two segments: p_a(s) = s a, p_b(s) = t + s b, with unit a and b, and |s| <= h. See formulas.h, of which this is the
 * one case of two that are not parallel, where they are not in A's frame. */
typedef struct lines {
    vec3 a, b, t;
    double ha, hb;
} lines;

INLINE double apart_along(const lines *g, vec3 axis)
{
    return vec_dot(axis, g->t) - fabs(vec_dot(axis, g->a)) * g->ha - fabs(vec_dot(axis, g->b)) * g->hb;
}

/* The nearest points of the two lines, the one on B moved into its segment, and the point of A's that is nearest to
 * that. */
INLINE void nearest_of_lines(const lines *g, vec3 across, double *s_a, double *s_b)
{
    double ab = vec_dot(g->a, g->b), at = vec_dot(g->a, g->t), bt = vec_dot(g->b, g->t);
    *s_a = clamp_to((at - ab * bt) / vec_norm2(across), g->ha), *s_b = *s_a * ab - bt;
    if (fabs(*s_b) > g->hb) {
        *s_b = clamp_to(*s_b, g->hb);
        *s_a = clamp_to(at + *s_b * ab, g->ha);
    }
}

/* Where rounding keeps the line between the points from proving their distance, for it is short: across both segments,
 * across the one whose end has no part in it, or from end to end. Zero where nothing is left of that: where one ends on
 * the other's line, or they are parallel. */
INLINE vec3 sharper_axis(const lines *g, vec3 across, double s_a, double s_b, vec3 v)
{
    bool inner_a = fabs(s_a) < g->ha, inner_b = fabs(s_b) < g->hb;
    if (inner_a && inner_b) return direction_of(vec_dot(across, v) < 0 ? vec_neg(across) : across);
    return direction_of(inner_a ? orthogonal_part(v, g->a) : inner_b ? orthogonal_part(v, g->b) : v);
}

/* Nearly parallel ones are not proven by any of these, and go another way.
 *
 * Rounding, in u = 2^-53, with h the sum of the half lengths, r that of the radii, e the gap of the cores, |t| <= e +
 * h. A direction is off by less than 6.5 u (test_primitive_boxes). hi: each point by 7.5 u of its place on the segment,
 * B's by the sum and by t, 2 |t| + h; |v| by 3.5 e, set_bounds by 2 e + 2 r: less than 8 e + 11 h + 2 r. lo: n.t by 4
 * |t|, the segments' heights by 9.5 h, two sums by 2 |t| + 2 h; set_bounds by 2 e + 2 r; the length of n, made 1,
 * by 5.5 e + 5.5 r: less than 14 e + 18 h + 8 r. The error is 16 e + 20 h + 20 r. */
INLINE bool two_capsules(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    span s = {.method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    begin(q, &p);
    const lines g = {q->along_a, q->turn_b.z, p.b_in_a.t, q->a->half.z * p.scale, q->b->half.z * p.scale};
    vec3 across = vec_cross(g.a, g.b);
    double s_a, s_b;
    nearest_of_lines(&g, across, &s_a, &s_b);
    s.point_a = vec_scale(g.a, s_a);
    s.point_b = vec_madd(g.t, s_b, g.b);
    vec3 v = vec_sub(s.point_b, s.point_a);
    double norm2 = vec_norm2(v);
    s.hi = sqrt(norm2);
    p.size = (q->reach_a + q->reach_b) * p.scale;
    if (!is_everyday(q, p.size, norm2) || !is_noticed(q, norm2)) return false;
    p.error = unit_error(1.25) * p.size + unit_error(1) * s.hi;
    double per = inverse_of(norm2, s.hi); /* what is along v is found beside it, too */
    vec3 towards = s.axis = vec_scale(v, per);
    s.lo = apart_along(&g, v) * per;
    if (!(s.hi - s.lo <= 0.25 * p.error)) {
        s.axis = sharper_axis(&g, across, s_a, s_b, v);
        s.lo = apart_along(&g, s.axis);
        if (!(s.hi - s.lo <= 0.25 * p.error) || !(vec_norm2(s.axis) > 0)) return false;
        if (s.hi <= p.radius) towards = s.axis;
    }
    return end(q, &p, &s, towards, out);
}

/* ---- which pair has which ---- */

/* Shapes that stand for something else have no formula. */
enum { SHAPE_TYPES = SHAPE_ELLIPSOID + 1 };
#define PAIR_OF(a, b) ((unsigned)(a)*SHAPE_TYPES + (unsigned)(b))

INLINE bool by_formula(unsigned types, primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    switch (types) {
    case PAIR_OF(SHAPE_SPHERE, SHAPE_SPHERE):
        return two_spheres(q, out);
    case PAIR_OF(SHAPE_SPHERE, SHAPE_CAPSULE):
        return sphere_beside_capsule(q, out);
    case PAIR_OF(SHAPE_SPHERE, SHAPE_BOX):
        return sphere_beside_box(q, out);
    case PAIR_OF(SHAPE_CAPSULE, SHAPE_CAPSULE):
        return two_capsules(q, out);
    case PAIR_OF(SHAPE_CAPSULE, SHAPE_BOX):
        return capsule_beside_box(q, out);
    case PAIR_OF(SHAPE_BOX, SHAPE_BOX):
        return box_beside_box(q, cache, scratch, out);
    case PAIR_OF(SHAPE_ELLIPSOID, SHAPE_ELLIPSOID):
        return ellipsoids_by_verdict(q, out);
    default:
        return false;
    }
}

__attribute__((noinline, cold)) static bool by_formula_at_unit_size(
    unsigned types, const primitive_pair *x, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    primitive_pair q = *x;
    q.everyday = q.outside = false;
    return by_formula(types, &q, cache, scratch, out);
}

INLINE double reach_of_primitive(const shape *s)
{
    return s->type == SHAPE_SPHERE ? s->radius : shape_reach(s);
}

/* *q holds where they stand. */
INLINE bool by_formula_at_any_size(unsigned types, const shape *a, const shape *b, const narrow_request *request,
    primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    q->a = a, q->b = b, q->request = request;
    q->reach_a = reach_of_primitive(a), q->reach_b = reach_of_primitive(b);
    q->everyday = true, q->outside = false;
    if (by_formula(types, q, cache, scratch, out)) return true;
    return q->outside && by_formula_at_unit_size(types, q, cache, scratch, out);
}

bool primitives_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, epa_scratch *scratch, narrow_result *result)
{
    enum { TWO_SPHERES = PAIR_OF(SHAPE_SPHERE, SHAPE_SPHERE) };
    primitive_pair q;
    unsigned types = PAIR_OF(a->type, b->type);
    if (a->deviation > 0 || b->deviation > 0) return false;
    q.between = b_in_a->p;
    if (types == TWO_SPHERES) return by_formula_at_any_size(TWO_SPHERES, a, b, request, &q, cache, scratch, result);
    q.along_a = vec(0, 0, 1);
    q.turn_b = quat_matrix(b_in_a->q);
    return by_formula_at_any_size(types, a, b, request, &q, cache, scratch, result);
}

bool primitives_answer_in_world(const shape *a, const pose *at_a, const shape *b, const pose *at_b,
    const narrow_request *request, narrow_result *result)
{
    primitive_pair q;
    if (b->type > SHAPE_BOX || a->type == SHAPE_BOX || a->deviation > 0 || b->deviation > 0) return false;
    q.between = vec_sub(at_b->p, at_a->p);
    q.along_a = quat_matrix(at_a->q).z;
    q.turn_b = quat_matrix(at_b->q);
    return by_formula_at_any_size(PAIR_OF(a->type, b->type), a, b, request, &q, NULL, NULL, result);
}
