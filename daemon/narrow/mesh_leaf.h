/* mesh_leaf: the parts in two leaves, or in one and a convex core. For mesh_walk.c. Pure; any thread. */
#ifndef COLLIDED_NARROW_MESH_LEAF_H
#define COLLIDED_NARROW_MESH_LEAF_H

#include "mesh_place.h"

/* Visits the pairs of parts that are not proven to be farther apart than w->within; `box_a` is of no meaning when all
 * of a convex A is the only part. False: the visitor has had enough. */
bool mesh_leaves_visit(mesh_walk *w, mesh_box box_a, mesh_box box_b, mesh_visit *visit, void *context);

/* As if these two parts were visited, however far they are; A's triangle only where A is a mesh. */
void mesh_leaf_visit_alone(mesh_walk *w, uint32_t triangle_a, uint32_t triangle_b);

#endif
