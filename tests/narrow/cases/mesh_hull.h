/* mesh_hull: meshes that are convex and closed may stand for their hull; all others are for the mesh engine. */
#ifndef COLLIDED_TESTS_CASES_MESH_HULL_H
#define COLLIDED_TESTS_CASES_MESH_HULL_H

#include "subject.h"

/* Every edge has its reverse, and no vertex lies outside the plane of a triangle, in 113 bits. `triangles`: three
 * vertex numbers each. */
bool mesh_is_convex_solid(const double *vertices, size_t vertex_count, const double *triangles, size_t triangle_count);

/* "lat-long sphere radius 2, 32 x 32", or "same, radius 1" with the divisions of the last one. NULL, or why not. */
const char *mesh_from_text(subject *s, const char *text);

#endif
