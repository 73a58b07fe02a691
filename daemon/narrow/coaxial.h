/* coaxial: the depth of two cores that share their axis of revolution, where a whole ring of directions is equally deep
 * and a polytope grown from inside converges slowly. Pure; any thread. */
#ifndef COLLIDED_NARROW_COAXIAL_H
#define COLLIDED_NARROW_COAXIAL_H

#include "unit_pair.h"

/* Narrows the bounds of overlapping cores, if they are capsules, cylinders or cones on one axis to within rounding. */
void coaxial_depth(const unit_pair *p, span *s);

#endif
