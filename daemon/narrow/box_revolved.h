/* box_revolved: the depth of a box and an overlapping cylinder or cone. It is found on three great circles of
 * directions, on one small circle or along the axis, with a proof; box_revolved.c derives it. Pure; any thread. */
#ifndef COLLIDED_NARROW_BOX_REVOLVED_H
#define COLLIDED_NARROW_BOX_REVOLVED_H

#include "unit_pair.h"

/* False when the cores do not overlap by 2^-24 of the pair's size, or when the search did not reach the goal:
 * then out->axis is zero, and nothing else of *out is written. */
bool box_revolved_measure(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
