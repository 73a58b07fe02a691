/* bench_world: what a tick of the world costs. First temporal coherence: which stage of the cascade settles how many
 * pairs of a robot cell and of a crowd, and what the caches save. Then one body that moves in worlds of ever more
 * bodies: the cost follows what changed. Then what is predicted of 1,000 pairs over a second, and the ways of 10,000
 * bodies. One thread, one worker. At last worlds in which all bodies move, beside peers (world_moving.h). */
#include "bench.h"

#include "world/coherence.h"
#include "world/world.h"
#include "world_moving.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static world *create_world(bool caches)
{
    world_options o = world_options_default();
    o.caches = caches;
    world *w = world_create(&o);
    world_subscription touches = {.facts = WORLD_TOUCH, .select_a = "*", .select_b = "*", .tolerance = 1e-6};
    uint32_t id = WORLD_NONE;
    world_put_subscription(w, &id, &touches);
    return w;
}

/* ---- coherence ---- */

typedef struct player { /* one scene, with or without the caches */
    const coherence_scene *scene;
    world *w;
    uint32_t ids[COHERENCE_BODIES_MAX];
    bench_samples ticks;
    uint64_t touching, hash;
} player;

static const double SECONDS = 10, SECONDS_FULL = 100; /* of simulated time */

static void player_begin(player *p, const coherence_scene *scene, bool caches, size_t ticks)
{
    *p = (player){.scene = scene, .w = create_world(caches)};
    if (!bench_samples_init(&p->ticks, ticks)) abort();
    scene->create(p->w, p->ids);
}

static void player_tick(player *p, int tick)
{
    world_batches out;
    p->scene->move(p->w, p->ids, tick * p->scene->step_s);
    int64_t start = bench_now_ns();
    world_tick(p->w, tick, &out);
    bench_samples_add(&p->ticks, bench_now_ns() - start);
    for (size_t i = 0; i < out.count; i++)
        for (size_t k = 0; k < out.at[i].count; k++)
            p->touching += out.at[i].events[k].kind == EVENT_BEGIN || out.at[i].events[k].kind == EVENT_UPDATE;
    p->hash = out.hash;
}

static void player_end(player *p)
{
    world_destroy(p->w);
    bench_samples_free(&p->ticks);
}

static void tell_coherence(const coherence_scene *scene, player *cached, player *cold, bool json)
{
    world_figures f = world_get_figures(cached->w);
    double separated = (double)(f.pair_ticks - cached->touching);
    double motion = (double)f.stages[STAGE_MOTION_BOUND] / separated,
           axis = (double)f.stages[STAGE_CACHED_AXIS] / separated;
    double us = bench_percentile_us(&cached->ticks, 0.5), us_cold = bench_percentile_us(&cold->ticks, 0.5);
    double p99 = bench_percentile_us(&cached->ticks, 0.99), p99_cold = bench_percentile_us(&cold->ticks, 0.99);
    if (json)
        printf("{\"bench\":\"world\",\"entry\":\"world_tick\",\"scene\":\"%s\",\"pair_ticks\":%llu,\"separated\":%.0f,"
               "\"motion_bound\":%.5f,"
               "\"cached_axis\":%.5f,\"us_per_tick\":%.3f,\"us_p99\":%.3f,\"us_without_caches\":%.3f,"
               "\"us_p99_without_caches\":%.3f,\"same_events\":%s}\n",
            scene->name, (unsigned long long)f.pair_ticks, separated, motion, axis, us, p99, us_cold, p99_cold,
            cached->hash == cold->hash ? "true" : "false");
    else
        printf("%-12s %10.0f %11.2f %% %11.2f %% %9.2f %% %10.1f %10.1f %12.1f %12.1f  %s\n", scene->name, separated,
            100 * motion, 100 * axis, 100 * (1 - motion - axis), us, p99, us_cold, p99_cold,
            cached->hash == cold->hash ? "equal" : "DIFFERENT");
}

