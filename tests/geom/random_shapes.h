/* Random numbers, poses and shapes for the tests of geom and of what stands on it. splitmix64 (Steele, Lea, Flood
 * 2014): the same seed gives the same cases everywhere. */
#ifndef COLLIDED_TESTS_RANDOM_SHAPES_H
#define COLLIDED_TESTS_RANDOM_SHAPES_H

#include "base/prng.h"
#include "geom/hull.h"
#include "geom/shape.h"

static inline vec3 random_vec(uint64_t *state, double most)
{
    double x = prng_in(state, -most, most), y = prng_in(state, -most, most);
    return vec(x, y, prng_in(state, -most, most));
}
static inline vec3 random_unit(uint64_t *state)
{
    for (;;) {
        vec3 v = random_vec(state, 1);
        if (vec_norm2(v) > 0.01 && vec_norm2(v) < 1) return vec_unit(v);
    }
}
static inline quat random_rotation(uint64_t *state)
{
    for (;;) {
        quat q = {prng_in(state, -1, 1), prng_in(state, -1, 1), prng_in(state, -1, 1), prng_in(state, -1, 1)};
        if (quat_norm2(q) > 0.01 && quat_norm2(q) < 1) return quat_unit(q);
    }
}
static inline pose random_pose(uint64_t *state, double most)
{
    vec3 p = random_vec(state, most);
    return (pose){p, random_rotation(state)};
}

enum { RANDOM_POINTS_MAX = 2000 };

/* Points in a ball of radius `size`, or (shell) on it. */
static inline hull *random_hull(uint64_t *state, size_t count, double size, bool shell)
{
    static _Thread_local vec3 points[RANDOM_POINTS_MAX];
    hull *h = NULL;
    for (size_t i = 0; i < count; i++)
        points[i] = vec_scale(random_unit(state), shell ? size : size * prng_in(state, 0.2, 1));
    return hull_build(&points[0].x, count, 0, &h) == HULL_OK ? h : NULL;
}

/* Any bounded type but the hull; sizes within [0.1, 1] * size, some of them zero. */
static inline shape random_plain_shape(uint64_t *state, double size)
{
    static const shape_type types[] = {
        SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_CONE, SHAPE_ELLIPSOID};
    shape s = {.type = types[prng_bits(state) % 6]};
    s.half = vec(prng_in(state, 0.1, 1), prng_in(state, 0.1, 1), prng_in(state, 0.1, 1));
    if (prng_bits(state) % 8 == 0) s.half.z = 0;
    if (s.type == SHAPE_CYLINDER || s.type == SHAPE_CONE) s.half.y = s.half.x;
    s.half = vec_scale(s.half, size);
    s.radius = s.type == SHAPE_SPHERE || prng_bits(state) % 2 ? prng_in(state, 0, 0.5) * size : 0;
    return s;
}

#endif
