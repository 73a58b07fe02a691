/* broad_race: builds the lanes, runs the cells, judges, and ranks. One thread. A lane that did not see all ticks is
 * stale, and is built anew before it runs again; nothing of that is timed. */
#include "broad_race.h"

#include "bench.h"

#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES_MOST = 16,
    BLOCK_MOVES = 65536, /* a block has so many moves if it can: most of its ticks find warm caches */
    BLOCK_TICKS_MOST = 64,
    BLOCKS_LEAST = 3,
    TICKS_LEAST = 16, /* as long as our fat boxes last: no wave of bodies that leave theirs falls between */
    WAVE_TICKS = 24,  /* until ours leave at different times */
    SETTLE_TICKS = 3,
    TICKS_MOST = 200000,
    WATCH_ALL = 10000, /* bodies: up to here the truth is whole */
    WATCH_SOME = 256,
    FORECAST_FIRST = 4096, /* bodies of the first trial */
    FORECAST_FROM = 32768, /* smaller worlds are built without a trial */
};
static const double FORECAST_TRIAL_S = 1; /* a trial that took longer is the last one */
static const double MINUTE_S = 60;
static const double SLOW = 4; /* times the best peer's time, see give_up_slow */

typedef struct lane {
    const peer *peer;
    bool ours, stale;
    void *world; /* NULL = left out */
    char left_out[96];
    double build_s, all_s; /* one build; by forecast, one step of all */
    ptrdiff_t bytes;

    /* of the present cell */
    char sits_out[96];   /* why it does not take part */
    bool resting;        /* had its warm-up, which is all that there was time for */
    bench_samples times; /* of ticks */
    double median, mean; /* us */
    verdict verdict;
    size_t missed;
} lane;

typedef struct race {
    scene scene;
    const race_limits *limits;
    race_report *report;
    void *context;
    lane lanes[LANES_MOST];
    size_t lane_count, rotation;

    /* the present cell */
    double percent;
    uint32_t *movers;
    size_t mover_count, block_ticks;
    peer_body *block; /* block_ticks * mover_count */
    size_t true_pairs;
} race;

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

static double seconds_since(int64_t start_ns)
{
    return 1e-9 * (double)(bench_now_ns() - start_ns);
}

size_t race_allocated(void)
{
    struct mallinfo2 m = mallinfo2();
    return m.uordblks + m.hblkhd;
}

/* ---- building ---- */

typedef struct trial {
    double build_s, step_s;
} trial;

/* A build and a step of all, in a world of its own. */
static trial try_size(const peer *p, size_t count)
{
    trial t;
    scene s = scene_create(count);
    peer_body *bodies = allocate(count, sizeof *bodies);
    size_t moved;
    uint32_t *ids = scene_movers(&s, 100, &moved);
    scene_state(&s, bodies);
    int64_t start = bench_now_ns();
    void *world = p->create(bodies, count, scene_side_m(&s));
    t.build_s = seconds_since(start);
    scene_advance(&s, ids, moved, bodies);
    start = bench_now_ns();
    p->step(world, ids, bodies, moved);
    t.step_s = seconds_since(start);
    p->destroy(world);
    free(ids);
    free(bodies);
    scene_destroy(&s);
    return t;
}

/* From two sizes, the second twice the first, by a power law; nothing grows less than in proportion. */
static double extrapolate(double small_s, double large_s, double times)
{
    double exponent = fmax(1, log2(large_s / small_s));
    return large_s * pow(times, exponent);
}

/* Doubles the size until it is clear what the wanted one takes. */
static trial forecast(const peer *p, size_t count)
{
    size_t size = FORECAST_FIRST;
    trial small = try_size(p, size), large = small;
    while (4 * size <= count) {
        size *= 2;
        large = try_size(p, size);
        if (large.build_s + large.step_s > FORECAST_TRIAL_S || 4 * size > count) break;
        small = large;
    }
    double times = (double)count / (double)size;
    return (trial){extrapolate(small.build_s, large.build_s, times), extrapolate(small.step_s, large.step_s, times)};
}

static void tell_slow(char text[96], const char *what, double takes_s)
{
    snprintf(text, 96, "%s takes about %.0f s%s", what, takes_s,
        takes_s > MINUTE_S ? ", more than a minute" : "; --full waits for it");
}

static bool is_admitted(race *r, lane *l)
{
    size_t count = r->scene.count;
    if (l->peer->most && count > l->peer->most) {
        snprintf(l->left_out, sizeof l->left_out, "%s %zu bodies",
            l->ours ? "a sweep: raced only with at most" : "holds at most", l->peer->most);
        return false;
    }
    if (l->ours || count < FORECAST_FROM) return true;
    trial t = forecast(l->peer, count);
    l->all_s = t.step_s;
    if (t.build_s > r->limits->build_s) tell_slow(l->left_out, "a build", t.build_s);
    return !l->left_out[0];
}

