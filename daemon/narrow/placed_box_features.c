/* placed_box_features: the same for near_features.c, which tries features one by one. Pure; any thread. */
#include "placed_box_features.h"

LANES_INLINE bool span_of(const unit_pair *p, const narrow_features *f, span *out)
{
    box_facing m;
    narrow_features same = *f;
    if (!placed_box_facing(p->stand->a, p->stand->b, p->scale, p->size, 0, &same, &m)) return false;
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

bool placed_box_features_span(const unit_pair *p, const narrow_features *f, span *out)
{
    return (lanes_wide() ? span_wide : span_narrow)(p, f, out);
}
