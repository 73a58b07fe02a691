/* ours: daemon/broad as a contender, used as the world uses it: body_margin() of its default options, the step of each
 * body, and a change list at each tick. */
#include "broad/broad.h"
#include "broad_peer.h"

#include <stdlib.h>

static size_t step(void *world, const uint32_t *ids, const peer_body *bodies, size_t count)
{
    broad_changes changes;
    for (size_t i = 0; i < count; i++) {
        const peer_body *b = &bodies[i];
        aabb box = {{b->lo[0], b->lo[1], b->lo[2]}, {b->hi[0], b->hi[1], b->hi[2]}};
        vec3 motion = {b->step[0], b->step[1], b->step[2]};
        broad_put(world, &(broad_move){.proxy = ids[i], .box = box, .margin = 0.1 * b->reach, .motion = motion});
    }
    broad_update(world, &changes);
    return broad_pair_count(world);
}

static void *create_with(broad_kind kind, broad_filter *filter, const peer_body *bodies, size_t count)
{
    uint32_t *ids = malloc(count * sizeof *ids);
    if (!ids) abort();
    for (size_t i = 0; i < count; i++) ids[i] = (uint32_t)i;
    broad *b = broad_create(kind, filter, NULL);
    step(b, ids, bodies, count);
    free(ids);
    return b;
}

static bool accept(void *context, uint32_t a, uint32_t b)
{
    (void)context, (void)a, (void)b;
    return true;
}

static bool refuse(void *context, uint32_t a, uint32_t b)
{
    (void)context, (void)a, (void)b;
    return false;
}

static void *create(const peer_body *bodies, size_t count, double side)
{
    (void)side;
    return create_with(BROAD_AUTO, accept, bodies, count);
}

static void *create_tree(const peer_body *bodies, size_t count, double side)
{
    (void)side;
    return create_with(BROAD_TREE, accept, bodies, count);
}

static void *create_sweep3(const peer_body *bodies, size_t count, double side)
{
    (void)side;
    return create_with(BROAD_SWEEP3, accept, bodies, count);
}

static void *create_sweep1(const peer_body *bodies, size_t count, double side)
{
    (void)side;
    return create_with(BROAD_SWEEP1, accept, bodies, count);
}

static void *create_empty(const peer_body *bodies, size_t count, double side)
{
    (void)side;
    return create_with(BROAD_AUTO, refuse, bodies, count);
}

static void destroy(void *world)
{
    broad_destroy(world);
}

typedef struct visitor {
    uint32_t self;
    peer_visit *visit;
    void *context;
} visitor;

static void visit_once(void *context, uint32_t other)
{
    const visitor *v = context;
    if (v->self < other) v->visit(v->context, v->self, other);
}

static void pairs(void *world, peer_visit *visit, void *context)
{
    size_t count = broad_proxy_count(world);
    visitor v = {0, visit, context};
    for (; v.self < count; v.self++) broad_each_pair_of(world, v.self, visit_once, &v);
}

/* Building such a world takes a sweep 0.1 s; one ten times as large, 10 s. */
enum { SWEEP_MOST = 10000 };

const peer peer_ours = {.name = "collided",
    .create = create,
    .destroy = destroy,
    .step = step,
    .pairs = pairs,
    .entry = "broad_put, broad_update"};
const peer peer_ours_tree = {.name = "collided_tree",
    .create = create_tree,
    .destroy = destroy,
    .step = step,
    .pairs = pairs,
    .entry = "broad_put, broad_update"};
const peer peer_ours_sweep3 = {.name = "collided_sweep3",
    .most = SWEEP_MOST,
    .create = create_sweep3,
    .destroy = destroy,
    .step = step,
    .pairs = pairs,
    .entry = "broad_put, broad_update"};
const peer peer_ours_sweep1 = {.name = "collided_sweep1",
    .most = SWEEP_MOST,
    .create = create_sweep1,
    .destroy = destroy,
    .step = step,
    .pairs = pairs,
    .entry = "broad_put, broad_update"};
const peer peer_ours_empty = {.name = "collided, no pairs",
    .create = create_empty,
    .destroy = destroy,
    .step = step,
    .pairs = pairs,
    .entry = "broad_put, broad_update"};
