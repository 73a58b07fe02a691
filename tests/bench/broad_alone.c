/* broad_alone: the scenes that only ours runs through. One thread. */
#include "broad_alone.h"

#include "bench.h"
#include "broad_race.h"
#include "broad_scene.h"

#include <stdlib.h>

enum { ONE_TICKS = 4000, LEAP = 8, PILE_STEPS = 20, MEMORY_TICKS = 4 };
static const double PILE_RADIUS = 0.5, PILE_STRIDE = 2; /* m: leaves every fat box */

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

static void *create_world(const peer *p, const scene *s)
{
    peer_body *bodies = allocate(s->count, sizeof *bodies);
    scene_state(s, bodies);
    void *world = p->create(bodies, s->count, scene_side_m(s));
    free(bodies);
    return world;
}

static double timed_step_us(void *world, const uint32_t *ids, const peer_body *bodies, size_t count)
{
    int64_t start = bench_now_ns();
    peer_ours.step(world, ids, bodies, count);
    return 1e-3 * (double)(bench_now_ns() - start);
}

/* ---- one body ---- */

/* The body is always the first, one tick further (stride 0, leap 1); or the next one, `leap` ticks further. */
static void time_one(void *world, scene *s, uint32_t stride, int leap, double *median, double *mean, double *p99)
{
    bench_samples times;
    double sum = 0;
    if (!bench_samples_init(&times, ONE_TICKS)) abort();
    for (uint32_t t = 0; t < ONE_TICKS; t++) {
        uint32_t id = s->order[(size_t)t * stride % s->count];
        peer_body body;
        for (int i = 0; i < leap; i++) scene_advance(s, &id, 1, &body);
        double us = timed_step_us(world, &id, &body, 1);
        bench_samples_add(&times, (int64_t)(1e3 * us));
        sum += us;
    }
    *median = bench_percentile_us(&times, 0.5);
    *mean = sum / ONE_TICKS;
    *p99 = bench_percentile_us(&times, 0.99);
    bench_samples_free(&times);
}

alone_one alone_move_one(size_t count)
{
    alone_one out = {.count = count, .ticks = ONE_TICKS};
    scene s = scene_create(count);
    void *world = create_world(&peer_ours, &s);
    time_one(world, &s, 0, 1, &out.same_median, &out.same_mean, &out.same_p99);
    time_one(world, &s, 1, LEAP, &out.any_median, &out.any_mean, &out.any_p99);
    peer_ours.destroy(world);
    scene_destroy(&s);
    return out;
}

/* ---- all on one spot ---- */

static void stack_at(peer_body *bodies, size_t count, double x, double step)
{
    for (size_t i = 0; i < count; i++)
        bodies[i] = (peer_body){.lo = {x - PILE_RADIUS, -PILE_RADIUS, -PILE_RADIUS},
            .hi = {x + PILE_RADIUS, PILE_RADIUS, PILE_RADIUS},
            .step = {step},
            .reach = PILE_RADIUS};
}

alone_pile alone_coincident(size_t count)
{
    alone_pile out = {.count = count, .wanted = count * (count - 1) / 2};
    peer_body *bodies = allocate(count, sizeof *bodies);
    uint32_t *ids = allocate(count, sizeof *ids);
    bench_samples times;
    if (!bench_samples_init(&times, PILE_STEPS)) abort();
    for (size_t i = 0; i < count; i++) ids[i] = (uint32_t)i;
    stack_at(bodies, count, 0, 0);
    int64_t start = bench_now_ns();
    void *world = peer_ours.create(bodies, count, 1);
    out.build_us = 1e-3 * (double)(bench_now_ns() - start);
    for (int t = 1; t <= PILE_STEPS; t++) {
        stack_at(bodies, count, PILE_STRIDE * t, 0);
        bench_samples_add(&times, (int64_t)(1e3 * timed_step_us(world, ids, bodies, count)));
    }
    out.step_us = bench_percentile_us(&times, 0.5);
    out.pairs = peer_ours.step(world, ids, bodies, count);
    peer_ours.destroy(world);
    bench_samples_free(&times);
    free(bodies);
    free(ids);
    return out;
}

/* ---- for a long time ---- */

alone_drift alone_keep_moving(size_t count, size_t ticks)
{
    alone_drift out = {.count = count, .ticks = ticks};
    scene s = scene_create(count);
    void *world = create_world(&peer_ours, &s);
    peer_body *bodies = allocate(count, sizeof *bodies);
    size_t moved, tenth = ticks / 10;
    uint32_t *ids = scene_movers(&s, 100, &moved);
    for (size_t t = 0; t < ticks; t++) {
        scene_advance(&s, ids, moved, bodies);
        double us = timed_step_us(world, ids, bodies, moved) / (double)tenth;
        if (t < tenth) out.first_us += us;
        if (t >= ticks - tenth) out.last_us += us;
    }
    peer_ours.destroy(world);
    free(ids);
    free(bodies);
    scene_destroy(&s);
    return out;
}

/* ---- memory ---- */

/* What a world holds after a few ticks, and how many pairs it then has. */
static size_t bytes_of(const peer *p, size_t count, size_t *pairs)
{
    scene s = scene_create(count);
    size_t moved, before;
    uint32_t *ids = scene_movers(&s, 100, &moved);
    peer_body *bodies = allocate(count, sizeof *bodies);
    scene_state(&s, bodies);
    before = race_allocated();
    void *world = p->create(bodies, count, scene_side_m(&s));
    for (int t = 0; t < MEMORY_TICKS; t++) {
        scene_advance(&s, ids, moved, bodies);
        *pairs = p->step(world, ids, bodies, moved);
    }
    size_t bytes = race_allocated() - before;
    p->destroy(world);
    free(ids);
    free(bodies);
    scene_destroy(&s);
    return bytes;
}

/* A filter that refuses every pair leaves the bodies alone; what the same world holds beyond that is the pairs'. */
alone_memory alone_bytes(size_t count)
{
    size_t none, pairs, bodies_only = bytes_of(&peer_ours_empty, count, &none);
    size_t all = bytes_of(&peer_ours, count, &pairs);
    return (alone_memory){count, pairs, (double)bodies_only / (double)count,
        pairs ? ((double)all - (double)bodies_only) / (double)pairs : 0};
}
