/* toi_boxes: for how long two moving balls, capsules or boxes are certainly apart, by separating axes alone. Pure. */
#ifndef COLLIDED_NARROW_TOI_BOXES_H
#define COLLIDED_NARROW_TOI_BOXES_H

#include "course.h"

/* A ball, capsule or box, and a capsule or box, of sizes whose squares are in the range of doubles? */
bool toi_boxes_apply(const course *c);

/* Searches from `from` on, until when they are apart. INFINITY: *out is the answer, FREE as it was, HIT, or NEAR if
 * that is enough (`rough`), with points relative to A's body as it starts. Otherwise a time up to which they are apart,
 * within the tolerance of contact if they are sharp: for the search to go on from. Only if toi_boxes_apply, and for a
 * threshold that is not negative. */
double toi_boxes_march(const course *c, const toi_request *request, double from, bool rough, toi_result *out);

#endif
