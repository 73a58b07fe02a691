/* moved_apart: a better axis for two cores that overlap by almost nothing, where a search for their depth ended early:
 * the origin lies on the surface of B - A, and a polytope grown there is all slivers. Pure; any thread. */
#ifndef COLLIDED_NARROW_MOVED_APART_H
#define COLLIDED_NARROW_MOVED_APART_H

#include "unit_pair.h"

/* Raises the lower bound of a pair whose interval is wide, and replaces its axis, if an axis is found that proves more.
 */
void moved_apart_raise(const unit_pair *p, span *s);

#endif
