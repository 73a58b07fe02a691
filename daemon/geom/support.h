/* support: the farthest point of a shape's core in a direction, and what rounding may have done to it.
 *
 * Pure; any thread. The radius is not included: callers add radius * unit(direction). Half-spaces have no support
 * point except along their normal: callers treat them by their plane. A mesh or a compound stands for its convex hull.
 */
#ifndef COLLIDED_GEOM_SUPPORT_H
#define COLLIDED_GEOM_SUPPORT_H

#include "shape.h"

/* The core's point p with the greatest dot(direction, p). `direction` need not be unit; zero gives some point of the
 * core. For a hull `*hint` (may be NULL) is the vertex to start from, and the vertex found; ties go to the least
 * vertex index, so the hint never changes the answer. */
vec3 support_core(const shape *s, vec3 direction, uint32_t *hint);

/* The core's greatest dot(direction, p), never less than the true one (rounded up by its own error bound): a certified
 * one-sided value for separation proofs. */
double support_height_up(const shape *s, vec3 direction, uint32_t *hint);

/* The same in three directions and their opposites: the same bits, sooner. */
void support_spans_up(const shape *s, const vec3 directions[3], double up[3], double down[3]);

#endif
