/* bench_fit: what a robot's self-collision costs with its meshes, with their hulls, and with what collidectl fit makes
 * of them: ticks of a world that has only the robot, interleaved. It swings all joints through their ranges at 100 Hz,
 * or is in another state each tick (as a planner asks). The panda, by its SRDF's rules, or the project's own arm where
 * the shared folder is not there. One thread, one worker. */
#include "bench.h"

#include "loaders/fit/fit_robot.h"
#include "robot_world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double SECONDS = 20, SECONDS_FULL = 200; /* of simulated time */
enum { HZ = 100, CONTENDERS = 3, LINKS_MAX = 64 };
static const double EXCESS = 0.005;

typedef struct subject { /* a robot, fitted */
    pool pool;
    load_report report;
    robot robot;
    fit_robot fit;
    load_bodies bodies[CONTENDERS]; /* as solids, as hulls, fitted */
} subject;

static const char *const NAMES[CONTENDERS] = {"mesh", "hull", "fit"};

static void must(bool good, const load_report *r)
{
    if (good) return;
    fprintf(stderr, "bench_fit: %s\n", r->error);
    exit(1);
}

static robot_source find_source(void)
{
    static const load_package package = {
        "moveit_resources_panda_description", BENCH_SHARED "/robots/panda/panda_description"};
    const robot_source panda = {.urdf = BENCH_SHARED "/robots/panda/panda_description/urdf/panda.urdf",
        .srdf = BENCH_SHARED "/robots/panda/panda_moveit_config/config/panda.srdf",
        .packages = &package,
        .package_count = 1};
    if (access(panda.urdf, R_OK) == 0) return panda;
    fprintf(stderr, "%s is not there: the project's own arm instead\n", panda.urdf);
    return (robot_source){.urdf = BENCH_EXAMPLES "/arm.urdf", .srdf = BENCH_EXAMPLES "/arm.srdf"};
}

static void load_as(subject *s, int contender, load_mesh_as as)
{
    s->robot.source.meshes = (load_meshes){.as = as};
    double *values = pool_alloc(&s->pool, (size_t)s->robot.model.joint_count, sizeof *values);
    robot_default_values(&s->robot, values);
    must(robot_bodies(
             &s->robot, collided_pose_identity(), values, COLLIDED_MOVING, &s->pool, &s->bodies[contender], &s->report),
        &s->report);
}

static void add_proven(subject *s, const fit_pair *p)
{
    for (int side = 0; side < 2; side++) {
        load_body *body = &s->bodies[2].at[side ? p->b : p->a];
        body->rules[body->rule_count++] =
            (collided_rule){.pattern = s->bodies[2].at[side ? p->a : p->b].name, .allow = true, .reason = "proven"};
    }
}

static void prepare(subject *s)
{
    robot_source source = find_source();
    *s = (subject){0};
    must(robot_load(&s->robot, &s->pool, &source, &s->report), &s->report);
    load_as(s, 0, LOAD_MESH_SOLID);
    load_as(s, 1, LOAD_MESH_HULL);
    load_as(s, 2, LOAD_MESH_SOLID);
    fit_options o = {.excess_m = EXCESS};
    must(fit_robot_make(&s->pool, &s->robot, &o, &s->fit, &s->report), &s->report);
    for (size_t i = 0; i < s->fit.link_count; i++) {
        load_body *body = &s->bodies[2].at[i];
        collided_rule *rules = pool_alloc(&s->pool, body->rule_count + s->fit.link_count, sizeof *rules);
        memcpy(rules, body->rules, body->rule_count * sizeof *rules);
        body->rules = rules;
        body->shapes = s->fit.links[i].shapes;
        body->shape_count = s->fit.links[i].shape_count;
    }
    for (size_t i = 0; i < s->fit.pair_count; i++)
        if (s->fit.pairs[i].answer.verdict == NEVER_PROVEN) add_proven(s, &s->fit.pairs[i]);
}

/* ---- worlds ---- */

typedef struct player {
    world *w;
    uint32_t ids[LINKS_MAX];
    robot_world geometry;
    bench_samples ticks;
    int64_t sum_ns;
    uint64_t events;
} player;

static void player_begin(player *p, const load_bodies *bodies, unsigned facts, size_t ticks)
{
    world_options o = world_options_default();
    world_subscription subscription = {
        .facts = facts, .select_a = "*", .select_b = "*", .range = 0.5, .tolerance = 1e-6};
    uint32_t id = WORLD_NONE;
    *p = (player){.w = world_create(&o)};
    world_put_subscription(p->w, &id, &subscription);
    if (bodies->count > LINKS_MAX || !bench_samples_init(&p->ticks, ticks)) abort();
    for (size_t i = 0; i < bodies->count; i++) p->ids[i] = robot_world_put(&p->geometry, p->w, &bodies->at[i]);
}

