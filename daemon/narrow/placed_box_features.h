/* placed_box_features: the formulas of box_features.c for two boxes where they stand, in lanes: no relative pose is
 * computed. What holds there of strict features and margins holds here, too (near_features.h). Inlined; the same bits
 * however wide the processor is. Pure; any thread.
 *
 * Rounding, as in placed_boxes.c, in u of both half diagonals g and |t|: points by 6.5 (the matrix) and 5.2 (the
 * product), so hi by 11.7 g, and by 2 |t| and what a norm takes. The axis: the frame in which it was found sees it as
 * it is, the world by 11.7, and so that box's heights by 11.7 and 4 g; the other's by 6.5 and 8.2; t by 4, and lo by
 * the 12 that the axis is off unit. Less than 24 of them all. */
#ifndef COLLIDED_NARROW_PLACED_BOX_FEATURES_H
#define COLLIDED_NARROW_PLACED_BOX_FEATURES_H

#include "box_view.h"
#include "near_features.h"

/* What the answer is made of: in the world, from A's centre; lengths times `scale`. */
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

LANES_INLINE double lanes_sum3(lanes v)
{
    return v[0] + v[1] + v[2];
}

LANES_INLINE lanes lanes_cross(lanes a, lanes b)
{
    lanes a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3), a2 = __builtin_shufflevector(a, a, 2, 0, 1, 3);
    lanes b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3), b2 = __builtin_shufflevector(b, b, 2, 0, 1, 3);
    return a1 * b2 - a2 * b1;
}

/* Two boxes, and of each the feature that is looked at. */
typedef struct box_meeting {
    lanes3 axes_a, axes_b, rows_a, rows_b;
    lanes between;
    box_feature a, b;
    lanes at_a, at_b, axis, seen_a, seen_b; /* the axis in the world, in A's frame, and its opposite in B's */
    lanes point_a, point_b;
} box_meeting;

/* B's corner, and the nearest point of A's feature. */
LANES_INLINE void box_meeting_corner_of_b(box_meeting *m)
{
    m->at_b = m->b.at;
    m->point_b = m->between + lanes3_mul(m->axes_b, m->at_b);
    lanes corner = lanes3_mul(m->rows_a, m->point_b);
    m->at_a = lanes_choose(m->a.between, corner, m->a.at);
    lanes line = corner - m->at_a;
    m->seen_a = line * (1 / sqrt(lanes_norm2(line)));
    m->axis = lanes3_mul(m->axes_a, m->seen_a);
    m->seen_b = -lanes3_mul(m->rows_b, m->axis);
    m->point_a = lanes3_mul(m->axes_a, m->at_a);
}

LANES_INLINE void box_meeting_corner_of_a(box_meeting *m)
{
    m->at_a = m->a.at;
    m->point_a = lanes3_mul(m->axes_a, m->at_a);
    lanes corner = lanes3_mul(m->rows_b, m->point_a - m->between);
    m->at_b = lanes_choose(m->b.between, corner, m->b.at);
    lanes line = corner - m->at_b;
    m->seen_b = line * (1 / sqrt(lanes_norm2(line)));
    m->axis = -lanes3_mul(m->axes_b, m->seen_b);
    m->seen_a = lanes3_mul(m->rows_a, m->axis);
    m->point_b = m->between + lanes3_mul(m->axes_b, m->at_b);
}

/* Two edges, in A's frame: a + s e, b + t f with b - a = r. The axis e x f has no part along e, and is orthogonal to f
 * to the last bit. False when they are almost parallel. */
