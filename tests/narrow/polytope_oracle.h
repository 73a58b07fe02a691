/* polytope_oracle: the signed distance of two polytopes by brute force in 113 bits: every face normal and every cross
 * product of two edges for the depth; every vertex-face and edge-edge pair for the distance. */
#ifndef NARROW_POLYTOPE_ORACLE_H
#define NARROW_POLYTOPE_ORACLE_H

#include "oracle.h"

/* Spheres, capsules, boxes and hulls with faces; radii are subtracted. */
real polytope_signed_distance(const placed *a, const placed *b);

#endif
