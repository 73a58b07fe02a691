/* broad_scene: spheres and boxes that fly through a cube and bounce off its walls. One thread. The same seed gives the
 * same scene, to the last bit and on every machine: positions are whole numbers of 2^-14 m.
 *
 * Half extents (radii) are log-uniform between 0.25 and 1 m, each axis of a box for itself; one body in two is a
 * sphere. Centres are uniform in the cube, whose side is chosen so that a box meets one other on the average; that
 * stays so, for each body keeps its velocity, in a random direction, 1 to 2 % of its own mean size a tick, and is
 * reflected. */
#ifndef COLLIDED_TESTS_BENCH_BROAD_SCENE_H
#define COLLIDED_TESTS_BENCH_BROAD_SCENE_H

#include "broad_peer.h"

#include <stdbool.h>

typedef struct scene_body {
    int32_t centre[3], half[3], velocity[3]; /* 2^-14 m, and as much a tick */
    bool sphere;
} scene_body;

typedef struct scene {
    size_t count;
    int32_t side; /* 2^-14 m */
    scene_body *bodies;
    uint32_t *order; /* all ids, shuffled: who moves */
} scene;

scene scene_create(size_t count);
void scene_destroy(scene *s);
double scene_side_m(const scene *s);

/* The first `percent` of the shuffled ids, at least one, ascending; to be freed. A smaller share is a part of each
 * larger one. */
uint32_t *scene_movers(const scene *s, double percent, size_t *count);
/* Moves these bodies by one tick, and writes their new states. */
void scene_advance(scene *s, const uint32_t *ids, size_t count, peer_body *out);
void scene_state(const scene *s, peer_body *out); /* of all bodies */
bool scene_overlap(const scene *s, uint32_t a, uint32_t b);

/* ---- the truth, by brute force ---- */

/* All pairs of some watched bodies with any other: each against all. */
typedef struct truth {
    size_t watched_count;
    bool *watched;   /* by id */
    uint64_t *pairs; /* (smaller id) << 32 | larger id; sorted */
    size_t count;
} truth;

truth truth_find(const scene *s, size_t watch); /* `watch` bodies at equal distances in id; all if there are fewer */
void truth_destroy(truth *t);

typedef struct verdict {
    size_t pairs;   /* reported */
    size_t overlap; /* of these, boxes that truly overlap */
    size_t missed;  /* of the truth */
} verdict;

verdict truth_judge(const truth *t, const scene *s, const peer *p, void *world);

#endif
