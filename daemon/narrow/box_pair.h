/* box_pair: two boxes (or points and segments, which are boxes with zero sides) by their fifteen axes.
 *
 * B - A is a zonotope: its facets have the normals of A's faces, of B's faces, or cross products of an edge of each, so
 * the greatest separation over those fifteen is minus the depth when the boxes overlap, and a lower bound of the
 * distance when they do not. No axis is favoured: the greatest wins, ties go to the first. Pure; any thread. */
#ifndef COLLIDED_NARROW_BOX_PAIR_H
#define COLLIDED_NARROW_BOX_PAIR_H

#include "closed.h"

/* The closed form. False for boxes that are apart and nearest at corners, or at a corner and an edge: then out->axis is
 * the axis that separates them most of the fifteen. */
closed_form closed_box_box;

/* Fills lo, hi, axis, method and iterations; hi is an upper bound only when it is negative. */
void box_pair_axes(const unit_pair *p, span *out);

/* closed_box_box of boxes of which no more is known than the face that separates most, and how far. */
struct box_pair;
bool box_pair_apart(const struct box_pair *x, double most, int face, const narrow_goal *goal, span *out);

/* The sides of a core that is a box, a segment or a point. */
vec3 box_sides(const shape *s);

/* Of the fifteen axes of boxes that overlap, as bits (A's faces, B's faces, edge i of A with edge j of B at BOX_FACES +
 * 3 i + j): those along which the exact separation may be the greatest, for all that the rounding of doubles lets tell.
 */
enum { BOX_FACES = 6 };
unsigned box_pair_near_best(const unit_pair *p);

#endif
