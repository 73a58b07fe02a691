/* cases: the random shapes and pairs of the narrow tests, from a fixed seed. */
#ifndef NARROW_CASES_H
#define NARROW_CASES_H

#include "narrow/narrow.h"

typedef struct random_state {
    uint64_t x;
} random_state;

uint64_t random_bits(random_state *r); /* splitmix64 */
double random_unit(random_state *r);   /* [0, 1) */
double random_in(random_state *r, double lo, double hi);
vec3 random_direction(random_state *r);
quat random_rotation(random_state *r);

enum { CASE_HULLS = 12 };

/* Hulls of 4 to 40 points, built once, freed by cases_destroy. */
void cases_create(void);
void cases_destroy(void);
const hull *case_hull(unsigned i);

/* Sizes in [0.1, 1.5]; rounded now and then; thin now and then. */
shape random_shape(random_state *r, shape_type type);

enum regime { REGIME_APART, REGIME_NEAR, REGIME_SHALLOW, REGIME_DEEP, REGIME_COUNT };

/* A pose of B such that the pair is, roughly, in the regime. */
void random_poses(random_state *r, const shape *a, const shape *b, enum regime where, pose *pose_a, pose *pose_b);

/* As machines are built and things are stacked: sizes and positions in eighths, turned by quarters and halves of right
 * angles; every third pair disturbed by 1e-16 to 1e-3. */
shape lattice_shape(random_state *r, shape_type type);
void lattice_poses(random_state *r, const shape *a, const shape *b, pose *pose_a, pose *pose_b);

/* Scratch for one thread, aligned; static. */
narrow_scratch *case_scratch(void);

/* Everything measured, as narrow as it goes. */
narrow_request measure_exactly(void);

#endif
