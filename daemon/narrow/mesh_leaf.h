/* mesh_leaf: the parts in two leaves, or in one and a convex core. For mesh_walk.c. Pure; any thread. */
#ifndef COLLIDED_NARROW_MESH_LEAF_H
#define COLLIDED_NARROW_MESH_LEAF_H

#include "mesh_walk.h"

/* Visits the pairs of parts that are not proven to be farther apart than w->within; `box_a` is of no meaning when all
 * of a convex A is the only part. False: the visitor has had enough. */
bool mesh_leaves_visit(mesh_walk *w, mesh_box box_a, mesh_box box_b, mesh_visit *visit, void *context);

/* A first direction from A to B, of any length, that belongs to the two parts alone. */
vec3 mesh_spots_lead(const mesh_spot *a, const mesh_spot *b, bool triangles);

#endif
