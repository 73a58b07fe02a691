/* box_facing: the formulas for corners, edges and faces of two boxes, in lanes, and the proof that nothing else is as
 * near (features.h); for box_box.c, and by box_features.c for searches. A feature of a box: for each of its axes the
 * side that the nearest point lies on, or that it lies between the two. Across an axis along which the box has no
 * extent the side is HIGH. All in A's frame. Inlined; the same bits however wide the processor is. Pure; any thread.
 *
 * Rounding, as in box_box.c, in u of both half diagonals g and |t|: points by 6.5 (the matrix) and 5.2 (the product),
 * so hi by 11.7 g, and by 2 |t| and what a norm takes. The axis: of a corner of A's, by 11.7, and so A's heights by
 * 11.7 and 4 g; B's by 6.5 and 8.2; t by 4, and lo by the 12 that the axis is off unit. Less than 24 of them all. */
#ifndef COLLIDED_NARROW_CONVEX_BOX_FACING_H
#define COLLIDED_NARROW_CONVEX_BOX_FACING_H

#include "features.h"
#include "narrow/math/simd.h"

/* Two boxes by their half sides, from A's centre to B's, and B's axes and, by them, A's. */
typedef struct box_lanes {
    lanes half_a, half_b, t;
    lanes3 axes_b, rows_b;
} box_lanes;

/* Each vector is followed by a number; lengths are brought to unit size by `scale`. A zero has no sign. */
LANES_INLINE box_lanes box_lanes_of(
    const vec3 *half_a, const vec3 *half_b, const vec3 *between, const mat3 *turn_b, double scale)
{
    const lanes none = {0, 0, 0, 0};
    const lanes3 axes = {
        lanes_load(&turn_b->x.x) + none, lanes_load(&turn_b->y.x) + none, lanes_load(&turn_b->z.x) + none};
    return (box_lanes){lanes_load(&half_a->x) * scale, lanes_load(&half_b->x) * scale, lanes_load(&between->x) * scale,
        axes, lanes3_transposed(axes)};
}

/* Sides of a box, as features are named: BETWEEN, HIGH, LOW by bits. */
LANES_INLINE void box_sides_write(unsigned high, unsigned low, uint16_t side[3])
{
    for (int k = 0; k < 3; k++) side[k] = (uint16_t)((high >> k & 1) | (low >> k & 1) << 1);
}

/* What the answer is made of. */
typedef struct box_facing {
    lanes axis, point_a, point_b;
    double lo, hi;
} box_facing;

typedef struct box_feature {
    lanes half, side; /* 1, -1, or 0 for between */
    lanes at;         /* the nearest point in its own frame, 0 where it lies between */
    lane_mask between;
    lane_mask named; /* as box_features_along would: HIGH across no extent */
    int free;        /* axes along which it lies between */
} box_feature;

LANES_INLINE void box_feature_set(lanes half, lanes side, box_feature *x)
{
    const lanes none = {0, 0, 0, 0};
    x->half = half, x->side = side;
    x->at = side * half;
    x->between = side == none;
    x->free = __builtin_popcount(lanes_bits(x->between));
    x->named = (half > none) | (side > none);
}

LANES_INLINE void box_feature_read(lanes half, const uint16_t side[3], box_feature *x)
{
    static const double SIGN[4] = {0, 1, -1, 0};
    const lanes sides = {SIGN[side[0] & 3], SIGN[side[1] & 3], SIGN[side[2] & 3], 1};
    box_feature_set(half, sides, x);
}

/* Where it lies between its sides as it is said to, and where the direction is out of a side: by more than a margin. */
LANES_INLINE lane_mask box_feature_holds(const box_feature *x, lanes at, lanes direction, double margin)
{
    const lanes none = {0, 0, 0, 0};
    lane_mask in = x->half - lanes_abs(at) > margin, out = x->side * direction > NEAR_SINE_MARGIN;
    return (x->between & in) | (~x->between & (out | (x->half == none)));
}

/* What does not hold otherwise: a side that the point lies beyond, or between two out of neither of which the
 * direction is. */
LANES_INLINE void box_feature_step(lane_mask holds, lanes at, box_feature *x)
{
    const lanes one = {1, 1, 1, 1};
    lane_mask beyond = ((lane_mask)one | lanes_sign(at)) & x->between; /* 0 where it was on a side */
    lanes other = (lanes)beyond, side = lanes_choose(holds, x->side, other);
    side[3] = 1;
    box_feature_set(x->half, side, x);
}

