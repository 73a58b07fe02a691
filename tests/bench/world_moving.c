/* world_moving: see the header. Worlds with one worker and with two, with a subscription to all touches and without
 * one, and peers as they come from Debian, 20 steps each in turns, all from the same poses. Bytes a body are what
 * the resident set grew by until the world had made its first ticks. */
#include "world_moving.h"

#include "bench.h"
#include "moving_scene.h"
#include "world/world.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { STEPS_A_TURN = 20, TURNS_LEAST = 3, TURNS_MOST = 100, WARM_STEPS = 10, CONTENDERS_MAX = 8 };

typedef struct contender {
    const char *name, *entry;
    unsigned workers;
    bool subscribes;
    const moving_peer *peer; /* NULL: ours */
    void *peer_world;
    world *w;
    uint32_t *ids;
    int64_t now_ns;
    size_t contacts;
    double bytes_a_body; /* NAN: of another's code, which was not measured alone */
    bench_samples steps;
} contender;

static double resident_bytes(void)
{
    unsigned long all = 0, resident = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    if (!f || fscanf(f, "%lu %lu", &all, &resident) != 2) abort();
    fclose(f);
    return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

static shape shape_of(const moving_body *b)
{
    switch (b->kind) {
    case MOVING_BALL:
        return (shape){.type = SHAPE_SPHERE, .radius = b->half[0]};
    case MOVING_BOX:
        return (shape){.type = SHAPE_BOX, .half = {b->half[0], b->half[1], b->half[2]}};
    default:
        return (shape){.type = SHAPE_CAPSULE, .radius = b->half[0], .half = {.z = b->half[1]}};
    }
}

static pose pose_of(const moving_scene *s, size_t i)
{
    const double *p = &s->positions[3 * i], *q = &s->orientations[4 * i];
    return (pose){{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
}

static void put_bodies(contender *c, const moving_scene *s)
{
    for (size_t i = 0; i < s->count; i++) {
        char name[24];
        snprintf(name, sizeof name, "b%zu", i);
        world_shape one = {.shape = shape_of(&s->bodies[i]), .local = POSE_IDENTITY};
        world_body def = {.name = name,
            .group = "",
            .category = 1,
            .mask = 1,
            .pose = pose_of(s, i),
            .shapes = &one,
            .shape_count = 1};
        c->ids[i] = WORLD_NONE;
        if (world_put_body(c->w, &c->ids[i], &def) != WORLD_OK) abort();
    }
}

static void count_contacts(contender *c, const world_batches *out)
{
    for (size_t i = 0; i < out->count; i++)
        for (size_t k = 0; k < out->at[i].count && !out->at[i].snapshot; k++) {
            uint8_t kind = (uint8_t)out->at[i].events[k].kind;
            if (kind == EVENT_BEGIN) c->contacts++;
            if (kind == EVENT_END) c->contacts--;
        }
}

/* All that the daemon does in a tick: the poses as they came, and the tick. */
static void step_ours(contender *c, const moving_scene *s)
{
    world_poses moved = {.ids = c->ids,
        .count = s->count,
        .positions = s->positions,
        .orientations = s->orientations,
        .stamp_ns = c->now_ns};
    world_batches out;
    static uint32_t *left_out;
    static size_t room;
    if (room < s->count) {
        room = s->count;
        left_out = realloc(left_out, room * sizeof *left_out);
        if (!left_out) abort();
    }
    int64_t start = bench_now_ns();
    world_move_bodies(c->w, &moved, left_out);
    world_tick(c->w, c->now_ns, &out);
    bench_samples_add(&c->steps, bench_now_ns() - start);
    c->now_ns += 1000000000 / MOVING_HZ;
    count_contacts(c, &out);
}

static void step_peer(contender *c, const moving_scene *s)
{
    int64_t start = bench_now_ns();
    c->contacts = c->peer->step(c->peer_world, s);
    bench_samples_add(&c->steps, bench_now_ns() - start);
}

static void contender_step(contender *c, const moving_scene *s)
{
    (c->peer ? step_peer : step_ours)(c, s);
}

static void begin_ours(contender *c, const moving_scene *s)
{
    world_options o = world_options_default();
    double before = resident_bytes();
    o.workers = c->workers;
    c->w = world_create(&o);
    c->now_ns = 1000000000;
    world_subscription touches = {.facts = WORLD_TOUCH, .select_a = "*", .select_b = "*", .tolerance = 1e-6};
    uint32_t id = WORLD_NONE;
    if (c->subscribes && world_put_subscription(c->w, &id, &touches) != WORLD_OK) abort();
    put_bodies(c, s);
    for (int i = 0; i < WARM_STEPS; i++) step_ours(c, s); /* nothing moves */
    c->bytes_a_body = (resident_bytes() - before) / (double)s->count;
}

static void contender_begin(contender *c, const moving_scene *s)
{
    if (!bench_samples_init(&c->steps, STEPS_A_TURN * (TURNS_MOST + 1))) abort();
    c->ids = malloc(s->count * sizeof *c->ids);
    if (!c->ids) abort();
    if (c->peer)
        c->peer_world = c->peer->create(s);
    else
        begin_ours(c, s);
    c->steps.count = 0;
}

static void contender_end(contender *c)
{
    if (c->peer)
        c->peer->destroy(c->peer_world);
    else
        world_destroy(c->w);
    free(c->ids);
    bench_samples_free(&c->steps);
}

static void print_row(contender *c, const moving_scene *s, double best_peer_us, bool json)
{
    double us = bench_percentile_us(&c->steps, 0.5), p99 = bench_percentile_us(&c->steps, 0.99);
    bool counted = c->peer || c->subscribes;
    if (!json) {
        char contacts[24] = "", bytes[24] = "", ratio[24] = "";
        if (counted) snprintf(contacts, sizeof contacts, "%.3f", (double)c->contacts / (double)s->count);
        if (!c->peer) snprintf(bytes, sizeof bytes, "%.0f", c->bytes_a_body);
        if (!c->peer && best_peer_us > 0) snprintf(ratio, sizeof ratio, "%.2f", us / best_peer_us);
        printf("%-8zu %-22s %-7s %7u %10.3f %10.3f %10s %10s %8s\n", s->count, c->name,
            c->peer || c->subscribes ? "touch" : "none", c->workers, 1e-3 * us, 1e-3 * p99, contacts, bytes, ratio);
        return;
    }
    printf("{\"bench\":\"world\",\"entry\":\"%s\",\"scene\":\"all move\",\"contender\":\"%s\",\"bodies\":%zu,"
           "\"moving\":%zu,\"facts\":\"%s\",\"workers\":%u,\"ms_median\":%.4f,\"ms_p99\":%.4f,",
        c->entry, c->name, s->count, s->count, counted ? "touch" : "none", c->workers, 1e-3 * us, 1e-3 * p99);
    printf(counted ? "\"contacts\":%zu," : "\"contacts\":null,", c->contacts);
    if (c->peer)
        printf("\"bytes_a_body\":null}\n");
    else
        printf("\"bytes_a_body\":%.0f}\n", c->bytes_a_body);
}

static size_t choose(contender out[CONTENDERS_MAX], size_t bodies)
{
    size_t n = 0;
    out[n++] = (contender){.name = "collided", .entry = "world_tick", .workers = 1, .subscribes = true};
    out[n++] = (contender){.name = "collided", .entry = "world_tick", .workers = 2, .subscribes = true};
    out[n++] = (contender){.name = "collided, nobody asks", .entry = "world_tick", .workers = 1};
    for (size_t i = 0; i < moving_peer_count && n < CONTENDERS_MAX; i++)
        if (bodies <= moving_peers[i]->most)
            out[n++] = (contender){
                .name = moving_peers[i]->name, .entry = moving_peers[i]->entry, .workers = 1, .peer = moving_peers[i]};
    return n;
}

/* The next steps of the scene, by each in turns: the one is as warm as the other, as the daemon is when poses come. */
static void take_turns(contender *all, size_t count, size_t first, moving_scene *s, moving_scene *scratch)
{
    for (size_t i = 0; i < count; i++) {
        moving_scene_copy(scratch, s);
        for (int k = 0; k < STEPS_A_TURN; k++) {
            moving_scene_step(scratch);
            contender_step(&all[(first + i) % count], scratch);
        }
    }
    moving_scene_copy(s, scratch);
}

static size_t turns_of(double first_s, double seconds)
{
    double n = seconds / first_s;
    return n < TURNS_LEAST ? TURNS_LEAST : n > TURNS_MOST ? TURNS_MOST : (size_t)n;
}

static double best_of_peers_us(contender *all, size_t count)
{
    double best = 0;
    for (size_t i = 0; i < count; i++) {
        double us = bench_percentile_us(&all[i].steps, 0.5);
        if (all[i].peer && (best == 0 || us < best)) best = us;
    }
    return best;
}

void world_moving_measure(size_t bodies, double seconds, bool json)
{
    contender all[CONTENDERS_MAX];
    moving_scene *s = moving_scene_create(bodies), *scratch = moving_scene_create(bodies);
    size_t count = choose(all, bodies);
    fprintf(stderr, "%zu bodies that all move\n", bodies);
    for (size_t i = 0; i < count; i++) contender_begin(&all[i], s);
    int64_t start = bench_now_ns();
    take_turns(all, count, 0, s, scratch);
    size_t turns = turns_of(1e-9 * (double)(bench_now_ns() - start), seconds);
    for (size_t i = 0; i < count; i++) all[i].steps.count = 0;
    for (size_t k = 0; k < turns; k++) take_turns(all, count, k, s, scratch);
    double best = best_of_peers_us(all, count);
    for (size_t i = 0; i < count; i++) print_row(&all[i], s, best, json);
    for (size_t i = 0; i < count; i++) contender_end(&all[i]);
    moving_scene_destroy(s);
    moving_scene_destroy(scratch);
}
