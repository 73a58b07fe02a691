/* placed_balls_wide: the roads of a ball and a ball or a box, with registers of 32 bytes: the same bits as
 * placed_balls.c, which has all other sizes. Pure; any thread. */
#include "triple_wide.h"

#include "placed_balls.h"

/* |a x b|^2, in the order of vec_norm2(vec_cross(a, b)). */
LANES_INLINE double across2_of(lanes a, lanes b)
{
    lanes across = a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
    lanes squares = across * across; /* of z, x, y */
    return squares[1] + squares[2] + squares[0];
}

/* As in placed_road.c, where it is derived, but for its cases. */
LANES_INLINE bool two_capsules(const placed *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    const lanes a = triple_load(&q->at_a->turn.z), b = triple_load(&q->at_b->turn.z), t = between_centres(q, &p);
    const double ha = q->at_a->half.z, hb = q->at_b->half.z;
    lanes dots = triple_sums(a * t, b * t, a * b);
    double at = dots[0], bt = dots[1], ab = dots[2];
    double s_a = clamp_to((at - ab * bt) / across2_of(a, b), ha), s_b = s_a * ab - bt;
    if (fabs(s_b) > hb) {
        s_b = clamp_to(s_b, hb);
        s_a = clamp_to(at + s_b * ab, ha);
    }
    lanes point_a = triple_scale(a, s_a), point_b = t + triple_scale(b, s_b), v = point_b - point_a;
    double norm2 = triple_norm2(v), distance = sqrt(norm2);
    p.size = (q->at_a->reach + q->at_b->reach) * p.scale;
    if (!(p.size > LEAST_EVERYDAY && max_of(p.size, norm2) < GREATEST_EVERYDAY) || !is_noticed(q, norm2)) return false;
    p.error = unit_error(1.25) * p.size + unit_error(1) * distance;
    double per = inverse_of(norm2, distance);
    lanes axis = triple_scale(v, per), along = triple_sums(v * t, v * a, v * b);
    span s = {.hi = distance, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    s.lo = (along[0] - fabs(along[1]) * ha - fabs(along[2]) * hb) * per;
    if (!(s.hi - s.lo <= 0.25 * p.error)) return false;
    double *to = &out->axis.x;
    triple_store(to, axis);
    triple_store(to + 3, point_a + triple_scale(axis, p.a.radius));
    triple_store(to + 6, point_b + triple_scale(axis, -p.b.radius));
    set_bounds(&p, &s, out);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

#define ROAD_WIDE(formula)                                                                                             \
    LANES_WIDE bool formula##_placed_wide(const narrow_placed *a, const narrow_placed *b,                              \
        const narrow_request *request, narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)            \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, true};                                                    \
        return formula(&q, result) || formula##_placed(a, b, request, cache, scratch, result);                         \
    }

ROAD_WIDE(two_balls)
ROAD_WIDE(ball_and_box)
ROAD_WIDE(two_capsules)
