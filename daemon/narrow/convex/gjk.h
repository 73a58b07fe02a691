/* gjk: the distance of two convex cores, bracketed by a duality gap.
 *
 * Gilbert, Johnson, Keerthi 1988, on B - A in A's frame. `lo` is the best support-plane separation seen, `hi` the least
 * |point of B - A| seen: both hold at every iteration, so it never fails, it only stops. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_GJK_H
#define COLLIDED_NARROW_CONVEX_GJK_H

#include "narrow/pair/unit_pair.h"
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

/* ---- rough depth ---- */

/* That two cores overlap, and about how deep, from where GJK ended: for who asks for no more. */

/* True when the bounds are enough for the goal: GJK's tetrahedron holds the origin, so that the ball up to its nearest
 * face is in B - A; and each face's normal is an axis along which the overlap ends. The points are the deepest along
 * the axis. False: *out is as it was. */
bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* ---- moved apart ---- */

/* A better axis for two cores that overlap by almost nothing, where a search for their depth ended early: the origin
 * lies on the surface of B - A, and a polytope grown there is all slivers. */

/* Raises the lower bound of a pair whose interval is wide, and replaces its axis, if an axis is found that proves more.
 */
void moved_apart_raise(const unit_pair *p, span *s);

#endif
