/* box_facing: the same for near_features.c, which tries features one by one. Pure; any thread. */
#include "box_facing.h"

LANES_INLINE bool span_of(const unit_pair *p, const narrow_features *f, span *out)
{
    const struct {
        vec3 half_a, half_b, t;
        double after;
    } x = {p->a.half, p->b.half, p->b_in_a.t, 0};
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

LANES_WHOLE static bool span_wide(const unit_pair *p, const narrow_features *f, span *out)
{
    return span_of(p, f, out);
}

static bool span_narrow(const unit_pair *p, const narrow_features *f, span *out)
{
    return span_of(p, f, out);
}

bool box_facing_span(const unit_pair *p, const narrow_features *f, span *out)
{
    return (lanes_wide() ? span_wide : span_narrow)(p, f, out);
}
