/* ellipsoid_pair: the signed distance of two ellipsoids, or of a ball and one, by Newton's method and one global proof.
 *
 * The support function of B - A along a unit n is h(n) = c.n + |A n| + |B n|, smooth; its least over all n is the depth
 * (minus the distance when the cores are apart). Apart, any n and any two points bracket it. Overlapping, h may have
 * several least places, and the proof has to be of all directions at once: for every orthogonal S
 *     |A n| + |B n| >= |(A + S B) n|
 * by the triangle inequality, with equality at n0 where S turns B n0 towards A n0 (an ellipsoid inside B - A that
 * touches it there: Kurzhanski and Valyi, "Ellipsoidal Calculus", 1997). And c.n + |M n| >= d holds for all unit n when
 * a quadratic form says so (the S-lemma, which on a sphere loses nothing). A few hundred operations, where a hull of
 * support points needs fifty expansions. Pure; any thread. */
#ifndef COLLIDED_NARROW_ELLIPSOID_PAIR_H
#define COLLIDED_NARROW_ELLIPSOID_PAIR_H

#include "closed.h"

/* False: not proved; then *out says nothing but the axis, by which to begin another search. */
bool ellipsoid_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
