/* wire_check_poses: a batch of poses in which nothing is wrong, told in one pass over each array without a branch a
 * number: they come by the million a second, and almost all of them are so. Pure; any thread. */
#include "wire_rules.h"

#include <math.h>

/* All in -most..most; not a number is not. */
static bool all_within(wire_f64s v, double most)
{
    int64_t outside = 0;
    for (uint32_t i = 0; i < v.count; i++) outside |= fabs(v.at[i]) <= most ? 0 : -1;
    return !outside;
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
        double squared = (q[0] * q[0] + q[1] * q[1]) + (q[2] * q[2] + q[3] * q[3]);
        far |= !(fabs(squared - 1) <= 0.5);
    }
    return !far;
}

bool poses_are_plain(const wire_pose_batch *m)
{
    uint32_t n = m->bodies.count;
    bool whole = n <= WIRE_POSES_MAX && m->positions.count == 3 * n && m->orientations.count == 4 * n &&
                 (!m->linear.count || m->linear.count == 3 * n) && (!m->angular.count || m->angular.count == 3 * n);
    if (m->version != WIRE_VERSION || !m->client || m->sequence < 1 || m->stamp_ns < 0 || !whole || m->teleports.count)
        return false;
    return none_negative(m->bodies) && all_near_unit(m->orientations) && all_within(m->positions, WIRE_POSITION_MAX) &&
           all_within(m->linear, WIRE_SPEED_MAX) && all_within(m->angular, WIRE_SPIN_MAX);
}