LANES_INLINE bool box_meeting_of_edges(const narrow_placed *b, box_meeting *m)
{
    const lanes one = {1, 1, 1, 1};
    unsigned j = (unsigned)__builtin_ctz(lanes_bits(m->b.between));
    lanes f = lanes3_mul(m->rows_a, lanes_load(&b->turn.x.x + 3 * j));
    lanes e = (lanes)(m->a.between & (lane_mask)one), g = f - f * e;
    lanes r = lanes3_mul(m->rows_a, m->between + lanes3_mul(m->axes_b, m->b.at)) - m->a.at;
    double sine2 = lanes_norm2(g), along = lanes_sum3(r * f), cosine = lanes_sum3(f * e);
    if (!(sine2 > NEAR_SLIVER2)) return false;
    double s = (lanes_sum3(r * e) - cosine * along) / sine2, t = s * cosine - along;
    m->at_a = lanes_choose(m->a.between, lanes_of(s), m->a.at);
    m->at_b = lanes_choose(m->b.between, lanes_of(t), m->b.at);
    lanes across = lanes_cross(e, g);
    m->seen_a = across * ((lanes_sum3(across * r) < 0 ? -1 : 1) / sqrt(sine2));
    m->axis = lanes3_mul(m->axes_a, m->seen_a);
    m->seen_b = -lanes3_mul(m->rows_b, m->axis);
    m->point_a = lanes3_mul(m->axes_a, m->at_a);
    m->point_b = m->between + lanes3_mul(m->axes_b, m->at_b);
    return true;
}

LANES_INLINE bool box_meeting_settle(const narrow_placed *b, box_meeting *m)
{
    if (m->b.free == 0) {
        box_meeting_corner_of_b(m);
        return m->a.free <= 2;
    }
    if (m->a.free == 0) {
        box_meeting_corner_of_a(m);
        return m->b.free <= 2;
    }
    return m->a.free == 1 && m->b.free == 1 && box_meeting_of_edges(b, m);
}

LANES_INLINE bool is_of_all_axes(lane_mask m)
{
    return (lanes_bits(m) & 7) == 7;
}

LANES_INLINE bool box_meeting_holds(const box_meeting *m, double size, lane_mask *a, lane_mask *b)
{
    double margin = NEAR_HEIGHT_MARGIN * size;
    *a = box_feature_holds(&m->a, m->at_a, m->seen_a, margin);
    *b = box_feature_holds(&m->b, m->at_b, m->seen_b, margin);
    return is_of_all_axes(*a & *b & m->a.named & m->b.named);
}

/* The features on from these, until they are strict. Returns after how many steps, or -1. */
LANES_INLINE int box_meeting_descend(const narrow_placed *b, double size, int steps, box_meeting *m)
{
    for (int i = 0; box_meeting_settle(b, m); i++) {
        lane_mask holds_a, holds_b;
        if (box_meeting_holds(m, size, &holds_a, &holds_b)) return i;
        if (i == steps || !is_of_all_axes(m->a.named & m->b.named)) return -1;
        box_feature_step(holds_a, m->at_a, &m->a);
        box_feature_step(holds_b, m->at_b, &m->b);
    }
    return -1;
}

/* The answer by these features, or by those that a descent of a few steps from them ends at, if they are strict: then
 * these are written. `size` is the pair's, times `scale`. */
enum { BOX_STEPS = 3 };
LANES_INLINE bool placed_box_facing(const narrow_placed *a, const narrow_placed *b, double scale, double size,
    int steps, narrow_features *f, box_facing *out)
{
    box_meeting m = {.axes_a = box_view_axes(a), .axes_b = box_view_axes(b)};
    if (f->count_a != 3 || f->count_b != 3) return false;
    m.rows_a = lanes3_transposed(m.axes_a), m.rows_b = lanes3_transposed(m.axes_b);
    m.between = (lanes_load(&b->at.p.x) - lanes_load(&a->at.p.x)) * scale;
    box_feature_read(lanes_load(&a->half.x) * scale, f->a, &m.a);
    box_feature_read(lanes_load(&b->half.x) * scale, f->b, &m.b);
    int taken = box_meeting_descend(b, size, steps, &m);
    if (taken < 0) return false;
    out->lo = lanes_sum3(m.axis * m.between - lanes_abs(m.seen_a) * m.a.half - lanes_abs(m.seen_b) * m.b.half);
    out->hi = sqrt(lanes_norm2(m.point_b - m.point_a));
    if (!(out->lo >= NEAR_LEAST_DISTANCE * size)) return false;
    if (!(out->hi > out->lo)) out->hi = out->lo;
    double norm2 = lanes_norm2(m.axis);
    out->axis = fabs(norm2 - 1) <= 0x1p-50 ? m.axis : m.axis * (1 / sqrt(norm2));
    out->point_a = m.point_a, out->point_b = m.point_b;
    if (taken > 0) box_feature_write(&m.a, f->a), box_feature_write(&m.b, f->b);
    return true;
}

#endif
