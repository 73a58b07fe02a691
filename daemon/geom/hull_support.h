/* hull_support: the farthest vertex of a hull, by scan or by a tree of boxes; both give the same vertex. */
#ifndef COLLIDED_GEOM_HULL_SUPPORT_H
#define COLLIDED_GEOM_HULL_SUPPORT_H

#include "hull.h"

enum { HULL_NO_START = 0x7fffffff }; /* no vertex to start from is known */

/* The least index among the vertices with the greatest computed dot(direction, v). `start` is tried first: a good one
 * makes it quick, none changes the answer. */
uint32_t hull_support(const hull *h, vec3 direction, uint32_t start);

/* Fills nodes and node_vertices once the vertices are there. */
void hull_tree_build(hull *h);

#endif
