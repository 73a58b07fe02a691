/* moving_scene: bodies that all move and turn in a box with walls: balls, boxes and capsules in equal parts, 0.4 to
 * 0.8 m long, so close that about half of them touch another. What the tick of a whole world is measured on, beside
 * peers that are given the same poses. Plain arrays, in the world frame, which C and C++ read alike. */
#ifndef COLLIDED_TESTS_BENCH_MOVING_SCENE_H
#define COLLIDED_TESTS_BENCH_MOVING_SCENE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum moving_kind { MOVING_BALL, MOVING_BOX, MOVING_CAPSULE, MOVING_KINDS } moving_kind;

typedef struct moving_body {
    moving_kind kind;
    double half[3]; /* m: of the box; radius of a ball; radius and half length, along z, of a capsule */
} moving_body;

typedef struct moving_scene {
    size_t count;
    double side; /* m: centres are in 0..side on each axis */
    moving_body *bodies;
    double *positions, *orientations; /* 3 and 4 (w x y z) each, as of the last step */
    double *velocities, *spins;       /* m/s and rad/s, 3 each */
} moving_scene;

enum { MOVING_HZ = 100 };

moving_scene *moving_scene_create(size_t count);
void moving_scene_step(moving_scene *s);                            /* by 1 / MOVING_HZ s */
void moving_scene_copy(moving_scene *to, const moving_scene *from); /* its state; both of as many bodies */
void moving_scene_destroy(moving_scene *s);

/* One contender. It is given the scene as it begins, and after each step of it. */
typedef struct moving_peer {
    const char *name;
    size_t most; /* bodies that it is raced with */
    void *(*create)(const moving_scene *s);
    void (*destroy)(void *world);
    /* All that a user does in each step: the time of this call is the figure. How many pairs touch afterwards. */
    size_t (*step)(void *world, const moving_scene *s);
    const char *entry; /* the functions that are timed */
} moving_peer;

/* Which there are is CMake's choice (moving_all.c, moving_alone.c). */
extern const moving_peer *const moving_peers[];
extern const size_t moving_peer_count;
extern const moving_peer moving_bullet, moving_fcl, moving_ode;

#ifdef __cplusplus
}
#endif

#endif
