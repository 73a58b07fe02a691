/* witness: the points that an answer names when two cores overlap: the deepest along the axis. Pure; any thread. */
#ifndef COLLIDED_NARROW_WITNESS_H
#define COLLIDED_NARROW_WITNESS_H

#include "unit_pair.h"

/* Where the cores touch once B is moved apart along s->axis by the depth: points that face each other. */
void witness_apart(const unit_pair *p, span *s);

/* Keeps s->point_a and s->point_b if they lie on the support planes of their cores along s->axis and face each other;
 * else takes witness_apart's, or where even those fall short, a support point of each. */
void witness_deepest(const unit_pair *p, span *s);

/* Writes points on the support planes that face each other, found by a formula (facing.h); of an axis that is not that
 * of the least depth there need not be any. False: none are known, and the points are `top`, the support points. */
bool witness_facing(const unit_pair *p, const minkowski *top, span *s);

#endif
