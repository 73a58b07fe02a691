/* facing: the parts of two cores that lie on their support planes along an axis, and points of them that face each
 * other. For boxes, capsules, cylinders and cones such a part is a point, a segment, a rectangle or a disc, so that
 * this is a closed form. Pure; any thread. */
#ifndef COLLIDED_NARROW_FACING_H
#define COLLIDED_NARROW_FACING_H

#include "unit_pair.h"

/* Moves s->point_a and s->point_b to points of the cores that are not lower along s->axis than the support points by
 * more than `slack`, and of which one faces the other as nearly as there are such points. False: one of the cores is of
 * another kind; *s is as it was. */
bool facing_points(const unit_pair *p, double slack, span *s);

#endif
