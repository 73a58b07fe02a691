/* placed_balls: a ball beside a ball or a box, where they stand: the formulas, over either kind of triple, which is
 * included before. Pure; any thread.
 *
 * A ball's centre is all of its core: the line from there to the nearest point of the other core is the axis. These are
 * the shortest queries of all, where each instruction counts, and each that waits for another.
 *
 * Rounding, in u = 2^-53. Two balls: the distance by 3.5 u, the axis by 7 u of its length: less than the 16 u of
 * unit_error. A ball and a box, with r the ball's radius, g the half diagonal of the box, e the gap between the centre
 * and the box, |t| <= e + g; a matrix R is off by less than 6.5 u (test_placed_boxes), a product with it by 3.7 u.
 *   hi: t by 1 u, R't by 10.2, v by e, |v| by 2.5 e, set_bounds by 2 e + 2 r: less than 17 e + 12 g + 2 r.
 *   lo, along n = R v / e: n is off by 5.7 by the product and two roundings, so that n.t is off by 9.4 |t| from v.R't /
 *     e, t itself by 1 u, the box's height by 6.5 g + 5.7 g; v.R't less the height of v is v^2 but for a rounding, and
 *     over e 6 e; set_bounds by 2 e + 2 r; n is longer than 1 by less than 16 u, times r; made 1, its length takes
 *     another 10 e: less than 28 e + 24 g + 18 r.
 *   The centre in the box: R't by 11.2 g, its height and sum by 3 g; along a column of R the product by 4.7 g, the
 *     height by 6.5 g, and its length, made 1, by 6.5 g: less than 24 g + 9 r.
 * The error is 28 e + 24 (g + r). */
#ifndef COLLIDED_NARROW_PLACED_BALLS_H
#define COLLIDED_NARROW_PLACED_BALLS_H

#include "placed_formula.h"

#include <stddef.h>

/* Everyday's scale is 1, by which the compiler would multiply. */
INLINE triple scaled(const placed *q, const unit_pair *p, triple v)
{
    return q->everyday ? v : triple_scale(v, p->scale);
}

INLINE triple between_centres(const placed *q, const unit_pair *p)
{
    return scaled(q, p, triple_sub(triple_load(&q->at_b->at.p), triple_load(&q->at_a->at.p)));
}

/* The order of the fields of the answer: what triple_store writes too much is written over by what follows. */
_Static_assert(offsetof(narrow_result, point_a) == offsetof(narrow_result, axis) + sizeof(vec3) &&
                   offsetof(narrow_result, point_b) == offsetof(narrow_result, point_a) + sizeof(vec3) &&
                   offsetof(narrow_result, manifold) == offsetof(narrow_result, point_b) + sizeof(vec3) &&
                   sizeof(manifold) >= sizeof(double),
    "vectors of the answer are in a row, and a manifold follows them");

/* `distance` is that of the centre from the other core, along `axis`. */
INLINE bool end_of_ball(const placed *q, const unit_pair *p, double distance, triple axis, narrow_result *out)
{
    const span s = {.lo = distance, .hi = distance, .method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    double *to = &out->axis.x;
    triple_store(to, axis);
    triple_store(to + 3, triple_scale(axis, p->a.radius * p->unit));
    triple_store(to + 6, triple_scale(axis, (distance - p->b.radius) * p->unit));
    set_bounds(p, &s, out);
    out->status = NARROW_CERTAIN;
    return suffices(q->request, out);
}

/* 1 / distance: the quotient and the root are found side by side. */
INLINE double inverse_of(double norm2, double distance)
{
    return distance * (1 / norm2);
}

/* Centres that (nearly) coincide have no line. */
INLINE bool two_balls(const placed *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    triple t = between_centres(q, &p);
    double norm2 = triple_norm2(t), distance = sqrt(norm2);
    if (!is_noticed(q, norm2) || norm2 > GREATEST_EVERYDAY) return false;
    p.error = unit_error(p.radius + distance);
    return end_of_ball(q, &p, distance, triple_scale(t, inverse_of(norm2, distance)), out);
}

/* From the point in a box to its nearest face, ties in the order of the axes; `at`: the box seen from the point, along
 * the box's axes; `beyond`: |at| less the half sides. */
INLINE double through_face(const mat3 *turn, triple at, triple beyond, triple *axis)
{
    double most = triple_x(beyond), side = triple_x(at);
    const vec3 *face = &turn->x;
    if (triple_y(beyond) > most) most = triple_y(beyond), side = triple_y(at), face = &turn->y;
    if (triple_z(beyond) > most) most = triple_z(beyond), side = triple_z(at), face = &turn->z;
    *axis = triple_scale(triple_load(face), side <= 0 ? -1 : 1);
    return most;
}

/* The error does not wait for the root, nor does the range. */
INLINE bool ball_and_box(const placed *q, narrow_result *out)
{
    unit_pair p;
    begin(q, &p);
    const mat3 *turn = &q->at_b->turn;
    triple at = triple_tmul(turn, between_centres(q, &p));
    triple beyond = triple_sub(triple_abs(at), scaled(q, &p, triple_load(&q->at_b->half)));
    triple v = triple_signed(beyond, at);
    double norm2 = triple_norm2(v), distance = sqrt(norm2);
    p.size = p.a.radius + q->at_b->reach * p.scale;
    if (q->everyday && !(p.size > LEAST_EVERYDAY && max_of(p.size, norm2) < GREATEST_EVERYDAY)) return false;
    p.error = unit_error(1.5) * p.size + unit_error(1.75) * distance;
    if (__builtin_expect(is_noticed(q, norm2), true))
        return end_of_ball(q, &p, distance, triple_scale(triple_mul(turn, v), inverse_of(norm2, distance)), out);
    triple axis;
    distance = through_face(turn, at, beyond, &axis);
    return distance <= 0 && end_of_ball(q, &p, distance, axis, out); /* or outside, and lost */
}

#endif
