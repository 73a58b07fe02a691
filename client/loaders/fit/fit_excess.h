/* fit_excess: how far does the hull of a solid reach beyond it? A bound with proof.
 *
 * Let x be in the hull and not in the solid, y the point of the solid that is nearest to it, s = |x - y|, u = (x -
 * y)/s. Then u is a sum of the outward normals of the faces that meet in y, with parts >= 0: were it not, a vector w
 * with n . w <= 0 for all of those normals and u . w > 0 would exist (Farkas); the way from w, seen from y, to any
 * inner point of the solid could enter the solid through none of these faces, so w would lead into the solid, nearer to
 * x than y. And x = y + s u is below every plane of the hull: s (m . u) <= offset - m . y. So s is at most the least
 * (offset - m . y) / (m . u) over the planes with m . u > 0, and the greatest of that over all faces (u = n), edges (u
 * between two normals) and corners (u among several) is a bound. Faces, edges and cones are split until it is close.
 * It is good where the solid is nearly convex; deviate.h looks at where x is, and is better where it is not. */
#ifndef COLLIDED_LOADERS_FIT_EXCESS_H
#define COLLIDED_LOADERS_FIT_EXCESS_H

#include "fit_hull.h"

/* No point of the hull is farther than this from the solid; INFINITY if the solid is open, or has inner faces, or
 * if the bound cannot come below `wanted`. Bounds below `floor` are not refined. */
double fit_excess_by_normals(const solid *s, const fit_hull *h, double floor, double wanted);

/* A bound, by whichever way finds one that is no more than `wanted`; a larger one where a point occurs that is farther
 * away, or where neither does. */
double fit_excess_of_hull(const solid *s, const fit_hull *h, double wanted);

#endif
