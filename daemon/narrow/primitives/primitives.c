/* primitives: the formulas of spheres and capsules, and which pair of types has which. Pure; any thread. */
#include "primitives.h"

#include "narrow/math/scalar.h"
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

/* Writes the answer of a sphere whose centre is at `distance` from the other core along `axis`. */
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

/* 1 / distance, written so that the processor works on the quotient and on the root at the same time. */
INLINE double inverse_of(double norm2, double distance)
{
    return distance * (1 / norm2);
}

/* Fails for centres that (nearly) coincide, which have no line between them. */
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

/* The error and the range are computed without waiting for the root. */
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

/* v without its part along the unit vector u; twice, because the first pass leaves what cancelled. Zero where v lies
 * along u but for rounding: what is left then points anywhere, along u where the length of u is not quite 1. */
INLINE vec3 orthogonal_part(vec3 v, vec3 u)
{
    vec3 n = vec_madd(v, -vec_dot(v, u), u);
    n = vec_madd(n, -vec_dot(n, u), u);
    return vec_norm2(n) > 0x1p-60 * vec_norm2(v) ? n : VEC_ZERO;
}

/* The sphere is level with the segment, or beyond an end of it, except for rounding. */
INLINE bool sphere_beside_capsule(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    vec3 u = q->turn_b.z, t = p.b_in_a.t;
    double h = q->b->half.z * p.scale, at = clamp_to(-vec_dot(t, u), h);
    vec3 v = vec_madd(t, at, u);
    bool level = fabs(at) < h || at * vec_dot(v, u) > 0;
    vec3 n = direction_of(level ? orthogonal_part(v, u) : v);
    double distance = vec_norm(v);
    span s = {.lo = distance, .hi = distance, .point_b = v, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    s.axis = vec_norm2(n) > 0 ? n : vec_unit_orthogonal(u);
    vec3 towards = s.hi > p.radius ? vec_scale(s.point_b, 1 / s.hi) : s.axis;
    q->outside = q->everyday && !(s.hi > NOTICEABLE);
    return !q->outside && end(q, &p, &s, towards, out);
}

/* ---- two capsules ---- */

/* Two segments that are not parallel: p_a(s) = s a, p_b(s) = t + s b, with unit a and b, and |s| <= h. */
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

/* Nearly parallel ones are not proven by any of these, and are left to a search.
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
    double per = inverse_of(norm2, s.hi); /* products along v are computed at the same time */
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

/* Shapes that approximate something else (deviation > 0) have no formula. */
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

/* *q has the poses already. */
INLINE bool by_formula_at_any_size(unsigned types, const shape *a, const shape *b, const narrow_request *request,
    primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    q->a = a, q->b = b, q->request = request;
    q->reach_a = reach_of_primitive(a), q->reach_b = reach_of_primitive(b);
    q->everyday = true, q->outside = false;
    if (by_formula(types, q, cache, scratch, out)) return true;
    return q->outside && by_formula_at_unit_size(types, q, cache, scratch, out);
}

INLINE bool may_have_formula(const shape *a, const shape *b, const narrow_request *r)
{
    return b->type <= SHAPE_ELLIPSOID && r->engine == NARROW_ENGINE_AUTO && !(a->deviation > 0 || b->deviation > 0);
}

bool primitives_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, epa_scratch *scratch, narrow_result *result)
{
    enum { TWO_SPHERES = PAIR_OF(SHAPE_SPHERE, SHAPE_SPHERE) };
    primitive_pair q;
    unsigned types = PAIR_OF(a->type, b->type);
    if (!may_have_formula(a, b, request)) return false;
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
    if (b->type > SHAPE_BOX || a->type == SHAPE_BOX || !may_have_formula(a, b, request)) return false;
    q.between = vec_sub(at_b->p, at_a->p);
    q.along_a = quat_matrix(at_a->q).z;
    q.turn_b = quat_matrix(at_b->q);
    return by_formula_at_any_size(PAIR_OF(a->type, b->type), a, b, request, &q, NULL, NULL, result);
}

/* ==== a capsule and a box ==== */

