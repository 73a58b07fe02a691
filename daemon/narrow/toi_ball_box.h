/* toi_ball_box: the time of impact of a ball and a box that do not turn towards each other, in closed form. Pure. */
#ifndef COLLIDED_NARROW_TOI_BALL_BOX_H
#define COLLIDED_NARROW_TOI_BALL_BOX_H

#include "toi.h"

/* True: *out is the answer (toi_find fills in the bodies' poses). False: not such a pair, or one that begins in
 * contact, hardly moves, grazes or touches within rounding only: to be searched. */
bool toi_ball_box(const toi_mover *a, const toi_mover *b, const toi_request *request, toi_result *out);

#endif
