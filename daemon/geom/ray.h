/* ray: where a ray enters a shape, in closed form, with certified bounds. Pure; any thread.
 *
 * A ray that cannot be decided here (it begins in the shape or next to it, or the shape has no formula) is left to the
 * general search along a ray, world/query_space.c, which uses distances. */
#ifndef COLLIDED_GEOM_RAY_H
#define COLLIDED_GEOM_RAY_H

#include "shape.h"

typedef enum ray_verdict {
    RAY_MISSES, /* proven */
    RAY_HITS,   /* or comes nearer than rounding can decide: then `hi` is infinite */
    RAY_UNTOLD, /* ask the general search */
} ray_verdict;

typedef struct ray_hit {
    double lo, hi; /* the ray is free before lo, and has touched by hi: lengths along it, in the shape's unit */
    vec3 normal;   /* unit, outward, where it enters; in the shape's frame */
} ray_hit;

/* The ray is from + t direction, t >= 0, in the shape's frame; |direction| = 1 but for rounding. Both may be off by
 * what changes of frame do to them: `from` by 2^-47 of (|from| + reach + arm), the direction by 2^-48. `reach` is the
 * shape's; `arm` is the sum of the lengths that were added up to get `from`, where these are longer than it. Rounded
 * shapes other than spheres, capsules and half-spaces, cones, hulls, meshes and compounds are RAY_UNTOLD, and shapes
 * that only stand for others (deviation). */
ray_verdict ray_enters(const shape *s, double reach, double arm, vec3 from, vec3 direction, ray_hit *hit);

/* Only by a ball of this radius about the origin: the length that is free before it, 0 if the ray begins in it,
 * INFINITY if it never meets the ball. A lower bound for all that lies within, at a fraction of the cost. */
double ray_free_before(double reach, double arm, vec3 from, vec3 direction);

#endif
