/* impact_truth: the march. */
#include "impact_truth.h"

#include "impact_scene.h"
#include "narrow/narrow.h"

#include <math.h>
#include <stdlib.h>

enum { STEPS_MAX = 2000000, PROBES = 24 };

static const double NEAR = 1e-9;      /* of the size: there the march ends, and contact is looked for */
static const double BRACKET = 0x1p-8; /* s, of the span: within so much of the end of the march, at most */

static narrow_result between(const impact_item *item, const shape shapes[2], double time, double tolerance)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    motion a = impact_scene_motion(&item->move_a), b = impact_scene_motion(&item->move_b);
    narrow_request r = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result n;
    narrow_query_world(&shapes[0], motion_pose(&a, time), &shapes[1], motion_pose(&b, time), &r, scratch, &n);
    return n;
}

static double speed_of(const impact_item *item, const shape shapes[2])
{
    motion a = impact_scene_motion(&item->move_a), b = impact_scene_motion(&item->move_b);
    double turning = vec_norm(a.angular) * shape_reach(&shapes[0]) + vec_norm(b.angular) * shape_reach(&shapes[1]);
    return (vec_norm(vec_sub(a.linear, b.linear)) + turning) * (1 + 1e-9);
}

/* From where they are as near as the march goes: ever farther, until they overlap. */
static void find_contact(const impact_item *item, const shape shapes[2], impact_truth *t)
{
    for (int k = 0; k < PROBES; k++) {
        double time = fmin(t->lo + item->span * BRACKET * exp2(k - PROBES + 1), item->span);
        if (!(between(item, shapes, time, 0).hi <= 0)) continue;
        t->hi = time;
        t->verdict = IMPACT_HIT;
        return;
    }
}

impact_truth impact_truth_of(const impact_item *item)
{
    shape shapes[2] = {narrow_scene_shape(item->a), narrow_scene_shape(item->b)};
    double size = shape_reach(&shapes[0]) + shape_reach(&shapes[1]), speed = speed_of(item, shapes), time = 0;
    impact_truth t = {.verdict = IMPACT_UNCLEAR, .nearest = INFINITY};
    for (int k = 0; k < STEPS_MAX; k++) {
        double gap = between(item, shapes, time, 0.1 * NEAR * size).lo;
        t.lo = time;
        t.nearest = fmin(t.nearest, 0.5 * gap); /* between two distances it sinks by no more than half */
        if (gap <= NEAR * size) {
            if (time > 0) find_contact(item, shapes, &t);
            return t;
        }
        double step = 0.5 * gap / speed;
        if (time >= item->span) {
            t.verdict = IMPACT_FREE;
            return t;
        }
        time = fmin(time + step, item->span);
    }
    return t;
}
