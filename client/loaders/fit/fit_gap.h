/* fit_gap: the distance of two convex hulls, given by their points in one frame, between two bounds.
 *
 * The method of Gilbert, Johnson and Keerthi (1988) finds an axis and two points; the bounds do not depend on how well
 * it does: the axis proves `lo` (all points of one are on one side of a slab so wide, all of the other on its other
 * side), and `hi` is the distance of a point of one hull from a point of the other. Pure; any thread; allocates
 * nothing. */
#ifndef COLLIDED_LOADERS_FIT_GAP_H
#define COLLIDED_LOADERS_FIT_GAP_H

#include <stddef.h>

typedef struct fit_cloud {
    const double *at; /* triples */
    size_t count;
    double most; /* no |coordinate| is greater */
} fit_cloud;

typedef struct fit_gap {
    double lo, hi;  /* lo <= distance <= hi; lo is not above 0 where they meet, or where nothing is proven */
    double axis[3]; /* from b to a, of any length; proves lo */
} fit_gap;

/* `start`: where a is seen from b, roughly. Stops when hi - lo <= enough, or when lo > goal. */
void fit_gap_find(fit_cloud a, fit_cloud b, const double start[3], double enough, double goal, fit_gap *out);

/* The separation that this axis proves. */
double fit_gap_along(fit_cloud a, fit_cloud b, const double axis[3]);

#endif
