/* rough_depth: that two cores overlap, and about how deep, from where GJK ended: for who asks for no more. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_ROUGH_DEPTH_H
#define COLLIDED_NARROW_ROUGH_DEPTH_H

#include "gjk.h"

/* Of the pair's size: a tolerance that is looser than this is tried for roughly before a search begins. */
#define ROUGH_TOLERANCE 0x1p-2

/* True when the bounds are enough for the goal: GJK's tetrahedron holds the origin, so that the ball up to its nearest
 * face is in B - A; and each face's normal is an axis along which the overlap ends. The points are the deepest along
 * the axis. False: *out is as it was. */
bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

#endif
