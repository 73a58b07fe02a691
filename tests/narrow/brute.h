/* brute: the distance of two sets of triangles, and whether they meet, by all pairs in 113-bit arithmetic. */
#ifndef MESH_BRUTE_H
#define MESH_BRUTE_H

#include "solids.h"

typedef __float128 quad;

/* 0 when two triangles meet. `b_in_a`: as narrow_query takes it; its quaternion counts divided by its norm. */
quad brute_distance(const soup *a, const soup *b, const pose *b_in_a);

/* The distance of a point from triangles, and the winding number by the sum of solid angles, rounded. */
quad brute_point_distance(const soup *s, vec3 point);
int brute_winding(const soup *s, vec3 point);

#endif
