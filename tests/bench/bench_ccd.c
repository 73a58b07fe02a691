/* bench_ccd: times of impact beside FCL (conservative advancement) and Bullet (continuous convex), on pairs that fly,
 * turn, spin and graze. Each contender against the truth: contacts missed, hits that are none, times later than the
 * truth by more than a thousandth of the span, the greatest error of the time. Contenders are interleaved; a pair's
 * time is the median over the passes, less that of an empty reading of the clock; the table gives median and 99th
 * percentile over the pairs. --bodies N: so many pairs a scene (a scene with meshes: a sixteenth). One thread. */
#include "bench.h"
#include "impact_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { PASSES_MAX = 101, PASSES_MIN = 3, PAIRS_A_SECOND = 160, CONTENDERS_MOST = 8 };

static const double SECONDS = 1.5, SECONDS_FULL = 15; /* a scene */
static const double LATE = 1e-3;                      /* of the span */

typedef struct lane {
    const impact_peer *peer;
    void *self;
    bench_samples *times; /* of each item */
    double us_median, us_p99, error_max;
    size_t misses, false_hits, late, failed;
} lane;

static double empty_us(void)
{
    bench_samples s;
    if (!bench_samples_init(&s, 1001)) abort();
    for (int i = 0; i < 1001; i++) {
        int64_t start = bench_now_ns();
        bench_samples_add(&s, bench_now_ns() - start);
    }
    double us = bench_percentile_us(&s, 0.5);
    bench_samples_free(&s);
    return us;
}

/* ---- judgement ---- */

/* A hit is false where the distance is proven to stay above the tolerance; between that and contact it is neither. */
static void judge(lane *l, const impact_scene *s, size_t i, impact_answer a)
{
    const toi_truth *t = &s->truths[i];
    double span = s->items[i].span;
    l->failed += a.failed;
    l->misses += t->verdict == TRUTH_HIT && !a.hit;
    l->false_hits += t->verdict == TRUTH_FREE && a.hit && t->nearest > 4 * IMPACT_TOLERANCE;
    if (t->verdict != TRUTH_HIT || !a.hit) return;
    double late = a.time - t->hi, early = t->lo - a.time;
    l->late += late > LATE * span;
    l->error_max = fmax(l->error_max, fmax(late, early) / span);
}

static void rank(lane *l, size_t count, double empty)
{
    bench_samples all;
    if (!bench_samples_init(&all, count)) abort();
    for (size_t i = 0; i < count; i++) bench_samples_add(&all, llround(1e3 * bench_percentile_us(&l->times[i], 0.5)));
    l->us_median = fmax(bench_percentile_us(&all, 0.5) - empty, 0);
    l->us_p99 = fmax(bench_percentile_us(&all, 0.99) - empty, 0);
    bench_samples_free(&all);
}

/* ---- one scene ---- */

static void run(lane *lanes, size_t lane_count, const impact_scene *s, double seconds)
{
    int64_t end = bench_now_ns() + (int64_t)(1e9 * seconds);
    for (int pass = 0; pass < PASSES_MAX && (pass < PASSES_MIN || bench_now_ns() < end); pass++)
        for (size_t k = 0; k < lane_count; k++)
            for (size_t i = 0; i < s->count; i++) {
                lane *l = &lanes[k];
                int64_t start = bench_now_ns();
                impact_answer a = l->peer->ask(l->self, i);
                bench_samples_add(&l->times[i], bench_now_ns() - start);
                if (pass == 0) judge(l, s, i, a);
            }
}

static size_t enter_all(lane *lanes, const impact_scene *s)
{
    size_t count = 0;
    for (size_t k = 0; k < impact_contender_count && count < CONTENDERS_MOST; k++) {
        const impact_peer *p = impact_contenders[k];
        if (!p->takes(s->a, s->b)) continue;
        lane *l = &lanes[count++];
        *l = (lane){.peer = p, .self = p->create(s->items, s->count), .times = calloc(s->count, sizeof *l->times)};
        if (!l->times) abort();
        for (size_t i = 0; i < s->count; i++)
            if (!bench_samples_init(&l->times[i], PASSES_MAX)) abort();
    }
    return count;
}

static void leave(lane *l, size_t count)
{
    l->peer->destroy(l->self);
    for (size_t i = 0; i < count; i++) bench_samples_free(&l->times[i]);
    free(l->times);
}

static void print(const impact_kind *kind, const impact_scene *s, const lane *l, bool json, bool first)
{
    if (json) {
        printf("{\"bench\":\"ccd\",\"scene\":\"%s\",\"contender\":\"%s\",\"us_median\":%.3f,\"us_p99\":%.3f,"
               "\"misses\":%zu,\"false_hits\":%zu,\"late\":%zu,\"toi_error_max\":%.3g,\"pairs\":%zu,\"hits\":%zu,"
               "\"failed\":%zu,\"entry\":\"%s\"}\n",
            kind->name, l->peer->name, l->us_median, l->us_p99, l->misses, l->false_hits, l->late, l->error_max,
            s->count, s->hits, l->failed, l->peer->entry);
        return;
    }
    char goal[64] = "";
    if (l->peer->ours && kind->goal_us > 0)
        (void)snprintf(goal, sizeof goal, "%.1f us, 0 missed, 0 late", kind->goal_us);
    else if (l->peer->ours)
        (void)snprintf(goal, sizeof goal, "0 missed, 0 late");
    printf("%-22s %5zu %5zu  %-10s %9.2f %9.2f %7zu %11zu %6zu %10.2g  %s\n", first ? kind->name : "", s->count,
        s->hits, l->peer->name, l->us_median, l->us_p99, l->misses, l->false_hits, l->late, l->error_max, goal);
}

static void race(const impact_kind *kind, const bench_options *o, double empty)
{
    lane lanes[CONTENDERS_MOST];
    impact_scene s = impact_scene_create(kind, o->bodies ? (size_t)o->bodies : (size_t)(PAIRS_A_SECOND * o->seconds));
    size_t count = enter_all(lanes, &s);
    run(lanes, count, &s, o->seconds);
    for (size_t k = 0; k < count; k++) {
        rank(&lanes[k], s.count, empty);
        print(kind, &s, &lanes[k], o->json, k == 0);
        leave(&lanes[k], s.count);
    }
    (void)fflush(stdout);
    impact_scene_destroy(&s);
}

int main(int argc, char **argv)
{
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    if (!o.json) {
        for (size_t k = 0; k < impact_contender_count; k++)
            printf("%-10s %s: %s\n", impact_contenders[k]->name, impact_contenders[k]->entry,
                impact_contenders[k]->settings);
        printf("\n%-22s %5s %5s  %-10s %9s %9s %7s %11s %6s %10s  %s\n", "scene", "pairs", "hits", "contender", "us",
            "p99", "misses", "false hits", "late", "error", "goal");
    }
    double empty = empty_us();
    for (size_t k = 0; k < impact_kind_count; k++) race(&impact_kinds[k], &o, empty);
    return 0;
}
