/* hull_axes: the depth of two small hulls by the axes of sat.h, most of which are never looked at.
 *
 * For hulls that both have a map (geom/hull_map.h). The heights of all faces of the one over all vertices of the other
 * are worked out side by side in single precision; the least of them bounds the depth from above. Along the arc of an
 * edge, from a face's normal n0 to its neighbour's n1, B - A reaches at least as far as the vertex that it reaches
 * farthest with at n0, and as the one at n1. w.n of a point w is concave along an arc wherever it is positive; so the
 * greater of the two is least at the ends of the arc, or where they are equal. Where that is above the bound, no facet
 * of the arc is the nearest. Of the arcs that are left (a tenth, about), each of A is tried with each of B, in doubles.
 *
 * What is answered: F (near_features.h) is strict, and all other facets of B - A are more than NEAR_DEPTH_MARGIN
 * farther away than F, so that a search from nothing finds F (polytope_depth.h), and the formula of F gives its bits.
 * Where that cannot be told, nothing is answered, and the search follows. So neither single precision, nor its width,
 * nor what a pair remembers changes any bit of an answer.
 *
 * Rounding: a height in single precision errs by 8 * 2^-24 of the size, and by 2^-18 of itself, for the vertex it is of
 * stands in its last bits. With heights that err by e, the bound of an arc errs by e / c, c the cosine of half the
 * arc; arcs so long that c < 1/4 are always left. All that is below 2^-15 of the size, SLACK is 2^-14. What is left is
 * worked out in doubles: the normals of the map are off by 2^-34, heights along edges' axes by 2^-32 of the size or
 * nothing is answered; and twice NEAR_DEPTH_MARGIN is asked for, 2^-29. Pure; any thread. About 25 kB on the stack. */
#ifndef COLLIDED_NARROW_HULL_AXES_H
#define COLLIDED_NARROW_HULL_AXES_H

#include "unit_pair.h"

bool hull_axes_apply(const unit_pair *p);

/* Are they apart along the line of their origins? Most that are apart are, and need not be looked at here. */
bool hull_axes_parted(const unit_pair *p);

/* For goals that near_features_reach_depths takes. False: it cannot be told by these means, and *out counts for
 * nothing. */
bool hull_axes_depth(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
