/* toi_walk: the time of impact of shapes of which one or both are made of parts. Pure; any thread. */
#ifndef COLLIDED_NARROW_TOI_WALK_H
#define COLLIDED_NARROW_TOI_WALK_H

#include "narrow.h"
#include "toi_request.h"

/* As toi_find, for shapes to which toi_parts_apply; the poses at lo are not filled in. */
void toi_walk(
    const toi_mover *a, const toi_mover *b, const toi_request *request, narrow_scratch *scratch, toi_result *out);

/* toi_find of two convex shapes in canonical order; *out is left as it is where they are free. `from`: they are proven
 * to be free before. `rough`: within the tolerance is as good as contact, and no proof of it is looked for. */
void toi_convex(const toi_mover *a, const toi_mover *b, const toi_request *request, vec3 guess, double from, bool rough,
    narrow_scratch *scratch, toi_result *out);

#endif