static void build_lane(race *r, lane *l, const peer_body *bodies)
{
    size_t before = race_allocated();
    int64_t start = bench_now_ns();
    l->world = l->peer->create(bodies, r->scene.count, scene_side_m(&r->scene));
    l->build_s = seconds_since(start);
    l->bytes = (ptrdiff_t)(race_allocated() - before);
    l->stale = false;
    fprintf(stderr, "  %s: built in %.2f s\n", l->peer->name, l->build_s);
}

static void build_lanes(race *r)
{
    peer_body *bodies = allocate(r->scene.count, sizeof *bodies);
    scene_state(&r->scene, bodies);
    for (size_t i = 0; i < broad_contender_count && r->lane_count < LANES_MOST; i++) {
        const peer *p = broad_contenders[i];
        bool ours = i < broad_ours_count;
        if (r->limits->only && !ours && strcmp(r->limits->only, p->name) != 0) continue;
        lane *l = &r->lanes[r->lane_count++];
        *l = (lane){.peer = p, .ours = ours};
        if (is_admitted(r, l))
            build_lane(r, l, bodies);
        else
            fprintf(stderr, "  %s: left out: %s\n", l->peer->name, l->left_out);
    }
    free(bodies);
}

/* ---- one cell ---- */

static bool takes_part(const lane *l)
{
    return l->world && !l->sits_out[0];
}

static bool runs(const lane *l)
{
    return takes_part(l) && !l->resting;
}

static void next_block(race *r)
{
    for (size_t t = 0; t < r->block_ticks; t++)
        scene_advance(&r->scene, r->movers, r->mover_count, r->block + t * r->mover_count);
}

/* False: it ran out of time, and has not seen the rest of the block. */
static bool run_block(const race *r, lane *l, double limit_s)
{
    int64_t begin = bench_now_ns();
    for (size_t t = 0; t < r->block_ticks; t++) {
        if (t && seconds_since(begin) > limit_s) return false;
        int64_t start = bench_now_ns();
        l->peer->step(l->world, r->movers, r->block + t * r->mover_count, r->mover_count);
        bench_samples_add(&l->times, bench_now_ns() - start);
    }
    return true;
}

/* Built anew: who had to catch up with all that it did not see could be left with a bad tree, and be judged by it. */
static void rebuild_stale(race *r)
{
    peer_body *bodies = allocate(r->scene.count, sizeof *bodies);
    scene_state(&r->scene, bodies);
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        if (!takes_part(l) || !l->stale) continue;
        l->peer->destroy(l->world);
        build_lane(r, l, bodies);
    }
    free(bodies);
}

static void summarise(lane *l)
{
    double sum = 0;
    for (size_t i = 0; i < l->times.count; i++) sum += 1e-3 * (double)l->times.at_ns[i];
    l->mean = sum / (double)l->times.count;
    l->median = bench_percentile_us(&l->times, 0.5);
}

static double best_peer(const race *r, bool of_means)
{
    double best = INFINITY;
    for (size_t i = 0; i < r->lane_count; i++) {
        const lane *l = &r->lanes[i];
        if (takes_part(l) && !l->ours && !l->missed) best = fmin(best, of_means ? l->mean : l->median);
    }
    return best;
}

/* What is hopelessly behind and would cost the others their ticks rests; its row is its warm-up. */
static void give_up_slow(race *r)
{
    double best = best_peer(r, false), share_us = 1e6 * r->limits->cell_s / (double)r->lane_count;
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        if (!runs(l) || l->ours || l->median <= SLOW * best) continue;
        l->resting = l->stale = l->median * BLOCKS_LEAST * (double)r->block_ticks > share_us;
    }
}

/* Ours alone, until its bodies leave their fat boxes at different times, as they do in a world that has been running;
 * in the first ticks after all began to move, they leave in waves. The others then join anew. */
static void let_waves_pass(race *r)
{
    for (int t = 0; t < WAVE_TICKS; t++) {
        scene_advance(&r->scene, r->movers, r->mover_count, r->block);
        for (size_t i = 0; i < r->lane_count; i++) {
            lane *l = &r->lanes[i];
            if (l->ours && l->world) l->peer->step(l->world, r->movers, r->block, r->mover_count);
            l->stale |= !l->ours;
        }
    }
}

/* Until every lane is at home with who moves and who rests (Bullet's tree hands bodies from one set to another for two
 * ticks). Memory is looked at here only: what a world grows to hold, it holds after its first ticks. */
static void settle(race *r)
{
    for (int t = 0; t < SETTLE_TICKS; t++) {
        scene_advance(&r->scene, r->movers, r->mover_count, r->block);
        for (size_t i = 0; i < r->lane_count; i++) {
            lane *l = &r->lanes[i];
            if (!takes_part(l)) continue;
            size_t before = race_allocated();
            l->peer->step(l->world, r->movers, r->block, r->mover_count);
            l->bytes += (ptrdiff_t)(race_allocated() - before);
        }
    }
}

/* One block, which decides who is too slow for more. */
static void warm_up(race *r)
{
    next_block(r);
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        if (!takes_part(l)) continue;
        bool whole = run_block(r, l, l->ours ? INFINITY : r->limits->cell_s);
        l->resting = l->stale = !whole;
        summarise(l);
    }
}

