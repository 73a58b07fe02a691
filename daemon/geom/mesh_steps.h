/* mesh_steps: the steps of mesh_build that have files of their own. Used by geom/mesh*.c only. Any thread. */
#ifndef COLLIDED_GEOM_MESH_STEPS_H
#define COLLIDED_GEOM_MESH_STEPS_H

#include "mesh.h"

/* Looks at the edges: turns triangles that disagree with their neighbours where that mends it, and says whether what
 * comes out has an inside. Fills found.turned, inside_out, *_edges, and solid. */
void mesh_orient(mesh *m);

/* Puts the triangles into the order of the leaves and makes the nodes. */
void mesh_tree_build(mesh *m);

#endif
