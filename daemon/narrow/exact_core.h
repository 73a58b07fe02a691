/* exact_core: one core in its own frame, in double-double: how high it reaches, and how far a point is from it. Pure;
 * any thread. */
#ifndef COLLIDED_NARROW_EXACT_CORE_H
#define COLLIDED_NARROW_EXACT_CORE_H

#include "dd.h"
#include "geom/shape.h"

/* Greatest dot(n, x) over the core; n of any length. The vertices of a hull are scaled by `scale`, a power of two. Not
 * for half-spaces. */
dd exact_height(const shape *s, double scale, dd3 n);

/* The nearest point of a sphere's, capsule's or box's core. */
dd3 exact_clamp(const shape *s, dd3 point);

/* Signed distance of a point from the core: of a sphere, capsule, box, cylinder or cone. */
bool exact_has_distance(const shape *s);
dd exact_distance(const shape *s, dd3 point);

#endif
