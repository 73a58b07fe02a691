/* mesh_walk: all pairs of parts of two shapes that may be near each other, one of them or both a mesh.
 *
 * The parts of a mesh are its triangles, a convex core is its own only part. The hierarchies are walked together; what
 * is proven to be farther apart than `within` is left out, along the directions of mesh_bounds or the axis that the
 * visitor has found last. The stack is on the stack: its depth follows from MESH_DEPTH_MAX; so is the queue of the walk
 * that goes nearest first, and what it has no room for is walked depth first. Pure; any thread. */
#ifndef COLLIDED_NARROW_TREE_MESH_WALK_H
#define COLLIDED_NARROW_TREE_MESH_WALK_H

#include "mesh_place.h"

/* Visits all pairs of parts that may be within w->within. */
void mesh_walk_run(mesh_walk *w, mesh_visit *visit, void *context);

/* The nearest boxes first of all; `from`, or NULL: where to begin. */
void mesh_walk_nearest(mesh_walk *w, const mesh_front *from, mesh_visit *visit, void *context);

/* Visits the parts of two leaves that are likely to be near each other. What it finds, and where, is a matter of the
 * shapes and their poses. False: the visitor has had enough. */
bool mesh_walk_plunge(mesh_walk *w, mesh_visit *visit, void *context);

/* How many pairs of leaves there are. */
double mesh_walk_leaves(const mesh_walk *w);

/* Are there at most so many below those boxes that are near? They are opened level by level; a walk from *front visits
 * no others. */
bool mesh_walk_is_short(mesh_walk *w, double leaves, mesh_front *front);

/* Is no box of the other mesh's leaves near this box of A or of B? `child` of `node`, which is no leaf's. Both are
 * meshes; what counts as near is `within`. */
bool mesh_walk_is_clear(const mesh_walk *w, bool of_a, uint32_t node, uint32_t child);

#endif
