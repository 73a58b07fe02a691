/* mesh_part: the distance of the two parts that a walk visits. Pure; any thread. */
#ifndef COLLIDED_NARROW_MESH_PART_H
#define COLLIDED_NARROW_MESH_PART_H

#include "mesh_walk.h"

/* As gjk_distance, from what belongs to the parts alone (w->lead, w->from, w->edges): so the answer about two parts
 * does not depend on which others were looked at before. */
void mesh_part_distance(const mesh_walk *w, const narrow_goal *goal, span *out);

#endif