static void measure_coherence(bool json, double seconds)
{
    if (!json)
        printf("%-12s %10s %13s %13s %11s %10s %10s %12s %12s  %s\n", "scene", "separated", "motion bound",
            "cached axis", "asked", "us a tick", "p99", "no caches", "p99", "events");
    for (int i = 0; i < COHERENCE_SCENES; i++) {
        player cached, cold;
        int ticks = (int)(seconds / coherence_scenes[i].step_s);
        player_begin(&cached, &coherence_scenes[i], true, (size_t)ticks);
        player_begin(&cold, &coherence_scenes[i], false, (size_t)ticks);
        for (int t = 1; t <= ticks; t++) { /* interleaved, in turns first */
            player_tick(t % 2 ? &cached : &cold, t);
            player_tick(t % 2 ? &cold : &cached, t);
        }
        tell_coherence(&coherence_scenes[i], &cached, &cold, json);
        player_end(&cached);
        player_end(&cold);
    }
}

/* ---- one body moves ---- */

enum { ONE_TICKS = 4000 };

static uint32_t put_ball(world *w, size_t number, vec3 at)
{
    char name[24];
    snprintf(name, sizeof name, "b%zu", number);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 0.4}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    world_put_body(w, &id, &def);
    return id;
}

/* A grid of balls, 1 m apart. One of them walks through it, 5 cm a tick, and meets one ball after the other. */
static void measure_one(bool json, size_t bodies)
{
    world *w = create_world(true);
    world_batches out;
    size_t side = (size_t)ceil(cbrt((double)bodies));
    for (size_t i = 1; i < bodies; i++)
        put_ball(w, i, vec((double)(i % side), (double)(i / side % side), (double)(i / side / side)));
    uint32_t walker = put_ball(w, 0, VEC_ZERO);
    world_tick(w, 1, &out);
    bench_samples ticks;
    if (!bench_samples_init(&ticks, ONE_TICKS)) abort();
    double length = (double)side - 1;
    for (int t = 0; t < ONE_TICKS; t++) {
        double x = fabs(fmod(0.05 * t, 2 * length) - length), y = 0.5 * length;
        int64_t start = bench_now_ns();
        world_move_body(w, walker, (pose){vec(x, y, y), {1, 0, 0, 0}}, 0, NULL, NULL);
        world_tick(w, t + 2, &out);
        bench_samples_add(&ticks, bench_now_ns() - start);
    }
    double us = bench_percentile_us(&ticks, 0.5), p99 = bench_percentile_us(&ticks, 0.99);
    if (json)
        printf("{\"bench\":\"world\",\"entry\":\"world_tick\",\"scene\":\"one body "
               "moves\",\"bodies\":%zu,\"us_per_tick\":%.3f,\"us_p99\":%.3f}\n",
            bodies, us, p99);
    else
        printf("%-12zu %10.2f %10.2f\n", bodies, us, p99);
    bench_samples_free(&ticks);
    world_destroy(w);
}

/* ---- impacts ---- */

enum { PAIRS = 1000, FLYING = 10000, HZ = 100, IMPACT_TICKS_A_SECOND = 30 };

typedef struct flight { /* boxes that fly in straight lines through a box, and come back on its other side */
    world *w;
    uint32_t ids[FLYING];
    vec3 at[FLYING], velocity[FLYING];
    size_t bodies;
    vec3 side; /* m, of the box; 0: no end */
    bench_samples ticks;
    double busy_s; /* of this thread: other programs on this core do not count */
} flight;

static double drawn(uint64_t *state, double lo, double hi)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return lo + (hi - lo) * (double)(*state >> 11) * 0x1p-53;
}

