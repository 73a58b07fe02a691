/* gjk: the distance of two convex cores, bracketed by a duality gap.
 *
 * Gilbert, Johnson, Keerthi 1988, on B - A in A's frame. `lo` is the best support-plane separation seen, `hi` the least
 * |point of B - A| seen: both hold at every iteration, so it never fails, it only stops. Pure; any thread. */
#ifndef COLLIDED_NARROW_GJK_H
#define COLLIDED_NARROW_GJK_H

#include "simplex.h"

typedef enum gjk_state {
    GJK_APART, /* the span is the distance (or enough for the goal) */
    GJK_TOUCH, /* the origin is within rounding of the simplex, or no progress could be made: depth decides */
    GJK_INSIDE /* the simplex has four points and holds the origin */
} gjk_state;

typedef struct gjk_result {
    gjk_state state;
    span span;
    simplex simplex;
} gjk_result;

/* `seed`: the first axis to try, unit, or zero for the line of the centres. */
void gjk_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);

#endif
