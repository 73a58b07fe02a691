/* wire_check_poses: a batch of poses in which nothing is wrong, told in one pass over each array without a branch a
 * number: they come by the million a second, and almost all of them are so. Pure; any thread. */
#include "wire_rules.h"

#include <math.h>

/* Two doubles side by side, wherever they lie. */
typedef double two __attribute__((vector_size(16)));
typedef double two_anywhere __attribute__((vector_size(16), aligned(8), may_alias));
typedef int64_t two_masks __attribute__((vector_size(16))); /* -1 or 0 each */

/* All in -most..most; not a number is not. */
static bool all_within(wire_f64s v, double most)
{
    const two_masks magnitude = {INT64_MAX, INT64_MAX};
    const two limit = {most, most};
    two_masks within = {-1, -1};
    uint32_t i = 0;
    for (; i + 2 <= v.count; i += 2) {
        two_masks bits = (two_masks) * (const two_anywhere *)(v.at + i);
        within &= (two)(bits & magnitude) <= limit;
    }
    bool last = i == v.count || fabs(v.at[i]) <= most;
    return last && (within[0] & within[1]);
}

static bool none_negative(wire_i32s v)
{
    int32_t all = 0;
    for (uint32_t i = 0; i < v.count; i++) all |= v.at[i];
    return all >= 0;
}

/* Well within what check_rotation allows: however it rounds. */
static bool all_near_unit(wire_f64s v)
{
    bool far = false;
    for (uint32_t i = 0; i + 4 <= v.count; i += 4) {
        const double *q = v.at + i;
        two a = *(const two_anywhere *)q, b = *(const two_anywhere *)(q + 2), sums = a * a + b * b;
        double squared = sums[0] + sums[1];
        far |= !(fabs(squared - 1) <= 0.5);
    }
    return !far;
}

bool poses_are_plain(const wire_pose_batch *m)
{
    uint32_t n = m->bodies.count;
    bool whole = n <= WIRE_POSES_MAX && m->positions.count == 3 * n && m->orientations.count == 4 * n &&
                 (!m->linear.count || m->linear.count == 3 * n) && (!m->angular.count || m->angular.count == 3 * n);
    if (m->version != WIRE_VERSION || !m->client || m->sequence < 1 || m->stamp_ns < 0 || m->simulation_ns < 0 ||
        !whole || m->teleports.count)
        return false;
    return none_negative(m->bodies) && all_near_unit(m->orientations) && all_within(m->positions, WIRE_POSITION_MAX) &&
           all_within(m->linear, WIRE_SPEED_MAX) && all_within(m->angular, WIRE_SPIN_MAX);
}
