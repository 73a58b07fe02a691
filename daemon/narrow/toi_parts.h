/* toi_parts: the time of impact of convex parts, for all that is made of them. Pure; any thread. */
#ifndef COLLIDED_NARROW_TOI_PARTS_H
#define COLLIDED_NARROW_TOI_PARTS_H

#include "course.h"

/* As toi_find for two convex shapes, relative to the frame of the course (positions are not yet the world's); *out is
 * left as it is where they are free. */
void toi_convex(const course *c, const toi_request *request, vec3 guess, narrow_scratch *scratch, toi_result *out);

#endif