/* The formula of a capsule and a box.
 *
 * The capsule's core is a segment x(s) = c + s d, |s| <= h, seen from the box. The square of its distance from the box
 * is convex in s; its slope, d.beyond with beyond = x - (the box's point nearest to x), is linear between the places
 * where the segment crosses planes of faces. Newton's method ends on the piece where it is zero, or at an end. Along n
 * = -beyond / |beyond| the box has no point farther than that nearest one (n is zero where x is between two faces), the
 * segment is farther by |n.d| (h -+ s) at its end: so |beyond| less that is a lower bound, whatever led to s.
 *
 * A segment in the box: B - A has the faces of B, and those that an edge of B and the segment span; the greatest
 * separation along these six is minus the depth.
 *
 * Rounding, in u = 2^-53. A matrix is off by less than 6.5 u (the most seen in 2 10^7 is 6.15 u; test_primitive_boxes),
 * t by 1 u, its product with a matrix by 3.7 u (1 u of each product, of which a row has 5/3 at most, and 1 u of each
 * sum). With h the half length, g the half diagonal of the box, e <= |t| the gap: hi: c by 6.5 + 4.7 of |t|; d by 13
 * + 3.7, times s, of which |s| <= h, |s| <= |t| + g and, but for g, s^2 + e^2 <= |t|^2; x by |s| + e + g, |beyond|
 * by 3.5 e and set_bounds by 2 e: 11.2 |t| + 17.7 |s| + 6.5 e + g, less than 16 (|t| + h + g) + 2 e. lo, along the
 * matrix times n: the box's height by 6.5 g, the segment's by (6.5 + 3.7) h, t by 4.7 |t|, x by |s| + e
 *     + g, |beyond| by 3.5 e and set_bounds by 2 e, the length of the axis by 6.5 e, |n.d| by 3, times h -+ s: 4.7 |t|
 * + 13 e + 7.5 g + 13.2 h + 4 |s|, less than 16 (|t| + h + g) + 2 e. An overlap: c and d as for hi, times 1 and h, and
 * 3 of each along an axis: 14.2 |t| + 19.7 h + 3 g. The error is 20 of them all there. */

enum { NEWTON_MAX = 6 };

#define PARALLEL2 0x1p-120 /* less than 2^-60 h is lost by it */
#define TOUCHING 0x1p-60   /* sizes: cores that are nearer to each other touch, for all that is known here */

/* The segment in the box's frame, and the box's sides. */
typedef struct beam {
    vec3 c, d, box;
    double half, touching2; /* the latter: the square of a distance that is none */
} beam;

/* A place on the segment: how far it is outside of the box, by coordinates, and the slope of half the square. */
typedef struct beam_place {
    double s, slope;
    vec3 beyond;
} beam_place;

INLINE double beyond_of(double x, double half)
{
    return x - clamp_to(x, half);
}

INLINE beam_place capsule_box_place_at(const beam *g, double s)
{
    vec3 x = vec_madd(g->c, s, g->d);
    vec3 beyond = {beyond_of(x.x, g->box.x), beyond_of(x.y, g->box.y), beyond_of(x.z, g->box.z)};
    return (beam_place){s, vec_dot(g->d, beyond), beyond};
}

/* d, in the coordinates in which the place is outside. */
INLINE vec3 outer_part(const beam *g, vec3 beyond)
{
    return vec(beyond.x != 0 ? g->d.x : 0, beyond.y != 0 ? g->d.y : 0, beyond.z != 0 ? g->d.z : 0);
}

/* By how much the segment is nearer to the box at an end than at the place, along the line there, times its length. */
INLINE double missed_by(const beam *g, const beam_place *at)
{
    return at->slope > 0 ? at->slope * (g->half + at->s) : -at->slope * (g->half - at->s);
}

/* To within `close`, or touching. */
INLINE bool is_nearest(const beam *g, const beam_place *at, double close)
{
    double missed = missed_by(g, at), norm2 = vec_norm2(at->beyond);
    return missed * missed <= close * close * norm2 || norm2 <= g->touching2;
}

/* Where the slope is zero on the piece that is outside as both ends are; in the middle where it is nowhere zero. */
INLINE double capsule_box_between(const beam *g, vec3 beyond)
{
    vec3 outer = outer_part(g, beyond),
         from = vec(g->c.x - copysign(g->box.x, beyond.x), g->c.y - copysign(g->box.y, beyond.y),
             g->c.z - copysign(g->box.z, beyond.z));
    double bend = vec_norm2(outer);
    return bend > 0 ? -vec_dot(outer, from) / bend : 0;
}

