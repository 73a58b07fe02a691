/* toi_spheres: two balls whose centres move along straight lines: a quadratic equation, proven at both ends. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_TOI_SPHERES_H
#define COLLIDED_NARROW_TOI_SPHERES_H

#include "toi.h"

/* True if it settled it: *out as toi_find has it, without the bodies' poses. False for all else, and where they touch
 * at the beginning, graze, or are of a size whose squares leave the range of doubles. */
bool toi_spheres(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

#endif
