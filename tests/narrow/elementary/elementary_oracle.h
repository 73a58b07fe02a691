/* elementary_oracle: the exact truth of the two elementary tests of continuous collision, in whole and rational
 * numbers of any length (GMP). Nothing of the daemon's is used but the type vec3.
 *
 * Contact means that the origin is in the triangle, or parallelogram, of the differences. It then lies in their plane:
 * a cubic in t vanishes. Its roots are isolated with Sturm sequences, and at each root the signs of the quadratics that
 * say inside or outside are found as Tarski queries. Where the cubic is identically zero, the answer can change only at
 * a root of one of those quadratics, so all of these are tried. */
#ifndef COLLIDED_TESTS_ELEMENTARY_ORACLE_H
#define COLLIDED_TESTS_ELEMENTARY_ORACLE_H

#include "geom/vec.h"

typedef enum elementary_kind { ELEMENTARY_VF, ELEMENTARY_EE } elementary_kind;

typedef struct elementary_query { /* points in the order of soft/elementary.h */
    elementary_kind kind;
    vec3 start[4], end[4];
} elementary_query;

typedef struct elementary_truth {
    bool touches;
    double lo, hi; /* the first contact is in [lo, hi]: a bracket of 2^-62, rounded outward; 2, 2 = none */
} elementary_truth;

elementary_truth elementary_oracle(const elementary_query *q);

/* Is the distance at time t at most this? Exactly. */
bool elementary_oracle_within(const elementary_query *q, double t, double distance);

#endif
