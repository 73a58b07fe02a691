/* propose: which point of an ellipsoid or hull is nearest to a given one? The kernel, check.c, believes nothing of what
 * comes out here: its formulas make points of the shape of whatever these functions return, NaN included. A bad
 * proposal costs an acceptance, never a truth. Pure; bounded by their counts; any thread. */
#ifndef COLLIDED_CHECK_PROPOSE_H
#define COLLIDED_CHECK_PROPOSE_H

#include <stddef.h>

/* u of the unit ball such that (a[0] u[0], a[1] u[1], a[2] u[2]) is near q. */
void propose_ellipsoid(const double q[3], const double a[3], double u[3]);

/* Four of the `count` points (x, y, z each, to be multiplied by `by`), and weights that add up to 1, some of them 0,
 * of a point of their hull that is near q. */
void propose_hull(
    const double *points, size_t count, const double q[3], double by, size_t corners[4], double weights[4]);

#endif
