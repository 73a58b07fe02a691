/* solid_tree: the tree of boxes over a solid's triangles, and the questions that walk it. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_SOLID_TREE_H
#define COLLIDED_LOADERS_DECOMPOSE_SOLID_TREE_H

#include "solid.h"

/* Sorts the triangles into the leaves' order and makes the nodes. */
void solid_tree_make(pool *p, solid *s);

/* Distance from x to the nearest triangle, and where that is. */
double solid_nearest(const solid *s, const double x[3], double nearest[3]);

enum { SOLID_OUTSIDE, SOLID_INSIDE, SOLID_UNSURE }; /* unsure: too near to the surface for doubles */

/* Whether the triangles of a closed mesh wind around x. */
int solid_side(const solid *s, const double x[3]);

/* The triangles that are no farther than `radius` from x: how many were written to `out`, or -1 if more than `most`. */
int solid_within(const solid *s, const double x[3], double radius, const solid_triangle **out, int most);

#endif