/* Beside the truth of the watched bodies: no one may know of fewer true pairs than another. */
static void check(race *r)
{
    size_t watch = r->scene.count <= WATCH_ALL ? r->scene.count : WATCH_SOME;
    truth t = truth_find(&r->scene, watch);
    r->true_pairs = 0;
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        if (!runs(l)) continue;
        l->verdict = truth_judge(&t, &r->scene, l->peer, l->world);
        if (l->verdict.overlap > r->true_pairs) r->true_pairs = l->verdict.overlap;
    }
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        if (!runs(l)) continue;
        size_t behind = r->true_pairs - l->verdict.overlap;
        l->missed += behind > l->verdict.missed ? behind : l->verdict.missed;
    }
    truth_destroy(&t);
}

static void forget_warm_up(race *r)
{
    for (size_t i = 0; i < r->lane_count; i++)
        if (runs(&r->lanes[i])) r->lanes[i].times.count = 0;
}

static void measure(race *r)
{
    int64_t start = bench_now_ns();
    for (size_t blocks = 0, ticks = 0;
         blocks < BLOCKS_LEAST || ticks < TICKS_LEAST || seconds_since(start) < r->limits->cell_s; blocks++) {
        ticks += r->block_ticks;
        if (ticks > TICKS_MOST) break;
        next_block(r);
        for (size_t i = 0; i < r->lane_count; i++) {
            lane *l = &r->lanes[(i + r->rotation) % r->lane_count];
            if (runs(l)) run_block(r, l, INFINITY);
        }
        r->rotation++;
    }
    for (size_t i = 0; i < r->lane_count; i++)
        if (takes_part(&r->lanes[i])) summarise(&r->lanes[i]);
}

static void report_lane(const race *r, lane *l)
{
    race_row row = {.count = r->scene.count,
        .moved = r->mover_count,
        .percent = r->percent,
        .contender = l->peer->name,
        .called = l->peer->entry,
        .ours = l->ours,
        .neighbours = 2 * (double)r->true_pairs / (double)r->scene.count,
        .ratio = NAN,
        .ratio_of_means = NAN};
    memcpy(row.left_out, l->world ? l->sits_out : l->left_out, sizeof row.left_out);
    if (takes_part(l)) {
        double best = best_peer(r, false), best_mean = best_peer(r, true);
        row.ticks = l->times.count;
        row.us_median = l->median;
        row.us_mean = l->mean;
        row.us_p99 = bench_percentile_us(&l->times, 0.99);
        row.ns_per_moved = 1e3 * l->median / (double)r->mover_count;
        row.bytes_per_body = (double)l->bytes / (double)r->scene.count;
        row.build_s = l->build_s;
        row.pairs = l->verdict.pairs;
        row.extra = l->verdict.pairs - l->verdict.overlap;
        row.missed = l->missed;
        if (isfinite(best)) row.ratio = l->median / best, row.ratio_of_means = l->mean / best_mean;
    }
    r->report(r->context, &row);
}

static void begin_cell(race *r, double percent)
{
    r->percent = percent;
    r->movers = scene_movers(&r->scene, percent, &r->mover_count);
    r->block_ticks = 1;
    while (r->block_ticks < BLOCK_TICKS_MOST && (r->block_ticks + 1) * r->mover_count <= BLOCK_MOVES) r->block_ticks++;
    r->block = allocate(r->block_ticks * r->mover_count, sizeof *r->block);
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        double step_s = l->all_s * percent / 100; /* of those who move: what it takes at least */
        l->resting = false;
        l->missed = 0;
        l->sits_out[0] = '\0';
        if (step_s > r->limits->step_s) tell_slow(l->sits_out, "a step", step_s);
        l->stale |= l->sits_out[0] != '\0';
        if (!bench_samples_init(&l->times, TICKS_MOST + BLOCK_TICKS_MOST)) abort();
    }
}

static void end_cell(race *r)
{
    for (size_t i = 0; i < r->lane_count; i++) bench_samples_free(&r->lanes[i].times);
    free(r->movers);
    free(r->block);
}

static void run_cell(race *r, double percent)
{
    fprintf(stderr, "  %g %% moving\n", percent);
    begin_cell(r, percent);
    let_waves_pass(r);
    rebuild_stale(r);
    settle(r);
    check(r); /* everybody, while everybody is up to date */
    warm_up(r);
    give_up_slow(r);
    forget_warm_up(r);
    measure(r);
    check(r);
    for (size_t i = 0; i < r->lane_count; i++) report_lane(r, &r->lanes[i]);
    end_cell(r);
}

void race_run(size_t count, const double *percents, size_t percent_count, const race_limits *limits,
    race_report *report, void *context)
{
    race r = {.scene = scene_create(count), .limits = limits, .report = report, .context = context};
    fprintf(stderr, "%zu bodies in a cube of %.1f m\n", count, scene_side_m(&r.scene));
    build_lanes(&r);
    for (size_t i = 0; i < percent_count; i++) run_cell(&r, percents[i]);
    for (size_t i = 0; i < r.lane_count; i++)
        if (r.lanes[i].world) r.lanes[i].peer->destroy(r.lanes[i].world);
    scene_destroy(&r.scene);
}
