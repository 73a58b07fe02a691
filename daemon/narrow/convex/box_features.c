/* box_features: the features of two boxes, or of a capsule and a box, for near_features.c, which tries them one by one.
 * Pure; any thread. */
#include "box_facing.h"
#include "features.h"
#include "narrow/math/scalar.h"

/* The sides of a box, or of the segment that is a capsule's core; a number follows each vector. */
LANES_INLINE bool box_features_answer(const unit_pair *p, const narrow_features *f, span *out)
{
    const struct {
        vec3 half_a, half_b, t;
        double after;
    } x = {shape_core_half(&p->a), p->b.half, p->b_in_a.t, 0};
    const struct {
        mat3 turn;
        double after;
    } b = {p->b_in_a.r, 0};
    box_lanes of = box_lanes_of(&x.half_a, &x.half_b, &x.t, &b.turn, 1);
    box_facing m;
    narrow_features same = *f;
    if (!box_facing_of(&of, p->size, 0, &same, &m)) return false;
    out->lo = m.lo, out->hi = m.hi;
    out->axis = vec(m.axis[0], m.axis[1], m.axis[2]);
    out->point_a = vec(m.point_a[0], m.point_a[1], m.point_a[2]);
    out->point_b = vec(m.point_b[0], m.point_b[1], m.point_b[2]);
    out->method = NARROW_BY_SAT;
    return true;
}

LANES_TWINS(LANES_WHOLE, bool, span, box_features_answer, (const unit_pair *p, const narrow_features *f, span *out),
    (p, f, out));

bool box_features_span(const unit_pair *p, const narrow_features *f, span *out)
{
    return LANES_CHOSEN(span)(p, f, out);
}

static void box_features_sides_along(const shape *s, vec3 d, uint16_t side[3], uint8_t *count)
{
    double half[3], along[3];
    vec_to(shape_core_half(s), half);
    vec_to(d, along);
    for (int i = 0; i < 3; i++) {
        bool between = half[i] > 0 && fabs(along[i]) <= 0.5 * NEAR_SINE_MARGIN;
        side[i] = between ? NEAR_BETWEEN : half[i] == 0 || along[i] > 0 ? NEAR_HIGH : NEAR_LOW;
    }
    *count = 3;
}

void box_features_along(const unit_pair *p, vec3 axis, narrow_features *out)
{
    box_features_sides_along(&p->a, axis, out->a, &out->count_a);
    box_features_sides_along(&p->b, mat_tmul(p->b_in_a.r, vec_neg(axis)), out->b, &out->count_b);
}
