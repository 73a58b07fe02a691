/* fit_excess: how far the hull of a solid reaches beyond it: a bound with proof. Pure. */
#ifndef COLLIDED_LOADERS_FIT_EXCESS_H
#define COLLIDED_LOADERS_FIT_EXCESS_H

#include "fit_hull.h"

/* By whichever way finds a bound that is no more than `wanted`, overhang.h or deviate.h; a larger one where a point
 * occurs that is farther away, or where neither does. */
double fit_excess_of_hull(const solid *s, const fit_hull *h, double wanted);

#endif
