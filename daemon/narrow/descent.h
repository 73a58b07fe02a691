/* descent: the distance of cores with rims, from where GJK has found out which way they are apart.
 *
 * GJK comes nearer to a rim by a constant factor a step. Its simplex tells on which pieces of B - A (pieces.h) the
 * nearest point is likely to be; Newton's method finds the axis that they have, a support point along it tells whether
 * a piece was missing. Both bounds are proved as GJK proves them: `lo` by that support point, `hi` by a point of each
 * core. Pure; any thread. */
#ifndef COLLIDED_NARROW_DESCENT_H
#define COLLIDED_NARROW_DESCENT_H

#include "gjk.h"

/* GJK until it knows (GJK_TOUCH or GJK_INSIDE: as gjk_distance ends), then the descent; where that does not reach the
 * goal, GJK from the best axis. For pairs of which pieces_apply. `seed`: see gjk_distance. */
void descent_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);

/* The end of a search from nothing of bodies with rims (rim_features.h): *s is its bracket, unless it is the answer of
 * strict features already; it becomes that if there are any: then it holds them. */
void descent_settle_rims(const unit_pair *p, const narrow_goal *goal, span *s);

#endif
