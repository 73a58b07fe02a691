/* witness: the points that an answer names when two cores overlap: the deepest along the axis. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_WITNESS_H
#define COLLIDED_NARROW_CONVEX_WITNESS_H

#include "narrow/pair/unit_pair.h"

/* ---- facing ---- */

/* The parts of two cores that lie on their support planes along an axis, and points of them that face each other.
 * For boxes, capsules, cylinders and cones such a part is a point, a segment, a rectangle or a disc, so that this is
 * a closed form. */

/* Moves s->point_a and s->point_b to points of the cores that are not lower along s->axis than the support points by
 * more than `slack`, and of which one faces the other as nearly as there are such points. False: one of the cores is of
 * another kind; *s is as it was. */
bool facing_points(const unit_pair *p, double slack, span *s);

/* ---- witness ---- */

/* Where the cores touch once B is moved apart along s->axis by the depth: points that face each other. */
void witness_apart(const unit_pair *p, span *s);

/* Keeps s->point_a and s->point_b if they lie on the support planes of their cores along s->axis and face each other;
 * else takes witness_apart's, or where even those fall short, a support point of each. */
void witness_deepest(const unit_pair *p, span *s);

/* Writes points on the support planes that face each other, found by a formula (witness.h); of an axis that is not that
 * of the least depth there need not be any. False: none are known, and the points are `top`, the support points. */
bool witness_facing(const unit_pair *p, const minkowski *top, span *s);

#endif
