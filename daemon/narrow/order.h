/* order: three-way comparisons behind the canonical order of a pair. */
#ifndef COLLIDED_NARROW_ORDER_H
#define COLLIDED_NARROW_ORDER_H

#include "request.h"

/* By type, sizes, radius, and the vertices of hulls or the children of compounds; 0 when equal. */
int order_shapes(const shape *a, const shape *b);

/* By position, then orientation: unchanged when both are shifted by a representable vector. */
int order_poses(pose a, pose b);

#endif