/* The nearest place: an end; or from between both on. False when not found soon. */
INLINE bool find_place(const beam *g, double close, beam_place *at)
{
    const beam_place low = capsule_box_place_at(g, -g->half), high = capsule_box_place_at(g, g->half);
    *at = low.slope >= 0 ? low : high;
    if ((low.slope >= 0) | (high.slope <= 0)) return true;
    *at = capsule_box_place_at(g, clamp_to(capsule_box_between(g, vec_add(low.beyond, high.beyond)), g->half));
    for (int i = 0; i < NEWTON_MAX; i++) {
        if (is_nearest(g, at, close)) return true;
        *at = capsule_box_place_at(g, clamp_to(at->s - at->slope / vec_norm2(outer_part(g, at->beyond)), g->half));
    }
    return is_nearest(g, at, close);
}

/* The segment's point and the box's face each other along n, unit, in the box's frame, from the segment to the box. */
typedef struct gap {
    double lo, hi, s;
    vec3 n;
} gap;

INLINE gap capsule_box_gap_at(const beam *g, const beam_place *at)
{
    double norm2 = vec_norm2(at->beyond), length = sqrt(norm2), per = length * (1 / norm2);
    return (gap){length - missed_by(g, at) * per, length, at->s, vec_scale(at->beyond, -per)};
}

/* Near the box the slope is lost in the rounding of x: the line is made orthogonal to the segment instead, in the
 * coordinates in which x is outside. False where that would turn it to another side of the box. */
__attribute__((noinline, cold)) static bool squared_gap(const beam *g, const beam_place *at, gap *out)
{
    vec3 outer = outer_part(g, at->beyond), v = at->beyond;
    double bend = vec_norm2(outer);
    if (!(bend > 0)) return false;
    v = vec_madd(v, -vec_dot(v, outer) / bend, outer);
    v = vec_madd(v, -vec_dot(v, outer) / bend, outer);
    if (v.x * at->beyond.x < 0 || v.y * at->beyond.y < 0 || v.z * at->beyond.z < 0) return false;
    const vec3 line = direction_of(v);
    const beam_place there = {at->s, vec_dot(g->d, line), line};
    *out = (gap){vec_dot(line, at->beyond) - missed_by(g, &there), vec_norm(at->beyond), at->s, vec_neg(line)};
    return vec_norm2(line) > 0.5;
}

/* ---- the segment in the box ---- */

/* The greatest separation along the six axes; face 0 to 2, or 3 + the edge of the box. */
typedef struct parting {
    double by;
    int index;
} parting;

typedef struct beam_arrays {
    double c[3], d[3], box[3], half;
} beam_arrays;

INLINE void capsule_box_try_face(const beam_arrays *g, int j, parting *best)
{
    double by = fabs(g->c[j]) - g->box[j] - fabs(g->d[j]) * g->half;
    if (by > best->by) *best = (parting){by, j};
}

/* Along (0, -d_l, d_k), of which the product with d is zero to the last bit. */
INLINE void capsule_box_try_edge(const beam_arrays *g, int j, parting *best)
{
    int k = (j + 1) % 3, l = (j + 2) % 3;
    double dk = g->d[k], dl = g->d[l], norm2 = dk * dk + dl * dl;
    double by = fabs(dk * g->c[l] - dl * g->c[k]) - (fabs(dl) * g->box[k] + fabs(dk) * g->box[l]);
    bool less = by < 0 && best->by < 0 && by * by >= best->by * best->by * norm2;
    if (less || !(norm2 > PARALLEL2)) return;
    by /= sqrt(norm2);
    if (by > best->by) *best = (parting){by, 3 + j};
}

/* The points that face each other along a face's normal: an end of the segment; where that is beside the face, they
 * are to be found elsewhere. */
INLINE bool meet_face(const beam_arrays *g, int j, double slack, double n[3], double *s)
{
    int k = (j + 1) % 3, l = (j + 2) % 3;
    n[j] = g->c[j] > 0 ? -1 : 1;
    *s = copysign(g->half, n[j] * g->d[j]);
    return fabs(g->c[k] + *s * g->d[k]) <= g->box[k] + slack && fabs(g->c[l] + *s * g->d[l]) <= g->box[l] + slack;
}

