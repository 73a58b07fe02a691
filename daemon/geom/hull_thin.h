/* hull_thin: fewer points, none of which are close to each other. Any thread. */
#ifndef COLLIDED_GEOM_HULL_THIN_H
#define COLLIDED_GEOM_HULL_THIN_H

#include "vec.h"

#include <stdint.h>

/* Writes the numbers of points that are all at least `apart` from each other, and such that each one left out is nearer
 * than 3 `apart` to one of them; returns how many. At most 65,536 points, no coordinate beyond 2^15 times `apart`. */
uint32_t hull_thin(const vec3 *at, uint32_t count, double apart, uint32_t *kept);

#endif
