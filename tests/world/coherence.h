/* coherence: scenes that move as robots and crowds do, for tests and benchmarks of temporal coherence. One thread. */
#ifndef COLLIDED_TESTS_WORLD_COHERENCE_H
#define COLLIDED_TESTS_WORLD_COHERENCE_H

#include "world/world.h"

typedef struct coherence_scene {
    const char *name;
    double step_s;                                         /* of simulated time a tick */
    void (*create)(world *w, uint32_t *ids);               /* ids: room for COHERENCE_BODIES_MAX */
    void (*move)(world *w, const uint32_t *ids, double t); /* to where all are at time t, s */
} coherence_scene;

enum { COHERENCE_BODIES_MAX = 1024, COHERENCE_SCENES = 2 };
extern const coherence_scene coherence_scenes[COHERENCE_SCENES]; /* a robot cell and a crowd, both at 100 Hz */

#endif
