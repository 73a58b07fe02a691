/* rays_scene: bodies and rays for the race of ray queries, and the truth, by brute force. One thread. Units: m; world
 * frame. The same seed gives the same scene. */
#ifndef COLLIDED_TESTS_BENCH_RAYS_SCENE_H
#define COLLIDED_TESTS_BENCH_RAYS_SCENE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum rays_kind { RAYS_BALL, RAYS_BOX, RAYS_CAPSULE, RAYS_KIND_COUNT } rays_kind;

typedef struct rays_body {
    rays_kind kind;
    double half[3];   /* of a box; of a capsule half[2] is that of its core, along z */
    double radius;    /* of a ball, of a capsule */
    double at[3];     /* position */
    double turned[4]; /* unit quaternion w, x, y, z */
} rays_body;

typedef struct rays_ray {
    double from[3], direction[3]; /* unit */
} rays_ray;

typedef struct rays_scene {
    rays_body *bodies;
    rays_ray *rays;
    size_t body_count, ray_count;
    double side; /* m: of the cube in which the centres lie, and in which the rays begin */
} rays_scene;

/* Half sizes from 0.25 to 1 m, turned at random, so dense that each body's box meets that of one other. Rays
 * begin outside of all bodies, for peers differ in what they tell of those that begin inside. */
rays_scene rays_scene_make(size_t bodies, size_t rays, uint64_t seed);
void rays_scene_free(rays_scene *s);

/* The columns of a body's rotation. */
void rays_axes(const rays_body *b, double axes[3][3]);

/* The length of the way that is free along the ray: INFINITY if it meets nothing, 0 if it begins in a body. Asks all
 * bodies, by textbook formulas in long double. */
double rays_truth(const rays_scene *s, const rays_ray *r);

#ifdef __cplusplus
}
#endif

#endif
