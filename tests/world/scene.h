/* scene: makers for worlds of a few bodies, shared by the tests of this folder. */
#ifndef COLLIDED_TESTS_WORLD_SCENE_H
#define COLLIDED_TESTS_WORLD_SCENE_H

#include "world/world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { SECOND = 1000000000 };

/* A body of one shape, not turned, that looks at all others. */
static inline uint32_t scene_body(world *w, const char *name, world_shape one, vec3 at)
{
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = UINT64_MAX,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &one,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static inline uint32_t scene_sphere(world *w, const char *name, double x, double radius)
{
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = radius}, .local = POSE_IDENTITY};
    return scene_body(w, name, ball, vec(x, 0, 0));
}

static inline void scene_move(world *w, uint32_t id, double x, int64_t stamp_ns)
{
    pose to = {{x, 0, 0}, {1, 0, 0, 0}};
    assert_int_equal(world_move_body(w, id, to, stamp_ns, NULL, NULL), WORLD_OK);
}

static inline world_subscription scene_all(unsigned facts, double range)
{
    return (world_subscription){.facts = facts, .select_a = "*", .select_b = "*", .range = range, .tolerance = 1e-9};
}

static inline uint32_t scene_subscription(world *w, const world_subscription *def)
{
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_subscription(w, &id, def), WORLD_OK);
    return id;
}

static inline world *scene_world(unsigned workers, bool caches)
{
    world_options o = world_options_default();
    o.workers = workers;
    o.caches = caches;
    return world_create(&o);
}

/* The last batch of a tick, which is the snapshot if there is one; NULL if there is none. */
static inline const world_batch *scene_tick(world *w, int64_t now_ns)
{
    static world_batches batches;
    world_tick(w, now_ns, &batches);
    const char *fault = world_validate(w);
    if (fault) fail_msg("%s", fault);
    return batches.count ? &batches.at[batches.count - 1] : NULL;
}

#endif
