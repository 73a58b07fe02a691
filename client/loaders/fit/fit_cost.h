/* fit_cost: what a shape costs, to choose between shapes. Pure; any thread. */
#ifndef COLLIDED_LOADERS_FIT_COST_H
#define COLLIDED_LOADERS_FIT_COST_H

#include "loaders/body.h"

/* ns of a query of two such shapes that are apart, decided from nothing; only ratios matter. */
double fit_cost_ns(const load_shape *s);

/* What a pair of links costs: of each two of their shapes as much as the dearer one. */
double fit_cost_of_pair(const load_shape *a, size_t a_count, const load_shape *b, size_t b_count);

#endif