LANES_INLINE void box_feature_write(const box_feature *x, uint16_t side[3])
{
    const lanes none = {0, 0, 0, 0};
    box_sides_write(lanes_bits(x->side > none), lanes_bits(x->side < none), side);
}

/* Two boxes, and of each the feature that is looked at. */
typedef struct box_meeting {
    const box_lanes *of;
    box_feature a, b;
    lanes at_a, at_b, axis, seen_b; /* at_b in B's frame, as seen_b: the axis' opposite */
    lanes point_b;
} box_meeting;

LANES_INLINE void box_meeting_place_b(box_meeting *m)
{
    m->point_b = m->of->t + lanes3_mul(m->of->axes_b, m->at_b);
}

/* B's corner, and the nearest point of A's feature. */
LANES_INLINE void box_meeting_corner_of_b(box_meeting *m)
{
    m->at_b = m->b.at;
    box_meeting_place_b(m);
    m->at_a = lanes_choose(m->a.between, m->point_b, m->a.at);
    lanes line = m->point_b - m->at_a;
    m->axis = line * (1 / sqrt(lanes_norm2(line)));
    m->seen_b = -lanes3_mul(m->of->rows_b, m->axis);
}

LANES_INLINE void box_meeting_corner_of_a(box_meeting *m)
{
    m->at_a = m->a.at;
    lanes corner = lanes3_mul(m->of->rows_b, m->at_a - m->of->t);
    m->at_b = lanes_choose(m->b.between, corner, m->b.at);
    lanes line = corner - m->at_b;
    m->seen_b = line * (1 / sqrt(lanes_norm2(line)));
    m->axis = -lanes3_mul(m->of->axes_b, m->seen_b);
    box_meeting_place_b(m);
}

/* Two edges: a + s e, b + t f with b - a = r. The axis e x f has no part along e, and is orthogonal to f to the last
 * bit. False when they are almost parallel. */
LANES_INLINE bool box_meeting_of_edges(box_meeting *m)
{
    const lanes one = {1, 1, 1, 1};
    const lanes3 *b = &m->of->axes_b;
    unsigned j = (unsigned)__builtin_ctz(lanes_bits(m->b.between));
    lanes f = j == 0 ? b->x : j == 1 ? b->y : b->z;
    lanes e = (lanes)(m->a.between & (lane_mask)one), g = f - f * e;
    lanes r = m->of->t + lanes3_mul(*b, m->b.at) - m->a.at;
    double sine2 = lanes_norm2(g), along = lanes_sum3(r * f), cosine = lanes_sum3(f * e);
    if (!(sine2 > NEAR_SLIVER2)) return false;
    double s = (lanes_sum3(r * e) - cosine * along) / sine2, t = s * cosine - along;
    m->at_a = lanes_choose(m->a.between, lanes_of(s), m->a.at);
    m->at_b = lanes_choose(m->b.between, lanes_of(t), m->b.at);
    lanes across = lanes_cross(e, g);
    m->axis = across * ((lanes_sum3(across * r) < 0 ? -1 : 1) / sqrt(sine2));
    m->seen_b = -lanes3_mul(m->of->rows_b, m->axis);
    box_meeting_place_b(m);
    return true;
}

LANES_INLINE bool box_meeting_settle(box_meeting *m)
{
    if (m->b.free == 0) {
        box_meeting_corner_of_b(m);
        return m->a.free <= 2;
    }
    if (m->a.free == 0) {
        box_meeting_corner_of_a(m);
        return m->b.free <= 2;
    }
    return m->a.free == 1 && m->b.free == 1 && box_meeting_of_edges(m);
}

LANES_INLINE bool is_of_all_axes(lane_mask m)
{
    return (lanes_bits(m) & 7) == 7;
}

LANES_INLINE bool box_meeting_holds(const box_meeting *m, double size, lane_mask *a, lane_mask *b)
{
    double margin = NEAR_HEIGHT_MARGIN * size;
    *a = box_feature_holds(&m->a, m->at_a, m->axis, margin);
    *b = box_feature_holds(&m->b, m->at_b, m->seen_b, margin);
    return is_of_all_axes(*a & *b & m->a.named & m->b.named);
}

/* The features on from these, until they are strict. Returns after how many steps, or -1. */
LANES_INLINE int box_meeting_descend(double size, int steps, box_meeting *m)
{
    for (int i = 0; box_meeting_settle(m); i++) {
        lane_mask holds_a, holds_b;
        if (box_meeting_holds(m, size, &holds_a, &holds_b)) return i;
        if (i == steps || !is_of_all_axes(m->a.named & m->b.named)) return -1;
        box_feature_step(holds_a, m->at_a, &m->a);
        box_feature_step(holds_b, m->at_b, &m->b);
    }
    return -1;
}

