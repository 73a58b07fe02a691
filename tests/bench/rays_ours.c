/* rays_ours: the world as a contender, asked as the service asks it: with a clock that ends long searches. */
#include "base/clock.h"
#include "rays_peer.h"
#include "world/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct ours {
    world *w;
    world_hits hits;
    int64_t until_ns;
} ours;

static bool has_patience(void *context)
{
    const ours *o = context;
    return clock_monotonic_ns() < o->until_ns;
}

static shape shape_of(const rays_body *b)
{
    static const shape_type TYPES[] = {SHAPE_SPHERE, SHAPE_BOX, SHAPE_CAPSULE};
    return (shape){.type = TYPES[b->kind], .radius = b->radius, .half = {b->half[0], b->half[1], b->half[2]}};
}

static void *create(const rays_scene *s)
{
    ours *o = calloc(1, sizeof *o);
    world_options options = world_options_default();
    world_batches batches;
    if (!o) abort();
    o->w = world_create(&options);
    for (size_t i = 0; i < s->body_count; i++) {
        const rays_body *b = &s->bodies[i];
        char name[24];
        snprintf(name, sizeof name, "b%zu", i);
        world_shape one = {.shape = shape_of(b), .local = POSE_IDENTITY};
        world_body def = {.name = name,
            .group = "",
            .category = 1,
            .mask = UINT64_MAX,
            .pose = {{b->at[0], b->at[1], b->at[2]}, {b->turned[0], b->turned[1], b->turned[2], b->turned[3]}},
            .shapes = &one,
            .shape_count = 1};
        uint32_t id = WORLD_NONE;
        if (world_put_body(o->w, &id, &def) != WORLD_OK) abort();
    }
    world_tick(o->w, 1, &batches);
    return o;
}

static rays_answer ask(void *self, const rays_ray *r, double length)
{
    ours *o = self;
    vec3 from = {r->from[0], r->from[1], r->from[2]}, d = {r->direction[0], r->direction[1], r->direction[2]};
    o->hits.count = 0;
    o->hits.gave_up = false;
    o->hits.go_on = has_patience;
    o->hits.go_on_context = o;
    o->until_ns = clock_monotonic_ns() + 1000000000;
    world_query_ray(o->w, from, d, length, 0, 1, &o->hits);
    return o->hits.count ? (rays_answer){o->hits.at[0].lo, o->hits.at[0].hi} : (rays_answer){INFINITY, INFINITY};
}

static void destroy(void *self)
{
    ours *o = self;
    world_destroy(o->w);
    free(o->hits.at);
    free(o);
}

const rays_peer rays_ours = {"collided", 0, create, ask, destroy, "world_query_ray"};
