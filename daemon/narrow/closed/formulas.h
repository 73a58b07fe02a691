/* formulas: the closed forms of balls, segments and boxes, inlined: for closed.c, which the general method asks, and
 * for primitives.c, which does without that. Lengths between cores, in a unit_pair's units and A's frame. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_CLOSED_FORMULAS_H
#define COLLIDED_NARROW_CLOSED_FORMULAS_H

#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

/* The same number proves both bounds. */
static inline bool exact(span *out, double distance, vec3 axis, vec3 point_a, vec3 point_b)
{
    *out = (span){.lo = distance,
        .hi = distance,
        .axis = axis,
        .point_a = point_a,
        .point_b = point_b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = 1};
    return true;
}

/* v without its part along the unit vector u; twice, because the first pass leaves what cancelled. Zero where v lies
 * along u but for rounding: what is left then points anywhere, along u where the length of u is not quite 1. */
static inline vec3 orthogonal_part(vec3 v, vec3 u)
{
    vec3 n = vec_madd(v, -vec_dot(v, u), u);
    n = vec_madd(n, -vec_dot(n, u), u);
    return vec_norm2(n) > 0x1p-60 * vec_norm2(v) ? n : VEC_ZERO;
}

static inline vec3 unit_or(vec3 v, vec3 otherwise)
{
    vec3 n = direction_of(v);
    return vec_norm2(n) > 0 ? n : otherwise;
}

/* Where v is zero, some direction orthogonal to u. */
static inline vec3 unit_or_across(vec3 v, vec3 u)
{
    vec3 n = direction_of(v);
    return vec_norm2(n) > 0 ? n : vec_unit_orthogonal(u);
}

static inline bool formula_sphere_sphere(const unit_pair *p, span *out)
{
    vec3 t = p->b_in_a.t;
    return exact(out, vec_norm(t), unit_or(t, vec(1, 0, 0)), VEC_ZERO, t);
}

/* The ball is level with the segment, or at its end but for rounding. */
static inline bool formula_sphere_capsule(const unit_pair *p, span *out)
{
    vec3 u = p->b_in_a.r.z, t = p->b_in_a.t;
    double h = p->b.half.z, s = clamp_to(-vec_dot(t, u), h);
    vec3 v = vec_madd(t, s, u);
    bool level = fabs(s) < h || s * vec_dot(v, u) > 0;
    vec3 n = level ? orthogonal_part(v, u) : v;
    return exact(out, vec_norm(v), unit_or_across(n, u), VEC_ZERO, v);
}

/* Two segments: p_a(s) = s z, p_b(s) = t + s b, with unit z = (0, 0, 1) and b, and |s| <= h; and what the lines on
 * which they lie say of the products of z, b and t. */
typedef struct segments {
    vec3 b, t;
    double ha, hb;
    double ab, at, bt, sine2; /* sine2: of the angle between them */
} segments;

static inline segments segments_of(const unit_pair *p)
{
    vec3 b = p->b_in_a.r.z, t = p->b_in_a.t;
    return (segments){b, t, p->a.half.z, p->b.half.z, b.z, t.z, vec_dot(b, t), b.x * b.x + b.y * b.y};
}

/* The two points at (s_a, s_b), and the axis that they suggest: across both lines, across the one whose end has no part
 * in it, or along the line between two ends. */
static inline void take_points(const segments *g, double s_a, double s_b, span *out)
{
    vec3 point_b = vec_madd(g->t, s_b, g->b), v = vec(point_b.x, point_b.y, point_b.z - s_a), n = v;
    bool inner_a = fabs(s_a) < g->ha, inner_b = fabs(s_b) < g->hb;
    if (inner_a && inner_b && g->sine2 > 0) {
        double side = g->b.x * v.y - g->b.y * v.x < 0 ? -1 : 1;
        n = vec(-side * g->b.y, side * g->b.x, 0);
    } else if (inner_a) {
        n.z = 0;
    } else if (inner_b) {
        n = orthogonal_part(v, g->b);
    }
    out->hi = vec_norm(v);
    out->axis = unit_or(n, vec(0, 1, 0));
    out->point_a = vec(0, 0, s_a);
    out->point_b = point_b;
}

/* Of the two segments along a unit axis from A towards B: by their ends. */
static inline double separation(const segments *g, vec3 axis)
{
    return vec_dot(axis, g->t) - fabs(axis.z) * g->ha - fabs(vec_dot(axis, g->b)) * g->hb;
}

/* The nearest points of the two lines, the one on B moved into its segment, and the point of A's that is nearest to
 * that: right, but where rounding blurs the angle between the two. */
static inline void nearest_on_lines(const segments *g, span *out)
{
    double s_a = g->sine2 > 0 ? clamp_to((g->at - g->ab * g->bt) / g->sine2, g->ha) : 0, s_b = s_a * g->ab - g->bt;
    if (fabs(s_b) > g->hb) {
        s_b = clamp_to(s_b, g->hb);
        s_a = clamp_to(g->at + s_b * g->ab, g->ha);
    }
    take_points(g, s_a, s_b, out);
    out->iterations = 1;
}

/* True when the two bounds differ by rounding only, as they do for all but nearly parallel segments. */
static inline bool formula_capsule_capsule(const unit_pair *p, const segments *g, span *out)
{
    out->method = NARROW_BY_CLOSED_FORM;
    nearest_on_lines(g, out);
    out->lo = separation(g, out->axis);
    return out->hi - out->lo <= 0.25 * p->error;
}

static inline double *component(vec3 *v, int i)
{
    return i == 0 ? &v->x : i == 1 ? &v->y : &v->z;
}

/* The face through which a point inside the box leaves soonest; ties: x before y before z. */
static inline int nearest_face(vec3 c, vec3 half, double *depth)
{
    double room[3] = {half.x - fabs(c.x), half.y - fabs(c.y), half.z - fabs(c.z)};
    int least = room[1] < room[0] ? 1 : 0;
    if (room[2] < room[least]) least = 2;
    *depth = room[least];
    return least;
}

static inline bool formula_sphere_box(const unit_pair *p, span *out)
{
    const transform *box = &p->b_in_a;
    vec3 h = p->b.half, c = vec_neg(mat_tmul(box->r, box->t)); /* the point, in the box's frame */
    vec3 q = vec(clamp_to(c.x, h.x), clamp_to(c.y, h.y), clamp_to(c.z, h.z)), v = vec_sub(q, c);
    double distance = vec_norm(v);
    vec3 axis = direction_of(v);
    if (!(distance > 0)) { /* inside; or outside by what has no square, and then v is no axis of what follows */
        axis = VEC_ZERO;
        int i = nearest_face(c, h, &distance);
        double side = *component(&c, i) >= 0 ? 1 : -1;
        *component(&q, i) = side * *component(&h, i);
        *component(&axis, i) = -side;
        distance = -distance;
    }
    vec3 axis_in_a = mat_mul(box->r, axis);
    return exact(out, distance, axis_in_a, VEC_ZERO, vec_scale(axis_in_a, distance));
}

#endif