/* The answer by these features, or by those that a descent of a few steps from them ends at, if they are strict: then
 * these are written. `size` is the pair's, in the unit of *of. */
enum { BOX_STEPS = 3 };
LANES_INLINE bool box_facing_of(const box_lanes *of, double size, int steps, narrow_features *f, box_facing *out)
{
    box_meeting m = {.of = of};
    if (f->count_a != 3 || f->count_b != 3) return false;
    box_feature_read(of->half_a, f->a, &m.a);
    box_feature_read(of->half_b, f->b, &m.b);
    int taken = box_meeting_descend(size, steps, &m);
    if (taken < 0) return false;
    out->lo = lanes_sum3(m.axis * of->t - lanes_abs(m.axis) * m.a.half - lanes_abs(m.seen_b) * m.b.half);
    out->hi = sqrt(lanes_norm2(m.point_b - m.at_a));
    if (!(out->lo >= NEAR_LEAST_DISTANCE * size)) return false;
    if (!(out->hi > out->lo)) out->hi = out->lo;
    double norm2 = lanes_norm2(m.axis);
    out->axis = fabs(norm2 - 1) <= 0x1p-50 ? m.axis : m.axis * (1 / sqrt(norm2));
    out->point_a = m.at_a, out->point_b = m.point_b;
    if (taken > 0) box_feature_write(&m.a, f->a), box_feature_write(&m.b, f->b);
    return true;
}

/* Keeps the points if they are nearer to each other, and the axis if it proves a greater distance. Points may lie a
 * little beyond the ends of features that are not strict, so they are moved into their boxes. */
LANES_INLINE void box_facing_keep(const box_meeting *m, box_facing *best)
{
    lanes a = lanes_clamp(m->at_a, m->of->half_a), at_b = lanes_clamp(m->at_b, m->of->half_b);
    lanes b = m->of->t + lanes3_mul(m->of->axes_b, at_b);
    double hi = sqrt(lanes_norm2(b - a)), norm = sqrt(lanes_norm2(m->axis));
    double lo = lanes_sum3(m->axis * m->of->t - lanes_abs(m->axis) * m->a.half - lanes_abs(m->seen_b) * m->b.half);
    if (hi < best->hi) best->hi = hi, best->point_a = a, best->point_b = b;
    if (lo > best->lo) best->lo = lo, best->axis = m->axis * (1 / norm);
}

/* Bounds of the distance whether or not there are strict features: a longer descent from `f`, of which the nearest
 * points and the best axis are kept, until the bounds are as close as `close`. */
enum { BOX_SEARCH_STEPS = 12 };
LANES_INLINE void box_facing_search(
    const box_lanes *of, double size, double close, const narrow_features *f, box_facing *best)
{
    box_meeting m = {.of = of};
    lane_mask holds_a, holds_b;
    box_feature_read(of->half_a, f->a, &m.a);
    box_feature_read(of->half_b, f->b, &m.b);
    for (int i = 0; i < BOX_SEARCH_STEPS && box_meeting_settle(&m); i++) {
        box_facing_keep(&m, best);
        if (best->hi - best->lo <= close || box_meeting_holds(&m, size, &holds_a, &holds_b)) break;
        box_feature_step(holds_a, m.at_a, &m.a);
        box_feature_step(holds_b, m.at_b, &m.b);
    }
}

/* The sides of a box that are on top along a direction, to within half the margin: see box_features_along. */
LANES_INLINE void box_sides_along(lanes half, lanes direction, uint16_t side[3])
{
    const lanes none = {0, 0, 0, 0};
    lane_mask between = (half > none) & (lanes_abs(direction) <= lanes_of(0.5 * NEAR_SINE_MARGIN));
    lane_mask low = (half > none) & ~(direction > none) & ~between;
    box_sides_write(lanes_bits(~(between | low)), lanes_bits(low), side);
}

LANES_INLINE void box_facing_along(const box_lanes *of, lanes axis, narrow_features *f)
{
    *f = (narrow_features){.count_a = 3, .count_b = 3};
    box_sides_along(of->half_a, axis, f->a);
    box_sides_along(of->half_b, -lanes3_mul(of->rows_b, axis), f->b);
}

#endif
