/* impact_axis: a direction along which two moving shapes stay apart, for the next tick to try first: there, two support
 * queries a shape prove what took a search in this one.
 *
 * The distance of convex shapes that move in straight lines is convex in time, so that the axis at its least value
 * keeps them apart all along. Its tangents (the gaps along the axes that were found) bracket that time: cutting planes.
 * What is proposed is tested before it is believed (toi_find), so that nothing rests on it, and for shapes that turn it
 * may do as well. Pure; any thread, each with its own scratch. */
#include "state.h"

enum { LOOKS_MAX = 4 };

typedef struct tangent {
    double time, gap, rate; /* s, m, m/s */
} tangent;

static vec3 velocity(const motion *m, pose at, vec3 point)
{
    return vec_add(m->linear, vec_cross(m->angular, vec_sub(point, at.p)));
}

/* Of the distance at a time, with the axis there. */
static tangent look(const toi_mover *a, const toi_mover *b, double time, double tolerance, void *scratch, vec3 *axis)
{
    pose body_a = motion_pose(&a->motion, time), body_b = motion_pose(&b->motion, time);
    pose at_a = pose_mul(body_a, a->local), at_b = pose_mul(body_b, b->local);
    narrow_request ask = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result n;
    narrow_query_world(a->shape, at_a, b->shape, at_b, &ask, scratch, &n);
    vec3 point_a = vec_add(n.point_a, at_a.p), point_b = vec_add(n.point_b, at_a.p);
    *axis = n.axis;
    return (tangent){time, n.lo,
        vec_dot(n.axis, vec_sub(velocity(&b->motion, body_b, point_b), velocity(&a->motion, body_a, point_a)))};
}

static double least_at_ends(tangent t, const toi_request *r)
{
    double floor = r->threshold + 2 * r->tolerance, drift = 0.5 * r->wander * r->span * r->span;
    return fmin(t.gap - t.rate * t.time - floor, t.gap + t.rate * (r->span - t.time) - floor - drift);
}

/* When the origins are nearest. */
static double nearest_approach(const toi_mover *a, const toi_mover *b, double span)
{
    vec3 apart = vec_sub(b->motion.start.p, a->motion.start.p), v = vec_sub(b->motion.linear, a->motion.linear);
    double speed2 = vec_norm2(v);
    return speed2 > 0 ? fmin(fmax(-vec_dot(apart, v) / speed2, 0), span) : 0;
}

vec3 impact_axis(const toi_mover *a, const toi_mover *b, const toi_request *request, void *scratch, uint32_t *queries)
{
    if (toi_parts_apply(a->shape, b->shape)) return VEC_ZERO;
    double span = request->span, time = nearest_approach(a, b, span), width = request->tolerance;
    tangent before = {0, INFINITY, 0}, after = {span, INFINITY, 0};
    for (int k = 0; k < LOOKS_MAX; k++) {
        vec3 axis;
        tangent t = look(a, b, time, width, scratch, &axis);
        ++*queries;
        if (t.gap <= request->threshold) return VEC_ZERO;
        if (least_at_ends(t, request) > 0) return axis;
        *(t.rate < 0 ? &before : &after) = t;
        double steeper = after.rate - before.rate;
        bool both = isfinite(before.gap) && isfinite(after.gap) && steeper > 0;
        double meet = both ? (before.gap - before.rate * before.time - after.gap + after.rate * after.time) / steeper
                           : 0.5 * (before.time + after.time);
        time = fmin(fmax(meet, before.time), after.time);
    }
    return VEC_ZERO;
}
