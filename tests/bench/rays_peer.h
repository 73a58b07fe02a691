/* rays_peer: what the race of ray queries asks of each contender. One thread; a contender keeps nothing outside of what
 * it created. */
#ifndef COLLIDED_TESTS_BENCH_RAYS_PEER_H
#define COLLIDED_TESTS_BENCH_RAYS_PEER_H

#include "rays_scene.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct rays_answer { /* of the first hit, the length of the free way, m: between these; INFINITY: none */
    double lo, hi;
} rays_answer;

typedef struct rays_peer {
    const char *name;
    double error;                         /* m, by which it may be off before it counts as wrong */
    void *(*create)(const rays_scene *s); /* NULL: it is not there, which it has said on stderr */
    rays_answer (*ask)(void *self, const rays_ray *ray, double length); /* the time of this is the figure */
    void (*destroy)(void *self);
    const char *entry; /* the functions that are timed */
} rays_peer;

/* Ours comes first; which others are there is CMake's choice (rays_all.c, rays_alone.c, rays_no_embree.c). */
extern const rays_peer *const rays_contenders[];
extern const size_t rays_contender_count;
extern const rays_peer rays_ours, rays_bullet, rays_embree;

#ifdef __cplusplus
}
#endif

#endif