static uint32_t put_box(world *w, size_t number, vec3 at, uint64_t group, world_ccd ccd, uint64_t *random)
{
    char name[24];
    snprintf(name, sizeof name, "b%zu", number);
    world_shape box = {.shape = {.type = SHAPE_BOX, .half = {0.3, 0.2, 0.1}}, .local = POSE_IDENTITY};
    quat q = {1, drawn(random, -1, 1), drawn(random, -1, 1), drawn(random, -1, 1)};
    world_body def = {.name = name,
        .group = "",
        .category = group,
        .mask = group,
        .ccd = ccd,
        .stamp_ns = 1000000000,
        .pose = {at, quat_unit(q)},
        .shapes = &box,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    world_put_body(w, &id, &def);
    return id;
}

/* 1,000 pairs, far from each other: each crosses a space of 4 m and passes by the middle within 2 m, so that the two
 * meet, or miss each other by little. Each starts anew when it has crossed. */
static void put_pairs(flight *f, uint64_t *random)
{
    f->bodies = 2 * PAIRS;
    for (size_t i = 0; i < f->bodies; i++) {
        vec3 middle = vec(20 * (double)(i / 2 % 32), 20 * (double)(i / 64), 0);
        vec3 way = vec(drawn(random, -1, 1), drawn(random, -1, 1), drawn(random, -1, 1));
        vec3 by = vec(drawn(random, -0.5, 0.5), drawn(random, -0.5, 0.5), drawn(random, -0.5, 0.5));
        f->velocity[i] = vec_scale(vec_unit(way), 2);
        f->at[i] = vec_add(vec_add(middle, by), vec_scale(f->velocity[i], drawn(random, -1, 0)));
        f->ids[i] = put_box(f->w, i, f->at[i], 1, WORLD_CCD_OFF, random);
    }
}

static void put_crowd(flight *f, uint64_t *random)
{
    double side = 2 * cbrt((double)FLYING);
    f->bodies = FLYING;
    f->side = vec(side, side, side);
    for (size_t i = 0; i < f->bodies; i++) {
        f->at[i] = vec(drawn(random, 0, side), drawn(random, 0, side), drawn(random, 0, side));
        f->velocity[i] = vec(drawn(random, -5, 5), drawn(random, -5, 5), drawn(random, -5, 5));
        f->ids[i] = put_box(f->w, i, f->at[i], 1, WORLD_CCD_FULL, random);
    }
}

static double wrapped(double x, double side)
{
    return side > 0 && x > side ? x - side : side > 0 && x < 0 ? x + side : x;
}

/* Pairs fly to and fro, so that what is predicted comes and goes; the crowd flies on. */
static void fly_tick(flight *f, int tick)
{
    int64_t now_ns = 1000000000 + (int64_t)tick * (1000000000 / HZ);
    for (size_t i = 0; i < f->bodies; i++) {
        if (f->side.x == 0 && tick % HZ == 0) f->velocity[i] = vec_neg(f->velocity[i]);
        vec3 to = vec_madd(f->at[i], 1.0 / HZ, f->velocity[i]);
        f->at[i] = vec(wrapped(to.x, f->side.x), wrapped(to.y, f->side.y), wrapped(to.z, f->side.z));
        pose at = {f->at[i], world_body_pose(f->w, f->ids[i]).q};
        bool jumps = f->at[i].x != to.x || f->at[i].y != to.y || f->at[i].z != to.z;
        (jumps ? world_teleport_body : world_move_body)(f->w, f->ids[i], at, now_ns, &f->velocity[i], NULL);
    }
    world_batches out;
    world_tick(f->w, now_ns, &out);
}

typedef struct flight_kind {
    const char *scene;
    unsigned facts; /* of the subscription */
    double horizon; /* s */
    void (*put)(flight *f, uint64_t *random);
} flight_kind;

static void tell_flight(const flight_kind *k, flight *f, bool json)
{
    world_figures n = world_get_figures(f->w);
    double ticks = (double)f->ticks.count, us = bench_percentile_us(&f->ticks, 0.5),
           p99 = bench_percentile_us(&f->ticks, 0.99);
    double share = f->busy_s / ticks * HZ;
    double sweeps = (double)n.sweeps / ticks, queries = (double)n.sweep_queries / ticks,
           by_axis = (double)n.sweeps_by_axis / ticks;
    if (json)
        printf(
            "{\"bench\":\"world\",\"entry\":\"world_tick\",\"scene\":\"%s\",\"bodies\":%zu,\"hz\":%d,\"us_per_tick\":%."
            "3f,\"us_p99\":%.3f,"
            "\"core_share\":%.5f,\"sweeps\":%.2f,\"sweep_queries\":%.2f,\"sweeps_by_axis\":%.2f,\"undecided\":%llu}\n",
            k->scene, f->bodies, HZ, us, p99, share, sweeps, queries, by_axis, (unsigned long long)n.undecided);
    else
        printf("%-28s %8zu %10.1f %10.1f %9.2f %% %10.1f %12.1f %12.1f\n", k->scene, f->bodies, us, p99, 100 * share,
            sweeps, queries, by_axis);
}

static double busy_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void measure_flight(const flight_kind *k, bool json, double seconds)
{
    static flight f;
    uint64_t random = 88172645463325252u;
    world_options o = world_options_default();
    int ticks = (int)ceil(seconds * IMPACT_TICKS_A_SECOND);
    f = (flight){.w = world_create(&o)};
    if (!bench_samples_init(&f.ticks, (size_t)ticks)) abort();
    world_subscription subscription = {
        .facts = k->facts, .select_a = "*", .select_b = "*", .tolerance = 1e-6, .horizon = k->horizon};
    uint32_t id = WORLD_NONE;
    world_put_subscription(f.w, &id, &subscription);
    k->put(&f, &random);
    double busy = busy_now();
    for (int t = 1; t <= ticks; t++) {
        int64_t start = bench_now_ns();
        fly_tick(&f, t);
        bench_samples_add(&f.ticks, bench_now_ns() - start);
    }
    f.busy_s = busy_now() - busy;
    tell_flight(k, &f, json);
    bench_samples_free(&f.ticks);
    world_destroy(f.w);
}

static void measure_flights(bool json, double seconds)
{
    static const flight_kind KINDS[] = {
        {"1,000 pairs predicted", WORLD_PREDICT, 1, put_pairs},
        {"1,000 pairs, not predicted", WORLD_TOUCH, 0, put_pairs},
        {"10,000 bodies swept", WORLD_IMPACT, 0, put_crowd},
    };
    if (!json)
        printf("\nimpacts, %d ticks a second\n%-28s %8s %10s %10s %11s %10s %12s %12s\n", HZ, "scene", "bodies",
            "us a tick", "p99", "of a core", "sweeps", "refinements", "by axis");
    for (size_t i = 0; i < sizeof KINDS / sizeof *KINDS; i++) measure_flight(&KINDS[i], json, seconds);
}

static void measure_moving(const bench_options *o)
{
    if (!o->json)
        printf("\nall bodies move and turn, 20 steps each in turns\n%-8s %-22s %-7s %7s %10s %10s %10s %10s %8s\n",
            "bodies", "contender", "facts", "workers", "ms", "p99", "contacts", "bytes", "to best");
    for (size_t bodies = 1000; bodies <= 100000; bodies *= 10)
        if (!o->bodies || (size_t)o->bodies == bodies) world_moving_measure(bodies, o->seconds, o->json);
}

int main(int argc, char **argv)
{
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    measure_coherence(o.json, o.seconds);
    if (!o.json) printf("\none body moves\n%-12s %10s %10s\n", "bodies", "us a tick", "p99");
    for (size_t bodies = 1000; bodies <= 1000000; bodies *= 10) {
        if (o.bodies && (size_t)o.bodies != bodies) continue;
        fprintf(stderr, "a world of %zu bodies\n", bodies);
        measure_one(o.json, bodies);
    }
    measure_flights(o.json, o.seconds);
    measure_moving(&o);
    return 0;
}