/* Meets an edge of the box: the nearest points of the two lines. */
INLINE bool meet_edge(const beam_arrays *g, int j, double slack, double n[3], double *s)
{
    int k = (j + 1) % 3, l = (j + 2) % 3;
    double dk = g->d[k], dl = g->d[l], per = 1 / sqrt(dk * dk + dl * dl);
    if (dk * g->c[l] > dl * g->c[k]) per = -per;
    n[k] = -dl * per, n[l] = dk * per;
    double wk = copysign(g->box[k], -n[k]) - g->c[k], wl = copysign(g->box[l], -n[l]) - g->c[l];
    *s = (wk * dk + wl * dl) * (per * per);
    return fabs(*s) <= g->half + slack && fabs(g->c[j] + *s * g->d[j]) <= g->box[j] + slack;
}

__attribute__((noinline, cold)) static bool capsule_box_depth_of(const beam *of, double slack, gap *out)
{
    const beam_arrays g = {
        {of->c.x, of->c.y, of->c.z}, {of->d.x, of->d.y, of->d.z}, {of->box.x, of->box.y, of->box.z}, of->half};
    parting best = {-INFINITY, 0};
    for (int j = 0; j < 3; j++) capsule_box_try_face(&g, j, &best);
    for (int j = 0; j < 3; j++) capsule_box_try_edge(&g, j, &best);
    double n[3] = {0, 0, 0}, s;
    if (!(best.by < -0x1p-8 * slack)) return false; /* touching */
    bool met = best.index < 3 ? meet_face(&g, best.index, slack, n, &s) : meet_edge(&g, best.index - 3, slack, n, &s);
    *out = (gap){best.by, best.by, clamp_to(s, g.half), vec(n[0], n[1], n[2])};
    return met;
}

