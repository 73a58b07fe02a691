/* cylinder_pair: the depth of two overlapping cylinders, or of a cylinder and a capsule, about axes that are not
 * parallel. It is found on two great circles of directions, along the axes, or between two rims, with a proof;
 * cylinder_pair.c derives it. Pure; any thread. */
#ifndef COLLIDED_NARROW_CYLINDER_PAIR_H
#define COLLIDED_NARROW_CYLINDER_PAIR_H

#include "unit_pair.h"

/* What that leaves open revolved_pair.h is asked about: false as there. */
bool cylinder_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
