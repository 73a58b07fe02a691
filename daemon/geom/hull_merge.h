/* hull_merge: one face where triangles of a hull lie in one plane. Any thread. */
#ifndef COLLIDED_GEOM_HULL_MERGE_H
#define COLLIDED_GEOM_HULL_MERGE_H

#include "hull_loops.h"

/* `triangles` of a closed surface, and *out: loops around those that are in one plane but for `tolerance`. Corners
 * where only two faces meet are left out of both. False: some face is not one closed loop, or has no corners left. */
bool hull_merge(const vec3 *points, uint32_t count, const hull_loops *triangles, double tolerance, hull_loops *out);

#endif
