/* placed_road: one function a pair of types, each formula inlined twice: for sizes of everyday, whose squares are in
 * range as they are, and for all others, which are first brought to unit size. All that is between the two is a power
 * of two: where both can answer, they do with the same bits. Pure; any thread.
 *
 * Rounding: the bound is unit_pair's, of which these use less, for no quaternions are multiplied: a matrix is off by
 * 6 u, products and sums by 3 u each; and the sum of the sizes by a few u of itself. */
#include "placed_road.h"

#include "finish.h"
#include "formulas.h"
#include "geom/round.h"

#define INLINE __attribute__((always_inline)) static inline
#define APART __attribute__((noinline, cold)) static

/* Sizes (m) between these are everyday; with them nothing below leaves the normal numbers, except a distance between
 * cores that is less than NOTICEABLE. */
#define LEAST_EVERYDAY 0x1p-32
#define GREATEST_EVERYDAY 0x1p32
#define NOTICEABLE 0x1p-300

typedef struct placed {
    const shape *a, *b;
    const narrow_placement *at_a, *at_b;
    const narrow_request *request;
    bool everyday;
} placed;

INLINE bool suffices(const narrow_request *r, const narrow_result *out)
{
    bool measured = out->hi - out->lo <= r->tolerance || out->lo > r->range || !(r->facts & NARROW_DISTANCE);
    bool decided = out->lo > r->threshold || out->hi <= r->threshold || r->facts == NARROW_DISTANCE;
    return measured && decided;
}

static double greatest_of(const shape *a, const shape *b, vec3 between)
{
    double sizes = max_of(max_of(a->radius, vec_greatest(a->half)), max_of(b->radius, vec_greatest(b->half)));
    return max_of(sizes, vec_greatest(between));
}

/* The part of unit_pair_init that does not depend on the types. */
INLINE void begin(const placed *q, unit_pair *p)
{
    vec3 between = vec_sub(q->at_b->at.p, q->at_a->at.p);
    p->unit = p->scale = 1;
    if (!q->everyday) unit_of(greatest_of(q->a, q->b, between), &p->unit, &p->scale);
    p->a.radius = q->a->radius * p->scale;
    p->b.radius = q->b->radius * p->scale;
    p->b_in_a.t = vec_scale(between, p->scale);
    p->radius = p->a.radius + p->b.radius;
    p->excess = 0;
}

/* `cores`: how far those reach, both together. */
INLINE bool is_in_range(const placed *q, double cores, unit_pair *p)
{
    p->size = p->radius + cores + vec_norm(p->b_in_a.t);
    p->error = unit_error(p->size);
    return !q->everyday || (p->size > LEAST_EVERYDAY && p->size < GREATEST_EVERYDAY);
}

INLINE bool is_noticeable(const placed *q, double distance)
{
    return !q->everyday || fabs(distance) > NOTICEABLE;
}

/* The shapes' points, on from those of the cores: along the line between these when the shapes are apart, along the
 * axis when they are not. */
INLINE bool end(const placed *q, const unit_pair *p, const span *s, vec3 towards, narrow_result *out)
{
    set_bounds(p, s, out);
    out->axis = s->axis;
    out->point_a = vec_scale(vec_madd(s->point_a, p->a.radius, towards), p->unit);
    out->point_b = vec_scale(vec_madd(s->point_b, -p->b.radius, towards), p->unit);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

/* Axis, line of the witnesses and distance are one: a single root. Centres that (nearly) coincide have no line. */
INLINE bool two_balls(const placed *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    if (!is_in_range(q, 0, &p)) return false;
    vec3 t = p.b_in_a.t;
    double norm2 = vec_norm2(t), distance = sqrt(norm2);
    if (!(norm2 > (q->everyday ? NOTICEABLE : 0x1p-900))) return false;
    span s = {.lo = distance, .hi = distance, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    s.axis = vec_scale(t, 1 / distance);
    set_bounds(&p, &s, out);
    out->axis = s.axis;
    out->point_a = vec_scale(s.axis, p.a.radius * p.unit);
    out->point_b = vec_scale(vec_madd(t, -p.b.radius, s.axis), p.unit);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

INLINE bool ball_and_capsule(const placed *q, narrow_result *out)
{
    unit_pair p;
    span s;
    begin(q, &p);
    p.b_in_a.r.z = q->at_b->turn.z;
    p.b.half.z = q->b->half.z * p.scale;
    if (!is_in_range(q, p.b.half.z, &p)) return false;
    formula_sphere_capsule(&p, &s);
    vec3 towards = s.hi > p.radius ? vec_scale(s.point_b, 1 / s.hi) : s.axis;
    return is_noticeable(q, s.hi) && end(q, &p, &s, towards, out);
}

INLINE bool ball_and_box(const placed *q, narrow_result *out)
{
    unit_pair p;
    span s;
    begin(q, &p);
    p.b_in_a.r = q->at_b->turn;
    p.b.half = vec_scale(q->b->half, p.scale);
    if (!is_in_range(q, vec_norm(p.b.half), &p)) return false;
    formula_sphere_box(&p, &s);
    s.axis = direction_again(s.axis);
    return is_noticeable(q, s.hi) && end(q, &p, &s, s.axis, out);
}

INLINE bool two_capsules(const placed *q, narrow_result *out)
{
    unit_pair p;
    span s;
    begin(q, &p);
    double ha = q->a->half.z * p.scale, hb = q->b->half.z * p.scale;
    if (!is_in_range(q, ha + hb, &p)) return false;
    segments g = segments_along(q->at_a->turn.z, ha, q->at_b->turn.z, hb, p.b_in_a.t);
    if (!formula_capsule_capsule(&p, &g, &s)) return false;
    vec3 towards = s.hi > p.radius ? vec_scale(vec_sub(s.point_b, s.point_a), 1 / s.hi) : s.axis;
    return is_noticeable(q, s.hi) && end(q, &p, &s, towards, out);
}

#define ROAD(formula)                                                                                                  \
    APART bool formula##_of_any_size(const shape *a, const narrow_placement *at_a, const shape *b,                     \
        const narrow_placement *at_b, const narrow_request *request, narrow_result *out)                               \
    {                                                                                                                  \
        const placed q = {a, b, at_a, at_b, request, false};                                                           \
        return formula(&q, out);                                                                                       \
    }                                                                                                                  \
    static bool formula##_placed(const shape *a, const narrow_placement *at_a, const shape *b,                         \
        const narrow_placement *at_b, const narrow_request *request, narrow_result *out)                               \
    {                                                                                                                  \
        const placed q = {a, b, at_a, at_b, request, true};                                                            \
        return formula(&q, out) || formula##_of_any_size(a, at_a, b, at_b, request, out);                              \
    }

ROAD(two_balls)
ROAD(ball_and_capsule)
ROAD(ball_and_box)
ROAD(two_capsules)

placed_road *const placed_roads[PLACED_TYPES][PLACED_TYPES] = {
    [SHAPE_SPHERE] = {two_balls_placed, ball_and_capsule_placed, ball_and_box_placed},
    [SHAPE_CAPSULE] = {NULL, two_capsules_placed, NULL},
};
