/* wire_check_poses: a batch of poses in which nothing is wrong, told in one pass over each array without a branch a
 * number: they come by the million a second, and almost all of them are so. Pure; any thread. */
#include "wire_rules.h"

#include <math.h>

/* Four doubles side by side, wherever they lie: one register or two, as the processor has them. */
typedef double four __attribute__((vector_size(32)));
typedef double four_anywhere __attribute__((vector_size(32), aligned(8), may_alias));
typedef int64_t four_masks __attribute__((vector_size(32))); /* -1 or 0 each */

/* All in -most..most; not a number is not. */
static inline __attribute__((always_inline)) bool all_within(wire_f64s v, double most)
{
    const four_masks magnitude = {INT64_MAX, INT64_MAX, INT64_MAX, INT64_MAX};
    const four limit = {most, most, most, most};
    four_masks within = {-1, -1, -1, -1};
    uint32_t i = 0;
    bool rest = true;
    for (; i + 4 <= v.count; i += 4) {
        four_masks bits = (four_masks) * (const four_anywhere *)(v.at + i);
        within &= (four)(bits & magnitude) <= limit;
    }
    for (; i < v.count; i++) rest &= fabs(v.at[i]) <= most;
    return rest && (within[0] & within[1] & within[2] & within[3]);
}

static bool none_negative(wire_i32s v)
{
    int32_t all = 0;
    for (uint32_t i = 0; i < v.count; i++) all |= v.at[i];
    return all >= 0;
}

/* Well within what check_rotation allows: however it rounds. */
static inline __attribute__((always_inline)) bool all_near_unit(wire_f64s v)
{
    bool far = false;
    for (uint32_t i = 0; i + 4 <= v.count; i += 4) {
        four q = *(const four_anywhere *)(v.at + i), squares = q * q;
        double squared = (squares[0] + squares[2]) + (squares[1] + squares[3]);
        far |= !(fabs(squared - 1) <= 0.5);
    }
    return !far;
}

static inline __attribute__((always_inline)) bool numbers_are_plain(const wire_pose_batch *m)
{
    return all_near_unit(m->orientations) && all_within(m->positions, WIRE_POSITION_MAX) &&
           all_within(m->linear, WIRE_SPEED_MAX) && all_within(m->angular, WIRE_SPIN_MAX);
}

#if defined(__x86_64__)

__attribute__((target("avx2"))) static bool check_avx2(const wire_pose_batch *m)
{
    return numbers_are_plain(m);
}

static bool check_pose_numbers(const wire_pose_batch *m)
{
    return __builtin_cpu_supports("avx2") ? check_avx2(m) : numbers_are_plain(m);
}

#else

static bool check_pose_numbers(const wire_pose_batch *m)
{
    return numbers_are_plain(m);
}

#endif

bool poses_are_plain(const wire_pose_batch *m)
{
    uint32_t n = m->bodies.count;
    bool whole = n <= WIRE_POSES_MAX && m->positions.count == 3 * n && m->orientations.count == 4 * n &&
                 (!m->linear.count || m->linear.count == 3 * n) && (!m->angular.count || m->angular.count == 3 * n);
    if (m->version != WIRE_VERSION || !m->client || m->sequence < 1 || m->stamp_ns < 0 || m->simulation_ns < 0 ||
        !whole || m->teleports.count || m->extensions.count)
        return false;
    return none_negative(m->bodies) && check_pose_numbers(m);
}