bool capsule_beside_box(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    const beam g = {vec_neg(mat_tmul(q->turn_b, p.b_in_a.t)), mat_tmul(q->turn_b, q->along_a),
        vec_scale(q->b->half, p.scale), q->a->half.z * p.scale, TOUCHING * TOUCHING * p.size * p.size};
    beam_place at;
    gap found;
    double close = 0.25 * p.error;
    bool there = find_place(&g, close, &at);
    if (!(vec_norm2(at.beyond) > g.touching2)) {
        p.error *= 1.25;
        if (!capsule_box_depth_of(&g, p.error, &found)) return false;
    } else {
        found = capsule_box_gap_at(&g, &at);
        if (!there && !squared_gap(&g, &at, &found)) return false;
        if (!(found.hi - found.lo <= close)) return false;
        p.error += 2 * UNIT_ROUNDOFF * found.hi;
    }
    vec3 n = mat_mul(q->turn_b, found.n), towards = n;
    span s = {.lo = found.lo, .hi = found.hi, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    s.axis = direction_again(n);
    s.point_a = vec_scale(q->along_a, found.s);
    s.point_b = vec_madd(s.point_a, found.hi, n);
    return end(q, &p, &s, towards, out);
}

/* ==== verdicts of two ellipsoids ==== */

/* Are two ellipsoids apart?
 *
 * Along a unit axis n they are apart by n.t - |A n| - |B n|, with A n the half axes of A times n, by the coordinates of
 * its frame: a lower bound of the distance, whatever led to n. And they overlap if both hold one point: midway between
 * the points of both that are the farthest along n and -n. Both are tried along the line of the centres, and then
 * where Newton's method along the gradient leads; what is left has to be measured.
 *
 * Rounding, in u = 2^-53. A matrix R is off by less than 19 u: the factor k of quat_matrix by 4 u (3 u of the norm, 1 u
 * of its own), times I - R, which is at most 2: 8 u; each entry is rounded twice before it is multiplied by k, on |xy|
 * + |wz| or the like, of which a row has 1/2 + sqrt(5) / 2 at most: 6.5 u; then twice more: 3.3 u and 1 u. A product
 * with it is off by 4 u. The separation: A n by 19 u, 4 u, 1 u of the half axes and 2.5 u of the length: 26.5 u of the
 * greatest half axis, for each; n.t by 1 u of the difference of the positions, 3 u of the product, 4.5 u by which n is
 * not unit, 4 u of two sums and of set_bounds: 12.5 u |t|. The error of 32 u of them all holds that; who asks for a
 * verdict does not mind its width. The point x: it is what it is in world axes from A's centre, of length at most the
 * size; from B's it is off by 2 u of the size; R'x by 23 u more. So |x| by half axes is off by less than e = error /
 * least half axis, and by 3 u of itself: if its square is computed as at most 1 - 4 e, with e >= 32 u, it is at most 1
 * - 2 e + 3 u + e < 1. */

enum { TRIES = 3 };

#define STRIDE 0.7    /* a longer step leaves what the derivatives know */
#define FLAT 0x1p-100 /* sizes: lengths below this have squares that may be lost */

typedef struct ellipsoids {
    const mat3 *turn_b;
    vec3 half_a, half_b, t; /* t: from A's centre to B's */
    double size;
} ellipsoids;

/* One ellipsoid along n: |A n|, and A n by its length, in its frame, in which all vectors of these functions are. */
typedef struct bulge {
    vec3 along;
    double height;
} bulge;

INLINE bulge bulge_of(vec3 half, vec3 n)
{
    vec3 w = vec_times(half, n);
    double height = sqrt(vec_norm2(w));
    return (bulge){vec_scale(w, 1 / height), height};
}

/* The second derivative of |A n| along x, orthogonal to n, and |A n| itself. */
INLINE double bend_of(vec3 half, const bulge *b, vec3 x)
{
    vec3 ax = vec_times(half, x);
    double side = vec_dot(ax, b->along);
    return (vec_norm2(ax) - side * side) / b->height;
}

/* Newton's step from n, given the line between the points there. Zero where there is none. */
INLINE vec3 next_axis(const ellipsoids *g, vec3 n, const bulge *a, const bulge *b, vec3 line, double apart)
{
    vec3 slope = vec_madd(line, -vec_dot(line, n), n);
    double steep = vec_norm(slope);
    if (!(steep > FLAT * g->size)) return VEC_ZERO;
    vec3 x = vec_scale(slope, 1 / steep);
    double bend = bend_of(g->half_a, a, x) + bend_of(g->half_b, b, mat_tmul(*g->turn_b, x)) + apart;
    return direction_of(vec_madd(n, bend > 0 ? min_of(steep / bend, STRIDE) : STRIDE, x));
}

/* Is the point, as seen from its centre, in the ellipsoid, by more than rounding? */
INLINE bool ellipsoid_is_in(vec3 half, vec3 at, double error)
{
    double least = min_of(half.x, min_of(half.y, half.z));
    return vec_norm2(vec(at.x / half.x, at.y / half.y, at.z / half.z)) <= 1 - 4 * error / least;
}

INLINE bool ellipsoid_overlap(const ellipsoids *g, vec3 point, double error)
{
    return ellipsoid_is_in(g->half_a, point, error) &&
           ellipsoid_is_in(g->half_b, mat_tmul(*g->turn_b, vec_sub(point, g->t)), error);
}

bool ellipsoids_by_verdict(primitive_pair *q, narrow_result *out)
{
    if (is_measured(q->request)) return false;
    unit_pair p;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    p.error = 2 * unit_error(p.size);
    double threshold = q->request->threshold * p.scale, enough = max_of(threshold + p.radius + p.error, 0);
    const ellipsoids g = {
        &q->turn_b, vec_scale(q->a->half, p.scale), vec_scale(q->b->half, p.scale), p.b_in_a.t, p.size};
    vec3 n = vec_greatest(g.t) > FLAT * p.size ? direction_of(g.t) : VEC_ZERO;
    for (uint32_t i = 1; i <= TRIES && vec_norm2(n) > 0.5; i++) {
        bulge a = bulge_of(g.half_a, n), b = bulge_of(g.half_b, mat_tmul(*g.turn_b, n));
        if (!(min_of(a.height, b.height) > FLAT * p.size)) return false;
        double apart = vec_dot(n, g.t) - a.height - b.height;
        vec3 top_a = vec_times(g.half_a, a.along),
             top_b = vec_sub(g.t, mat_mul(*g.turn_b, vec_times(g.half_b, b.along)));
        vec3 line = vec_sub(top_b, top_a);
        span s = {.lo = apart, .axis = direction_again(n), .point_a = top_a, .point_b = top_b, .iterations = i};
        s.hi = max_of(apart, vec_norm(line));
        s.method = NARROW_BY_CLOSED_FORM;
        if (apart > enough) return end(q, &p, &s, s.hi > p.radius ? direction_of(line) : s.axis, out);
        if (apart < 0 && threshold >= 0 && ellipsoid_overlap(&g, vec_scale(vec_add(top_a, top_b), 0.5), p.error)) {
            (void)end(q, &p, &s, s.axis, out);
            out->hi = 0;
            return true;
        }
        n = next_axis(&g, n, &a, &b, line, apart);
    }
    return false;
}
