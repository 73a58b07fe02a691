/* placed_balls: a ball beside a ball or a box, where they stand. Pure; any thread.
 *
 * A ball's centre is all of its core: the line from there to the nearest point of the other core is the axis. A vector
 * is the first three of four lanes; what is in the fourth (the number that follows in memory) is never asked for, and
 * where it is written the next vector is written over it. The shortest queries of all, so that each instruction counts.
 *
 * Rounding, ball and box, in u = 2^-53, with r the ball's radius, g the half diagonal of the box, e the gap between the
 * centre and the box, |t| <= e + g. A matrix R is off by less than 6.5 u (test_placed_boxes), its product by 3.7 u.
 *   hi: t by 1 u, R't by 10.2, v by e, |v| by 2.5 e, set_bounds by 2 e + 2 r: less than 17 e + 12 g + 2 r.
 *   lo, along n = R v / e: n is off by 5.7 by its product and its two roundings, so n.t by 9.4 |t| more than v.R't / e
 *     is by the product (1 u of t in it), the box's height by 6.5 g + 5.7 g; v.R't less the height of v is v^2 but for
 *     a rounding each, over e: 6 e; brought to length 1, another 9 e; set_bounds 2 e + 2 r, the ball along n 4 r: less
 *     than 28 e + 24 g + 6 r.
 *   The centre in the box: R't by 11.2 g, its height and sum by 3 g; along a column of R 4.7 g of the product, 6.5 g of
 *     the height and 6.5 g to bring it to length 1: less than 24 g + 6 r.
 * The error is 28 e + 24 g + 16 r. */
#include "placed_formula.h"

#include "lanes.h"

#include <stddef.h>

LANES_INLINE lanes load3(const vec3 *from)
{
    return lanes_load(&from->x);
}

/* lanes_of, in one instruction where there is one. */
LANES_INLINE lanes all_of(double x)
{
    lanes v = {x, x, x, x};
    return LANES_ALL(v, 0);
}

LANES_INLINE double norm2_of(lanes v)
{
    lanes squares = v * v;
    return squares[0] + squares[1] + squares[2];
}

/* 1 / distance, in all lanes: the quotient and the root are found side by side. */
LANES_INLINE lanes inverse_of(double norm2, double distance)
{
    return all_of(distance * (1 / norm2));
}

/* Everyday's is 1, which the compiler would multiply by. */
LANES_INLINE lanes scaled(const placed *q, const unit_pair *p, lanes v)
{
    return q->everyday ? v : v * lanes_of(p->scale);
}

LANES_INLINE lanes between_centres(const placed *q, const unit_pair *p)
{
    return scaled(q, p, load3(&q->at_b->at.p) - load3(&q->at_a->at.p));
}

/* m' v, and m v: the sums in the order of mat_tmul and mat_mul. */
LANES_INLINE lanes seen_from(const mat3 *m, lanes v)
{
    lanes x = load3(&m->x) * v, y = load3(&m->y) * v, z = load3(&m->z) * v;
    lanes first = __builtin_shufflevector(x, y, 0, 4, 2, 6), second = __builtin_shufflevector(x, y, 1, 5, 3, 7);
    return __builtin_shufflevector(first, z, 0, 1, 4, 5) + __builtin_shufflevector(second, z, 0, 1, 5, 4) +
           __builtin_shufflevector(first, z, 2, 3, 6, 7);
}

LANES_INLINE lanes turned_by(const mat3 *m, lanes v)
{
    return load3(&m->x) * LANES_ALL(v, 0) + load3(&m->y) * LANES_ALL(v, 1) + load3(&m->z) * LANES_ALL(v, 2);
}

/* The order of the fields of the answer, by which a fourth lane is written over by what follows it. */
_Static_assert(offsetof(narrow_result, point_a) == offsetof(narrow_result, axis) + sizeof(vec3) &&
                   offsetof(narrow_result, point_b) == offsetof(narrow_result, point_a) + sizeof(vec3) &&
                   offsetof(narrow_result, manifold) == offsetof(narrow_result, point_b) + sizeof(vec3) &&
                   sizeof(manifold) >= sizeof(double),
    "vectors of the answer are in a row, and a manifold follows them");

/* `distance` is that of the centre from the other core, along `axis`. */
LANES_INLINE bool end_of_ball(const placed *q, const unit_pair *p, double distance, lanes axis, narrow_result *out)
{
    const span s = {.lo = distance, .hi = distance, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    double *to = &out->axis.x;
    lanes_store(to, axis);
    lanes_store(to + 3, axis * all_of(p->a.radius * p->unit));
    lanes_store(to + 6, axis * all_of((distance - p->b.radius) * p->unit));
    set_bounds(p, &s, out);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

/* Centres that (nearly) coincide have no line. */
LANES_INLINE bool two_balls(const placed *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    lanes t = between_centres(q, &p);
    double norm2 = norm2_of(t), distance = sqrt(norm2);
    if (!is_noticed(q, norm2) || norm2 > GREATEST_EVERYDAY) return false;
    p.error = unit_error(p.radius + distance);
    return end_of_ball(q, &p, distance, t * inverse_of(norm2, distance), out);
}

/* From the point in a box to its nearest face, ties in the order of the axes; `at`: the box seen from the point, along
 * the box's axes; `beyond`: |at| less the half sides. */
LANES_INLINE double through_face(const mat3 *turn, lanes at, lanes beyond, lanes *axis)
{
    double most = beyond[0], side = at[0];
    const vec3 *face = &turn->x;
    if (beyond[1] > most) most = beyond[1], side = at[1], face = &turn->y;
    if (beyond[2] > most) most = beyond[2], side = at[2], face = &turn->z;
    *axis = load3(face) * lanes_of(side <= 0 ? -1 : 1);
    return most;
}

/* direction_again, of what has a length of about 1. */
LANES_INLINE lanes unit_again(lanes v)
{
    double norm2 = norm2_of(v);
    return fabs(norm2 - 1) <= 0x1p-50 ? v : v * lanes_of(1 / sqrt(norm2));
}

LANES_INLINE bool ball_and_box(const placed *q, narrow_result *out)
{
    static const lane_mask SIGN = {INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN};
    unit_pair p;
    begin(q, &p);
    const mat3 *turn = &q->at_b->turn;
    lanes at = seen_from(turn, between_centres(q, &p)), axis;
    lanes beyond = (lanes)((lane_mask)at & ~SIGN) - scaled(q, &p, load3(&q->at_b->half));
    lanes v = (lanes)(((lane_mask)beyond & (beyond > 0)) | ((lane_mask)at & SIGN));
    double norm2 = norm2_of(v), distance = sqrt(norm2);
    p.size = p.a.radius + 1.5 * (q->at_b->reach * p.scale) + 1.75 * distance;
    if (q->everyday && !(p.size > LEAST_EVERYDAY && p.size < GREATEST_EVERYDAY)) return false;
    p.error = unit_error(p.size);
    if (is_noticed(q, norm2)) {
        axis = turned_by(turn, v) * inverse_of(norm2, distance);
    } else {
        if (v[0] != 0 || v[1] != 0 || v[2] != 0) return false; /* outside, and lost */
        distance = through_face(turn, at, beyond, &axis);
        axis = unit_again(axis);
    }
    return end_of_ball(q, &p, distance, axis, out);
}

ROAD(two_balls)
ROAD_WIDE(two_balls)
ROAD(ball_and_box)
ROAD_WIDE(ball_and_box)
