/* hull_excess: how far points that a hull was made of are outside of it, for bounds that must hold for all of them.
 *
 * Signs are exact (expansion.h), so a point in or on the polytope adds nothing, and lengths are rounded upward. Any
 * thread; the same at any power-of-two scale, but where coordinates are 2^-300 of the largest. */
#ifndef COLLIDED_GEOM_HULL_EXCESS_H
#define COLLIDED_GEOM_HULL_EXCESS_H

#include "hull.h"

/* No point of `points` is farther than this from the convex hull of h's vertices. 0: all are in it. Not more than twice
 * the least such number, beside two roundoffs of the length of a face's side; where facets that do not lie in one plane
 * were merged, also what that side of the fan of the face is off by. */
double hull_excess_of(const hull *h, const vec3 *points, uint32_t count);

#endif
