/* revolved_pair: the depth of two overlapping bodies of revolution about axes that are not parallel: cylinders, cones
 * and capsules. A search over two cosines, with a proof; revolved_pair.c derives it. Pure; any thread. */
#ifndef COLLIDED_NARROW_REVOLVED_PAIR_H
#define COLLIDED_NARROW_REVOLVED_PAIR_H

#include "unit_pair.h"

/* False when the cores do not overlap by a tenth of the pair's size, when the axes are nearly parallel, or when the
 * search reached neither the goal nor what its rounding leaves, 2^-50 (64 + 16 / sine) of the size, of the sine of the
 * angle between the axes: then out->axis is zero, and nothing else of *out is written. */
bool revolved_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
