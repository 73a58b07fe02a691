/* solid_tree: the tree of boxes over a solid's triangles. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_SOLID_TREE_H
#define COLLIDED_LOADERS_DECOMPOSE_SOLID_TREE_H

#include "solid.h"

/* Sorts the triangles into the leaves' order and makes the nodes. */
void solid_tree_make(pool *p, solid *s);

#endif
