/* coaxial: the depth of two cores that share their axis of revolution, where a whole ring of directions is equally deep
 * and a polytope grown from inside converges slowly. Pure; any thread. */
#ifndef COLLIDED_NARROW_COAXIAL_H
#define COLLIDED_NARROW_COAXIAL_H

#include "unit_pair.h"

/* ---- inscribed ---- */

/* An upper bound of deep curved pairs by a ball in one core. B is no deeper in A than in A's ball: separation(A, B)
 * <= separation(ball in A, B) = signed distance of the ball's centre from B - its radius, and the distance of a
 * point has a formula. About one axis, or about one centre, many directions are equally deep, and a surface of
 * support points has to be refined along all of them; the ball touches them all at once. */

/* Is the centre of either core about on the other's axis? Else two directions are seldom equally deep. */
bool inscribed_promises(const unit_pair *p);

/* Narrows *s, of cores that overlap, from both sides where the ball of either is nearer to the truth. */
void inscribed_depth(const unit_pair *p, const narrow_goal *goal, span *s);

/* ---- coaxial ---- */

/* Narrows the bounds of overlapping cores, if they are capsules, cylinders or cones on one axis to within rounding. */
void coaxial_depth(const unit_pair *p, span *s);

#endif
