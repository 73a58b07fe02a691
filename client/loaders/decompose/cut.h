/* cut: where to cut a piece of a solid in two. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_CUT_H
#define COLLIDED_LOADERS_DECOMPOSE_CUT_H

#include "piece.h"

/* The two parts whose hulls reach least beyond the solid, by distance and volume. `from` has its deviation. False if no
 * cut leaves two parts with an inside. */
bool cut_best(const solid *s, const piece *from, piece *below, piece *above);

#endif
