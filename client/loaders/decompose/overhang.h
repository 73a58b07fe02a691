/* overhang: how far does a convex shape reach beyond a solid? A bound with proof, from the directions in which a point
 * outside can have its nearest point of the solid.
 *
 * Let x be in the shape and not in the solid, y the point of the solid that is nearest to it, s = |x - y|, u = (x -
 * y)/s. Then u is a sum of the outward normals of the faces that meet in y, with parts >= 0: were it not, a vector w
 * with n . w <= 0 for all of those normals and u . w > 0 would exist (Farkas); the way from w, seen from y, to any
 * inner point of the solid could enter the solid through none of these faces, so w would lead into the solid, nearer to
 * x than y. And x = y + s u is below every plane around the shape: s (m . u) <= offset - m . y. So s is at most the
 * least (offset - m . y) / (m . u) over the planes with m . u > 0, and the greatest of that over all faces (u = n),
 * edges (u between two normals) and corners (u among several) is a bound. Faces, edges and cones are split until it is
 * close. It is good where the solid is nearly convex; deviate.h looks at where x is, and is better where it is not. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_OVERHANG_H
#define COLLIDED_LOADERS_DECOMPOSE_OVERHANG_H

#include "piece.h"

enum { OVERHANG_TRIANGLES_MAX = 20000, OVERHANG_WORK = 400000000 /* planes: about a second */ };

/* Where nearest points can be, and the directions; in the pool. NULL if the solid is open, has inner faces or corners
 * with too wide a cone, or is too large. */
struct overhang *overhang_make(pool *p, const solid *s);

/* How many places there are; a bound looks at each with every plane. 0 of NULL. */
size_t overhang_count(const struct overhang *o);

/* No point below all planes is farther than this from the solid; INFINITY if o is NULL, or where the bound cannot come
 * below `wanted`. Bounds below `floor` are not refined, and none is once `work` planes have been looked at by
 * splitting: the bound is then wider, and holds. */
double overhang_bound(const struct overhang *o, const solid *s, const piece_plane *planes, size_t plane_count,
    double floor, double wanted, size_t work);

#endif
