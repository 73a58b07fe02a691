/* bench_subscriptions: what subscriptions cost a world, 10,000 and 100,000 of them: of clients with ten bodies and a
 * hundred subscriptions each, to touches, to distances and to contact points of bodies of their own by name, and of all
 * of their own by a pattern. A tenth of the bodies moves each tick. One row each: from the first subscription until all
 * are matched, per subscription; a tick then; and the memory of the process beyond that of the world without them. This
 * thread's processor time alone, one worker; one row is one number of subscriptions in the same world. */
#include "bench.h"

#include "world/world.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { BODIES_EACH = 10, SUBSCRIPTIONS_EACH = 100, ROWS = 3, TICKS_MAX = 100000, MATCHING_TICKS_MAX = 1000000 };
static const int64_t TICK_NS = 10000000;

static int64_t now_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

typedef struct scene {
    world *w;
    uint32_t *bodies;
    long clients;
    int64_t tick;
} scene;

static double in_use_mb(void)
{
    struct mallinfo2 m = mallinfo2();
    return 1e-6 * (double)(m.uordblks + m.hblkhd);
}

/* Of each client a row of cubes of which each touches the next. */
static void put_body(scene *s, long client, int k)
{
    char name[32], group[32];
    world_shape cube = {.shape = {.type = SHAPE_BOX, .half = {0.5, 0.5, 0.5}}, .local = POSE_IDENTITY};
    snprintf(name, sizeof name, "c%ld.body %d", client, k);
    snprintf(group, sizeof group, "c%ld", client);
    world_body def = {.name = name,
        .group = group,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = {{0.95 * k, 3.0 * (double)(client % 40), 3.0 * (double)(client / 40)}, {1, 0, 0, 0}},
        .shapes = &cube,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    if (world_put_body(s->w, &id, &def) != WORLD_OK) abort();
    s->bodies[client * BODIES_EACH + k] = id;
}

static void subscribe(scene *s, long client, int k)
{
    static const unsigned facts[] = {WORLD_TOUCH, WORLD_TOUCH | WORLD_DISTANCE, WORLD_TOUCH | WORLD_MANIFOLD};
    char a[32], b[32];
    snprintf(a, sizeof a, "c%ld.body %d", client, k % BODIES_EACH);
    snprintf(b, sizeof b, k % 7 ? "c%ld.*" : "c%ld.body %d", client, (k / BODIES_EACH) % BODIES_EACH);
    world_subscription def = {.facts = facts[k % 3],
        .select_a = a,
        .select_b = b,
        .range = 0.1,
        .relative_tolerance = 1e-6,
        .owner = (uint64_t)client + 1};
    uint32_t id = WORLD_NONE;
    if (world_put_subscription(s->w, &id, &def) != WORLD_OK) abort();
}

static int64_t tick(scene *s, bool moving)
{
    world_batches out;
    long count = s->clients * BODIES_EACH;
    s->tick++;
    for (long i = s->tick % 10; moving && i < count; i += 10) {
        long client = i / BODIES_EACH, k = i % BODIES_EACH;
        double x = 0.95 * (double)k + 0.004 * (double)(s->tick / 10 % 5);
        pose to = {{x, 3.0 * (double)(client % 40), 3.0 * (double)(client / 40)}, {1, 0, 0, 0}};
        world_move_body(s->w, s->bodies[i], to, s->tick * TICK_NS, NULL, NULL);
    }
    int64_t began = now_ns();
    world_tick(s->w, s->tick * TICK_NS, &out);
    return now_ns() - began;
}

/* Slices by slices, as a daemon does; true: all are matched, and what they tell first is told. */
static bool settle(scene *s, int64_t *took)
{
    for (int i = 0; i < MATCHING_TICKS_MAX; i++) {
        *took += tick(s, false);
        world_figures f = world_get_figures(s->w);
        if (!f.pending_pairs && !f.pending_bodies && i > 10) return true;
    }
    return false;
}

static bool run(long subscriptions, long clients, const bench_options *o)
{
    world_options options = world_options_default();
    options.workers = 1;
    bench_samples ticks;
    int64_t matching = 0, settling = 0, end;
    scene s = {.w = world_create(&options), .clients = clients};
    s.bodies = calloc((size_t)(clients * BODIES_EACH), sizeof *s.bodies);
    if (!s.bodies || !bench_samples_init(&ticks, TICKS_MAX)) abort();
    for (long c = 0; c < clients; c++)
        for (int k = 0; k < BODIES_EACH; k++) put_body(&s, c, k);
    if (!settle(&s, &settling)) return false;
    double before_mb = in_use_mb();
    matching -= now_ns();
    for (long i = 0; i < subscriptions; i++) subscribe(&s, i / SUBSCRIPTIONS_EACH, (int)(i % SUBSCRIPTIONS_EACH));
    matching += now_ns();
    bool settled = settle(&s, &matching);
    double mb = in_use_mb() - before_mb;
    end = now_ns() + (int64_t)(1e9 * o->seconds);
    while (now_ns() < end && ticks.count < TICKS_MAX) bench_samples_add(&ticks, tick(&s, true));
    world_figures f = world_get_figures(s.w);
    double us = bench_percentile_us(&ticks, 0.5), p99 = bench_percentile_us(&ticks, 0.99);
    printf(o->json ? "{\"bench\":\"subscriptions\",\"entry\":\"world_tick\",\"clients\":%ld,\"bodies\":%ld,"
                     "\"subscriptions\":%ld,\"matched\":%s,\"matching_us_each\":%.3f,\"tick_us_p50\":%.1f,"
                     "\"tick_us_p99\":%.1f,\"bytes_each\":%.0f,\"pairs\":%zu}\n"
                   : "%7ld %7ld %13ld %7s | %10.2f us | %9.1f us %9.1f us | %8.0f B | %zu\n",
        subscriptions / SUBSCRIPTIONS_EACH, clients * BODIES_EACH, subscriptions, settled ? "true" : "false",
        1e-3 * (double)matching / (double)subscriptions, us, p99, 1e6 * mb / (double)subscriptions, f.pairs);
    fflush(stdout);
    bench_samples_free(&ticks);
    free(s.bodies);
    world_destroy(s.w);
    return settled;
}

int main(int argc, char **argv)
{
    bench_options o;
    const long rows[ROWS] = {1000, 10000, 100000};
    bool all = true;
    if (!bench_parse(argc, argv, 2, 20, &o)) return EXIT_FAILURE;
    if (!o.json)
        printf("clients  bodies subscriptions matched | matching each | tick: median, 99 %% | memory each | pairs\n");
    /* Where --bodies says so, a small world. */
    long clients = o.bodies ? o.bodies / BODIES_EACH : rows[ROWS - 1] / SUBSCRIPTIONS_EACH;
    for (int i = 0; i < ROWS; i++)
        if (rows[i] <= clients * SUBSCRIPTIONS_EACH) all &= run(rows[i], clients, &o);
    return all ? EXIT_SUCCESS : EXIT_FAILURE;
}
