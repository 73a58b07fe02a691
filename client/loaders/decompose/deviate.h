/* deviate: how far is the farthest point of a convex piece from the solid? A bound with proof, by branch and bound. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_DEVIATE_H
#define COLLIDED_LOADERS_DECOMPOSE_DEVIATE_H

#include "piece.h"

typedef struct deviate_effort {
    double ratio;     /* upper and lower bound nearer than this: enough */
    double floor;     /* m: an upper bound below it is enough */
    size_t steps;     /* most boxes looked at; what is not settled then counts with its bound */
    bool places_only; /* the solid's normals (overhang.h) are not asked first: whoever calls has, or will */
} deviate_effort;

/* Sets the deviation, which is never too small, and the farthest point. Of an open mesh every point counts as outside:
 * the distance is that from the triangles. Returns the lower bound. */
double deviate_find(const solid *s, piece *p, const deviate_effort *effort);

#endif
