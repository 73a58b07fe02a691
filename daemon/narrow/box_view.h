/* box_view: two boxes where they stand, each seen from the other, with the axes of a box side by side in lanes: all six
 * faces' separations in about the instructions of two. Inlined; the same bits however wide the processor is. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_BOX_VIEW_H
#define COLLIDED_NARROW_BOX_VIEW_H

#include "lanes.h"
#include "placed_road.h"

#include <string.h>

/* What is told of three axes is in the first three of four lanes: of A's in 0 to 2, of B's in 4 to 6. */
enum { BOX_VIEW = 2 * LANES };

typedef struct box_view {
    lanes3 b_from_a, a_from_b; /* B's axes in A's, and A's in B's, by columns */
    lanes half_a, half_b;
    lanes between, t, u; /* from A's centre to B's: in the world, along A's axes, along B's */
    lanes by_a, by_b;    /* how far the faces separate */
} box_view;

LANES_INLINE lanes lanes_each(lanes v, int k) /* k constant */
{
    return k == 0   ? __builtin_shufflevector(v, v, 0, 0, 0, 0)
           : k == 1 ? __builtin_shufflevector(v, v, 1, 1, 1, 1)
                    : __builtin_shufflevector(v, v, 2, 2, 2, 2);
}

LANES_INLINE lane_mask lanes_sign(lanes v)
{
    return (lane_mask)v & (lane_mask)lanes_of(-0.0);
}

LANES_INLINE lanes lanes_abs(lanes v)
{
    return (lanes)((lane_mask)v & ~(lane_mask)lanes_of(-0.0));
}

LANES_INLINE lanes lanes_clamp(lanes v, lanes most) /* -most <= v <= most */
{
    lanes least = 0 - most;
    for (int k = 0; k < LANES; k++) v[k] = v[k] < most[k] ? v[k] : most[k];
    for (int k = 0; k < LANES; k++) v[k] = v[k] > least[k] ? v[k] : least[k];
    return v;
}

LANES_INLINE lanes3 lanes3_transposed(lanes3 m)
{
    lanes even = __builtin_shufflevector(m.x, m.y, 0, 4, 2, 6), odd = __builtin_shufflevector(m.x, m.y, 1, 5, 3, 7);
    return (lanes3){__builtin_shufflevector(even, m.z, 0, 1, 4, 5), __builtin_shufflevector(odd, m.z, 0, 1, 5, 6),
        __builtin_shufflevector(even, m.z, 2, 3, 6, 7)};
}

/* m v, for a matrix of these columns: of a vector in lanes, and of one in memory. */
LANES_INLINE lanes lanes3_mul(lanes3 m, lanes v)
{
    return m.x * lanes_each(v, 0) + m.y * lanes_each(v, 1) + m.z * lanes_each(v, 2);
}

LANES_INLINE lanes lanes3_mul_vec(lanes3 m, const vec3 *v)
{
    return m.x * v->x + m.y * v->y + m.z * v->z;
}

/* Of three lanes. */
LANES_INLINE double lanes_norm2(lanes v)
{
    lanes squares = v * v;
    return squares[0] + squares[1] + squares[2];
}

LANES_INLINE lanes3 box_view_axes(const narrow_placed *s)
{
    return (lanes3){lanes_load(&s->turn.x.x), lanes_load(&s->turn.y.x), lanes_load(&s->turn.z.x)};
}

/* The fourth lane is that of the third. */
LANES_INLINE lanes box_view_faces(lanes centre, lanes half, lanes3 others, const vec3 *others_half, double scale)
{
    const lanes3 sides = {lanes_abs(others.x), lanes_abs(others.y), lanes_abs(others.z)};
    const vec3 by = {others_half->x * scale, others_half->y * scale, others_half->z * scale};
    lanes apart = lanes_abs(centre) - half - lanes3_mul_vec(sides, &by);
    return __builtin_shufflevector(apart, apart, 0, 1, 2, 2);
}

/* Lengths are brought to unit size by `scale`. */
LANES_INLINE void box_view_of(const narrow_placed *a, const narrow_placed *b, double scale, box_view *v)
{
    v->half_a = lanes_load(&a->half.x) * scale, v->half_b = lanes_load(&b->half.x) * scale;
    v->between = (lanes_load(&b->at.p.x) - lanes_load(&a->at.p.x)) * scale;
    lanes3 rows_a = lanes3_transposed(box_view_axes(a)), rows_b = lanes3_transposed(box_view_axes(b));
    v->b_from_a = (lanes3){
        lanes3_mul_vec(rows_a, &b->turn.x), lanes3_mul_vec(rows_a, &b->turn.y), lanes3_mul_vec(rows_a, &b->turn.z)};
    v->a_from_b = lanes3_transposed(v->b_from_a);
    v->t = lanes3_mul(rows_a, v->between), v->u = lanes3_mul(rows_b, v->between);
    v->by_a = box_view_faces(v->t, v->half_a, v->b_from_a, &b->half, scale);
    v->by_b = box_view_faces(v->u, v->half_b, v->a_from_b, &a->half, scale);
}

/* The greatest separation by a face, and whose: 0 to 2, or 4 to 6. Ties go to the first. */
LANES_INLINE double box_view_most(const box_view *v, unsigned *face)
{
    double most = lanes_greatest(v->by_a, v->by_b);
    *face = (unsigned)__builtin_ctz(lanes_bits(v->by_a == most) | lanes_bits(v->by_b == most) << LANES | 1u << 7);
    return most;
}

/* The same where it is above 0, and but for the last three bits, which are 0: in them each face's number goes along
 * through the comparisons. Of faces that are equal but for those bits the first wins. */
LANES_INLINE double box_view_most_above(const box_view *v, unsigned *face)
{
    const lane_mask rest = {~7, ~7, ~7, ~7}, a = {7, 6, 5, 5}, b = {3, 2, 1, 1};
    double most = lanes_greatest((lanes)(((lane_mask)v->by_a & rest) | a), (lanes)(((lane_mask)v->by_b & rest) | b));
    uint64_t bits;
    memcpy(&bits, &most, sizeof bits);
    *face = 7 - (unsigned)(bits & 7);
    bits &= ~UINT64_C(7);
    memcpy(&most, &bits, sizeof most);
    return most;
}

/* Sides of a box, as features are named: BETWEEN, HIGH, LOW by bits. */
LANES_INLINE void box_sides_write(unsigned high, unsigned low, uint16_t side[3])
{
    for (int k = 0; k < 3; k++) side[k] = (uint16_t)((high >> k & 1) | (low >> k & 1) << 1);
}

/* A guess at the features that are nearest: where the other's centre is. */
LANES_INLINE void box_view_features(const box_view *v, narrow_features *f)
{
    const lanes none = {0, 0, 0, 0};
    unsigned out_a = lanes_bits(lanes_abs(v->t) > v->half_a) & 7, out_b = lanes_bits(lanes_abs(v->u) > v->half_b) & 7;
    unsigned high_a = lanes_bits(v->t > none), high_b = lanes_bits(v->u < none);
    int free_a = 3 - __builtin_popcount(out_a), free_b = 3 - __builtin_popcount(out_b);
    if (free_a && free_b && free_a + free_b > 2) out_b = 7;
    *f = (narrow_features){.count_a = 3, .count_b = 3};
    box_sides_write(out_a & high_a, out_a & ~high_a, f->a);
    box_sides_write(out_b & high_b, out_b & ~high_b, f->b);
}

#endif