static void player_end(player *p)
{
    world_destroy(p->w);
    bench_samples_free(&p->ticks);
    robot_world_free(&p->geometry);
}

static void player_tick(player *p, int tick, const collided_pose *poses, size_t count)
{
    world_batches out;
    int64_t start = bench_now_ns();
    for (size_t i = 0; i < count; i++) world_move_body(p->w, p->ids[i], robot_world_pose(&poses[i]), 0, NULL, NULL);
    world_tick(p->w, tick, &out);
    int64_t took = bench_now_ns() - start;
    bench_samples_add(&p->ticks, took);
    p->sum_ns += took;
    for (size_t i = 0; i < out.count; i++) p->events += out.at[i].count;
}

/* ---- motion ---- */

static double drawn(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) * 0x1p-53;
}

/* Each joint goes to and fro through its range, in 4 to 10 s; or is anywhere. */
static void set_values(const robot *r, bool random, int tick, uint64_t *state, double *values)
{
    for (int i = 0; i < r->model.joint_count; i++) {
        const urdf_joint *j = &r->model.joints[i];
        double lo = j->limited ? j->lower : -3, hi = j->limited ? j->upper : 3;
        double period_s = 4 + 6 * fmod(0.618 * (i + 1), 1),
               swing = 0.5 - 0.5 * cos(2 * acos(-1) * tick / HZ / period_s);
        values[i] = lo + (hi - lo) * (random ? drawn(state) : swing);
    }
}

static void tell(const subject *s, const char *facts, const char *motion, player *players, bool json)
{
    double mesh = bench_percentile_us(&players[0].ticks, 0.5);
    for (int i = 0; i < CONTENDERS; i++) {
        double mean = 1e-3 * (double)players[i].sum_ns / (double)players[i].ticks.count;
        double us = bench_percentile_us(&players[i].ticks, 0.5), p99 = bench_percentile_us(&players[i].ticks, 0.99);
        if (json)
            printf("{\"bench\":\"fit\",\"entry\":\"world_tick\",\"robot\":\"%s\",\"facts\":\"%s\",\"motion\":\"%s\","
                   "\"contender\":\"%s\","
                   "\"excess_m\":%g,\"us_per_tick\":%.3f,\"us_mean\":%.3f,\"us_p99\":%.3f,\"times_cheaper\":%.3f,"
                   "\"events\":%llu}\n",
                s->robot.model.name, facts, motion, NAMES[i], i == 2 ? EXCESS : 0, us, mean, p99, mesh / us,
                (unsigned long long)players[i].events);
        else
            printf("%-10s %-10s %-10s %-6s %12.2f %12.2f %12.2f %12.1f %10llu\n", s->robot.model.name, facts, motion,
                NAMES[i], us, mean, p99, mesh / us, (unsigned long long)players[i].events);
    }
}

static void measure(subject *s, unsigned facts, const char *name, bool random, size_t ticks, bool json)
{
    player players[CONTENDERS];
    size_t count = robot_body_count(&s->robot);
    double *values = calloc((size_t)s->robot.model.joint_count + 1, sizeof *values);
    collided_pose *poses = calloc(count + 1, sizeof *poses);
    uint64_t state = 88172645463325252u;
    if (!values || !poses) abort();
    for (int i = 0; i < CONTENDERS; i++) player_begin(&players[i], &s->bodies[i], facts, ticks);
    for (int t = 1; t <= (int)ticks; t++) {
        set_values(&s->robot, random, t, &state, values);
        robot_body_poses(&s->robot, collided_pose_identity(), values, poses);
        for (int i = 0; i < CONTENDERS; i++) player_tick(&players[(t + i) % CONTENDERS], t, poses, count);
    }
    tell(s, name, random ? "anywhere" : "swinging", players, json);
    for (int i = 0; i < CONTENDERS; i++) {
        player_end(&players[i]);
    }
    free(values);
    free(poses);
}

int main(int argc, char **argv)
{
    static subject s;
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    fprintf(stderr, "fitting\n");
    prepare(&s);
    if (!o.json)
        printf("%-10s %-10s %-10s %-6s %12s %12s %12s %12s %10s\n", "robot", "facts", "motion", "shapes", "us a tick",
            "mean", "p99", "times", "events");
    for (int random = 0; random < 2; random++) {
        measure(&s, WORLD_TOUCH, "touch", random, (size_t)(o.seconds * HZ), o.json);
        measure(&s, WORLD_TOUCH | WORLD_DISTANCE, "distance", random, (size_t)(o.seconds * HZ), o.json);
    }
    pool_free(&s.pool);
    return 0;
}
