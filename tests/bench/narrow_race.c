/* narrow_race: finds the truth, runs the lanes, judges, and ranks. One thread. */
#include "narrow_race.h"

#include "bench.h"
#include "narrow_goals.h"
#include "narrow_truth_compound.h"
#include "narrow_truth_mesh.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LANES_MOST = 48, ROUNDS_MOST = 400 };

typedef struct lane {
    const narrow_peer *peer;
    const narrow_entry *entry; /* NULL = as its settings say */
    void *self;
    narrow_answer *answers;
    bench_samples times; /* of blocks */
    int64_t *by_block;   /* the same, ROUNDS_MOST a block */
    size_t rounds;
    int64_t spent_ns; /* in timed blocks */
    narrow_figures figures;
} lane;

typedef struct race {
    const narrow_pair *pair;
    narrow_scene scene;
    narrow_truth *truths;
    lane lanes[LANES_MOST];
    size_t lane_count, block_count;
    size_t *order; /* of blocks */
    size_t turns[LANES_MOST];
    uint32_t chance;
} race;

static void *allocate(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

static void enter(race *r, const narrow_peer *p, const narrow_entry *entry)
{
    lane *l = &r->lanes[r->lane_count++];
    narrow_row row = r->scene.row;
    row.own = entry ? entry->own : 0;
    l->peer = p;
    l->entry = entry;
    l->self = p->create(r->scene.items, r->scene.count, &row);
    l->by_block = allocate(ROUNDS_MOST * r->block_count, sizeof *l->by_block);
    l->answers = allocate(r->scene.count, sizeof *l->answers);
    if (!bench_samples_init(&l->times, ROUNDS_MOST * r->block_count)) abort();
}

static void enter_all(race *r, const char *only)
{
    for (size_t i = 0; i < narrow_contender_count && r->lane_count < LANES_MOST; i++) {
        const narrow_peer *p = narrow_contenders[i];
        bool wanted = p->ours || !only || strcmp(only, p->name) == 0;
        if (wanted && p->takes(&r->scene.row)) enter(r, p, NULL);
    }
}

static void enter_sweep(race *r, const narrow_limits *limits)
{
    bool apart = r->scene.row.regime == REGIME_SEPARATED;
    for (size_t i = 0; i < limits->entry_count && r->lane_count < LANES_MOST; i++) {
        const narrow_entry *e = &limits->entries[i];
        if ((apart ? e->gaps : e->contacts) && e->peer->takes(&r->scene.row)) enter(r, e->peer, e);
    }
}

/* ---- time ---- */

/* Fisher-Yates; xorshift will do. */
static void shuffle(race *r, size_t *order, size_t count)
{
    for (size_t i = count; i-- > 1;) {
        r->chance ^= r->chance << 13, r->chance ^= r->chance >> 17, r->chance ^= r->chance << 5;
        size_t j = r->chance % (i + 1), swap = order[i];
        order[i] = order[j];
        order[j] = swap;
    }
}

/* In another order each round: who always ran after the same code would find the processor warm for it. */
static void mix_lanes(race *r)
{
    for (size_t i = 0; i < r->lane_count; i++) r->turns[i] = i;
    shuffle(r, r->turns, r->lane_count);
}

static void warm_up(const race *r, const lane *l)
{
    for (size_t k = 0; k < r->block_count; k++)
        l->peer->query(l->self, k * NARROW_BLOCK, NARROW_BLOCK, l->answers + k * NARROW_BLOCK);
}

static void run_lane(const race *r, lane *l)
{
    for (size_t k = 0; k < r->block_count; k++) {
        size_t first = r->order[k] * NARROW_BLOCK;
        int64_t start = bench_now_ns();
        l->peer->query(l->self, first, NARROW_BLOCK, l->answers + first);
        int64_t took = bench_now_ns() - start;
        bench_samples_add(&l->times, took);
        l->by_block[r->order[k] * ROUNDS_MOST + l->rounds] = took;
        l->spent_ns += took;
    }
    l->rounds++;
}

/* Each lane has the same share of the time; who is slow has fewer rounds, but at least one. */
static void run_rounds(race *r, double seconds)
{
    int64_t share_ns = (int64_t)(1e9 * seconds / (double)r->lane_count);
    for (size_t i = 0; i < r->lane_count; i++) warm_up(r, &r->lanes[i]);
    bool any = true;
    for (size_t round = 0; any && round < ROUNDS_MOST; round++) {
        if (!r->scene.row.coherent) shuffle(r, r->order, r->block_count);
        any = false;
        mix_lanes(r);
        for (size_t i = 0; i < r->lane_count; i++) {
            lane *l = &r->lanes[r->turns[i]];
            if (l->spent_ns >= share_ns) continue;
            run_lane(r, l);
            any = true;
        }
    }
}

/* ---- judgement ---- */

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double rank(const double *sorted, size_t count, double share)
{
    if (!count) return NAN;
    size_t at = (size_t)ceil(share * (double)count);
    return sorted[at ? at - 1 : 0];
}

static int sooner(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static double mean_of_medians(const race *r, lane *l)
{
    double sum = 0;
    for (size_t k = 0; k < r->block_count; k++) {
        int64_t *of_block = l->by_block + k * ROUNDS_MOST;
        qsort(of_block, l->rounds, sizeof *of_block, sooner);
        size_t middle = l->rounds / 2;
        sum += (double)of_block[middle];
    }
    return sum / (double)(r->block_count * NARROW_BLOCK);
}

static bool misses(const narrow_answer *a, const narrow_truth *t)
{
    return a->bounded && ((quad)a->lo > t->hi || (quad)a->hi < t->lo);
}

static void judge(const race *r, lane *l)
{
    narrow_figures *f = &l->figures;
    double *errors = allocate(r->scene.count, sizeof *errors);
    for (size_t i = 0; i < r->scene.count; i++) {
        const narrow_answer *a = &l->answers[i];
        const narrow_truth *t = &r->truths[i];
        bool garbage = !a->failed && a->measured && !isfinite(a->distance);
        f->failed += a->failed || garbage;
        if (a->failed || garbage) continue;
        f->missed += !a->overlap && t->distance <= 0;
        f->false_hits += a->overlap && t->distance > 0;
        f->missed_truth += misses(a, t);
        if (a->measured) errors[f->measured++] = (double)(q_abs((quad)a->distance - t->distance) / (quad)t->size);
    }
    f->wrong = f->missed + f->false_hits;
    qsort(errors, f->measured, sizeof *errors, ascending);
    f->error_median = rank(errors, f->measured, 0.5);
    f->error_p99 = rank(errors, f->measured, 0.99);
    f->error_max = rank(errors, f->measured, 1);
    f->right =
        !f->wrong && !f->failed && f->measured == r->scene.count && f->error_max <= (r->pair->curved ? 1e-6 : 1e-9);
    f->items = r->scene.count;
    f->samples = l->times.count;
    f->ns_median = 1e3 * bench_percentile_us(&l->times, 0.5) / NARROW_BLOCK;
    f->ns_p99 = 1e3 * bench_percentile_us(&l->times, 0.99) / NARROW_BLOCK;
    f->ns_mean = mean_of_medians(r, l);
    free(errors);
}

static double best_peer(const race *r)
{
    double best = INFINITY;
    for (size_t i = 0; i < r->lane_count; i++) {
        const narrow_figures *f = &r->lanes[i].figures;
        if (!r->lanes[i].peer->ours && f->right) best = fmin(best, f->ns_median);
    }
    return best;
}

/* Cold and coherent rows of a regime are one method's: a peer that is right in one of them by luck is not. */
static void agree(race *r, race *other)
{
    for (size_t i = 0; i < r->lane_count; i++)
        for (size_t k = 0; k < other->lane_count; k++) {
            narrow_figures *f = &r->lanes[i].figures, *g = &other->lanes[k].figures;
            bool same = r->lanes[i].peer == other->lanes[k].peer && r->lanes[i].entry == other->lanes[k].entry;
            if (same) f->right = g->right = f->right && g->right;
        }
}

static void report_all(race *r, narrow_report *report, void *context)
{
    const narrow_row *row = &r->scene.row;
    double best = best_peer(r), goal = narrow_goal_ratio(r->pair->name, row->regime, row->coherent);
    for (size_t i = 0; i < r->lane_count; i++) {
        lane *l = &r->lanes[i];
        narrow_figures *f = &l->figures;
        f->pair = r->pair;
        f->regime = row->regime;
        f->coherent = row->coherent;
        f->ours = l->peer->ours;
        f->contender = l->peer->name;
        f->entry = l->entry;
        f->settings = l->peer->settings;
        f->called = l->peer->entry;
        bool finds = l->peer != &narrow_verify && l->peer != &narrow_verify_prepared;
        f->ratio = isfinite(best) && finds ? f->ns_median / best : NAN;
        f->goal_ratio = finds ? goal : NAN;
        report(context, f);
    }
}

static void close_race(race *r)
{
    for (size_t i = 0; i < r->lane_count; i++) {
        r->lanes[i].peer->destroy(r->lanes[i].self);
        free(r->lanes[i].answers);
        free(r->lanes[i].by_block);
        bench_samples_free(&r->lanes[i].times);
    }
    free(r->truths);
    free(r->order);
    narrow_scene_destroy(&r->scene);
}

static narrow_truth truth_of(const narrow_item *item)
{
    if (item->b->kind == KIND_COMPOUND) return narrow_truth_of_compounds(item);
    return item->b->kind == KIND_MESH ? narrow_truth_of_meshes(item) : narrow_truth_of(item);
}

static void run(race *r, const narrow_pair *pair, narrow_regime regime, bool coherent, const narrow_limits *limits)
{
    *r = (race){.pair = pair, .chance = 1};
    int64_t start = bench_now_ns();
    r->scene = narrow_scene_create(pair, regime, coherent, limits->items);
    r->block_count = r->scene.count / NARROW_BLOCK;
    r->order = allocate(r->block_count, sizeof *r->order);
    for (size_t i = 0; i < r->block_count; i++) r->order[i] = i;
    r->scene.count = r->block_count * NARROW_BLOCK; /* whole blocks */
    r->truths = allocate(r->scene.count, sizeof *r->truths);
    for (size_t i = 0; i < r->scene.count; i++) r->truths[i] = truth_of(&r->scene.items[i]);
    fprintf(stderr, "%s, %s, %s: %zu truths in %.2f s\n", pair->name, narrow_regime_names[regime],
        coherent ? "coherent" : "cold", r->scene.count, 1e-9 * (double)(bench_now_ns() - start));
    if (limits->entries)
        enter_sweep(r, limits);
    else
        enter_all(r, limits->only);
    run_rounds(r, limits->seconds);
    for (size_t i = 0; i < r->lane_count; i++) judge(r, &r->lanes[i]);
}

void narrow_race_run(
    const narrow_pair *pair, narrow_regime regime, const narrow_limits *limits, narrow_report *report, void *context)
{
    race cold, coherent;
    run(&cold, pair, regime, false, limits);
    run(&coherent, pair, regime, true, limits);
    agree(&cold, &coherent);
    report_all(&cold, report, context);
    report_all(&coherent, report, context);
    close_race(&cold);
    close_race(&coherent);
}
