/* toi_truth: the march. */
#include "toi_truth.h"

enum { STEPS_MAX = 2000000, PROBES = 28 };

static const double NEAR = 1e-9;      /* of the size: there the march ends, and contact is looked for */
static const double BRACKET = 0x1p-8; /* of the span: within so much of the end of the march, at most */

narrow_result toi_truth_at(
    const toi_mover *a, const toi_mover *b, double time, double tolerance, narrow_scratch *scratch)
{
    narrow_request r = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    pose at_a = pose_mul(motion_pose(&a->motion, time), a->local);
    pose at_b = pose_mul(motion_pose(&b->motion, time), b->local);
    narrow_result n;
    narrow_query_world(a->shape, at_a, b->shape, at_b, &r, scratch, &n);
    return n;
}

static double reach_of(const toi_mover *m)
{
    return vec_norm(m->local.p) + (m->shape->type == SHAPE_HALFSPACE ? 0 : shape_reach(m->shape));
}

double toi_truth_size(const toi_mover *a, const toi_mover *b)
{
    return reach_of(a) + reach_of(b);
}

/* m/s. A plane is as fast as it turns times the distance of what it may meet. */
static double speed_of(const toi_mover *a, const toi_mover *b, double span)
{
    double line = vec_norm(vec_sub(a->motion.linear, b->motion.linear));
    double far = vec_norm(vec_sub(a->motion.start.p, b->motion.start.p)) + line * span + reach_of(a) + reach_of(b);
    double arm_a = a->shape->type == SHAPE_HALFSPACE ? far : reach_of(a);
    double arm_b = b->shape->type == SHAPE_HALFSPACE ? far : reach_of(b);
    return (line + vec_norm(a->motion.angular) * arm_a + vec_norm(b->motion.angular) * arm_b) * (1 + 1e-9);
}

toi_truth toi_truth_of(const toi_mover *a, const toi_mover *b, double span, narrow_scratch *scratch)
{
    double size = toi_truth_size(a, b), speed = speed_of(a, b, span), time = 0;
    toi_truth t = {.verdict = TRUTH_UNCLEAR, .nearest = INFINITY};
    for (int k = 0; k < STEPS_MAX; k++) {
        narrow_result n = toi_truth_at(a, b, time, 0.1 * NEAR * size, scratch);
        t.lo = time;
        if (n.lo <= NEAR * size) break;
        double left = span - time, step = speed > 0 ? fmin(0.8 * n.lo / speed, left) : left;
        t.nearest = fmin(t.nearest, n.lo - speed * step); /* on the way to the next it sinks by no more */
        if (time >= span) {
            t.verdict = TRUTH_FREE;
            return t;
        }
        time = step < left ? time + step : span;
    }
    for (int k = 0; k <= PROBES; k++) {
        double time_then = fmin(t.lo + (k ? span * BRACKET * exp2(k - PROBES) : 0), span);
        if (!(toi_truth_at(a, b, time_then, 0, scratch).hi <= 0)) continue;
        t.hi = time_then;
        t.verdict = TRUTH_HIT;
        break;
    }
    return t;
}
