/* random_pair: pairs of all shape types from a fixed seed, most of them near to touching: apart, grazing and deep. */
#ifndef COLLIDED_TESTS_CASES_RANDOM_PAIR_H
#define COLLIDED_TESTS_CASES_RANDOM_PAIR_H

#include "subject.h"

#include <stdint.h>

uint64_t random_bits(uint64_t *state); /* splitmix64 (Steele, Lea, Flood 2014) */
double random_uniform(uint64_t *state, double lo, double hi);
quat random_rotation(uint64_t *state);                /* uniform over all rotations */
shape random_shape(uint64_t *state, shape_type type); /* sizes 0.05 to 1; a third of the cores rounded; not hulls */

enum { RANDOM_HULL_POINTS = 14 };
void random_hull_points(uint64_t *state, double points[3 * RANDOM_HULL_POINTS]);
void random_subject(uint64_t *state, shape_type type, subject *s);

/* A pair of the given types, B not a half-space. Coordinates of all that is placed are multiples of 2^-30, so that
 * adding a vector of small integers to both is exact. */
void random_pair(uint64_t *state, shape_type type_a, shape_type type_b, subject *a, subject *b);

#endif
