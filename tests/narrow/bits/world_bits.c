#include "world_bits.h"

#include "cases.h"
#include "world/world.h"

#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 40, TICKS = 60, MOVED = 12 };
static const double ROOM = 4; /* m */
static const int64_t TICK_NS = 10000000;

/* Numbers are drawn one by one: compilers do not agree on the order of arguments. */
static pose anywhere(random_state *r)
{
    double x = random_in(r, -ROOM, ROOM);
    double y = random_in(r, -ROOM, ROOM);
    double z = random_in(r, -ROOM, ROOM);
    return (pose){vec(x, y, z), random_rotation(r)};
}

static uint32_t put(world *w, random_state *r, int i)
{
    char name[16];
    shape_type type = i % 8 == 7 ? SHAPE_HULL : (shape_type)(i % SHAPE_HALFSPACE);
    world_shape one = {.shape = random_shape(r, type), .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = UINT64_MAX,
        .ccd = (world_ccd)(i % 3),
        .stamp_ns = TICK_NS,
        .pose = anywhere(r),
        .shapes = &one,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    snprintf(name, sizeof name, "body%d", i);
    if (world_put_body(w, &id, &def) != WORLD_OK) abort();
    return id;
}

uint64_t world_bits(unsigned workers, int part)
{
    random_state r = {1618};
    uint32_t ids[BODIES], subscription = WORLD_NONE;
    world_options o = world_options_default();
    o.workers = workers;
    world *w = world_create(&o);
    world_subscription all = {
        .facts = WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD | WORLD_IMPACT | WORLD_PREDICT,
        .select_a = "*",
        .select_b = "*",
        .range = 0.2,
        .tolerance = 1e-9,
        .horizon = 0.05,
    };
    world_batches out = {.hash = 0};
    if (world_put_subscription(w, &subscription, &all) != WORLD_OK) abort();
    for (int i = 0; i < BODIES; i++) ids[i] = put(w, &r, i);
    for (int tick = 1; tick <= TICKS / part; tick++) {
        for (int i = 0; i < MOVED; i++) {
            uint32_t id = ids[random_bits(&r) % BODIES];
            vec3 from = world_body_pose(w, id).p, velocity = vec_scale(random_direction(&r), 5);
            vec3 aside = random_direction(&r);
            pose to = {vec_madd(vec_scale(from, 0.9), 0.3, aside), random_rotation(&r)};
            world_move_body(w, id, to, tick * TICK_NS, i % 2 ? &velocity : NULL, NULL);
        }
        world_tick(w, tick * TICK_NS, &out);
    }
    world_destroy(w);
    return out.hash;
}
