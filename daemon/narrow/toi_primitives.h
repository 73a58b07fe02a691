/* toi_primitives: the time of impact of two balls, and of a ball and a box, that do not turn towards each other, in
 * closed form. Pure. */
#ifndef COLLIDED_NARROW_TOI_PRIMITIVES_H
#define COLLIDED_NARROW_TOI_PRIMITIVES_H

#include "toi_request.h"

/* ---- two balls, whose centres move along straight lines: a quadratic equation, proven at both ends ---- */

/* True if it settled it: *out as toi_find has it, without the bodies' poses. False for all else, and where they touch
 * at the beginning, graze, or are of a size whose squares leave the range of doubles. */
bool toi_spheres(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

/* ---- a ball and a box ---- */

/* True: *out is the answer (toi_find fills in the bodies' poses). False: not such a pair, or one that begins in
 * contact, hardly moves, grazes or touches within rounding only: to be searched. */
bool toi_ball_box(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

#endif
