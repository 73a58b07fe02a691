/* bench_verdicts: what the same pairs cost when less is asked of them: a verdict alone, an interval of 1e-3 and of 1e-6
 * of their sizes, and one as narrow as arithmetic gives; separated, in shallow and in deep contact, cold, and followed
 * with what a pair remembers (narrow_scene.h). A looser request is never to be dearer: `to_fine` is the median of the
 * ratios to 1e-6, interleaved. What is timed is what a tick calls. One thread. */
#include "bench.h"
#include "narrow_scene.h"

#include "base/array.h"
#include "geom/bounds.h"
#include "narrow/narrow.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double SECONDS = 30, SECONDS_FULL = 240; /* in all */
enum { ITEMS = 128, ROWS = 78 /* about */, ROUNDS_LEAST = 5, ROUNDS_MOST = 400 };

typedef enum asked { VERDICT, COARSE, FINE, EXACT, ASKED_COUNT } asked;
static const char *const NAMES[ASKED_COUNT] = {"verdict", "1e-3", "1e-6", "exact"};
static const double RELATIVE[ASKED_COUNT] = {1e-6, 1e-3, 1e-6, 0};

typedef struct question { /* in canonical order, as a tick has it */
    shape a, b;
    pose at_a, at_b;
    double size; /* m */
    bool begins;
} question;

typedef struct asker {
    narrow_cache cache;
    narrow_shell shell;
    double ns[ROUNDS_MOST]; /* a query */
    size_t overlaps;        /* of the last round */
} asker;

static question question_of(const narrow_item *item)
{
    shape a = narrow_scene_shape(item->a), b = narrow_scene_shape(item->b);
    bool ordered = narrow_ordered(&a, 0, &b, 1);
    pose at_a = narrow_scene_pose(&item->at_a), at_b = narrow_scene_pose(&item->at_b);
    return (question){.a = ordered ? a : b,
        .b = ordered ? b : a,
        .at_a = ordered ? at_a : at_b,
        .at_b = ordered ? at_b : at_a,
        .size = shape_reach(&a) + shape_reach(&b),
        .begins = item->begins};
}

static void ask_all(asker *who, asked what, const question *q, size_t count, bool coherent, void *scratch, size_t round)
{
    narrow_request request = {.facts = what == VERDICT ? NARROW_VERDICT : NARROW_VERDICT | NARROW_DISTANCE,
        .range = what == VERDICT ? 0 : INFINITY,
        .brief = what == VERDICT};
    int64_t start = bench_now_ns();
    who->overlaps = 0;
    for (size_t i = 0; i < count; i++) {
        narrow_result r;
        pose b_in_a = pose_relative(q[i].at_a, q[i].at_b);
        if (!coherent || q[i].begins) who->cache = (narrow_cache){.shell = coherent ? &who->shell : NULL};
        if (who->cache.shell && q[i].begins) memset(&who->shell, 0, sizeof who->shell);
        request.tolerance = RELATIVE[what] * q[i].size;
        narrow_query(&q[i].a, &q[i].b, &b_in_a, &request, &who->cache, scratch, &r);
        who->overlaps += r.lo <= 0;
    }
    who->ns[round] = (double)(bench_now_ns() - start) / (double)count;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(const double *of, size_t count)
{
    double sorted[ROUNDS_MOST];
    memcpy(sorted, of, count * sizeof *of);
    qsort(sorted, count, sizeof *sorted, by_size);
    return sorted[count / 2];
}

static void tell(const narrow_pair *pair, narrow_regime regime, bool coherent, asker *all, size_t rounds, bool json)
{
    for (int k = 0; k < ASKED_COUNT; k++) {
        double ratios[ROUNDS_MOST];
        for (size_t i = 0; i < rounds; i++) ratios[i] = all[k].ns[i] / all[FINE].ns[i];
        double ns = median(all[k].ns, rounds), to_fine = median(ratios, rounds);
        if (json)
            printf("{\"bench\":\"verdicts\",\"entry\":\"narrow_query\",\"pair\":\"%s\",\"regime\":\"%s\","
                   "\"coherent\":%s,\"asked\":\"%s\",\"ns_median\":%.1f,\"to_fine\":%.3f,\"overlaps\":%zu,"
                   "\"items\":%d}\n",
                pair->name, narrow_regime_names[regime], coherent ? "true" : "false", NAMES[k], ns, to_fine,
                all[k].overlaps, ITEMS);
        else
            printf("%s%s %9.0f (%.2f)", k ? "" : "\n", NAMES[k], ns, to_fine);
    }
    if (!json) printf("   %s, %s, %s", pair->name, narrow_regime_names[regime], coherent ? "followed" : "cold");
    fflush(stdout);
}

static void measure(const narrow_pair *pair, narrow_regime regime, bool coherent, double seconds, bool json)
{
    static asker all[ASKED_COUNT];
    static question questions[ITEMS];
    narrow_scene s = narrow_scene_create(pair, regime, coherent, ITEMS);
    void *scratch = base_alloc_lines(1, narrow_scratch_size());
    for (size_t i = 0; i < s.count; i++) questions[i] = question_of(&s.items[i]);
    int64_t end = bench_now_ns() + (int64_t)(1e9 * seconds);
    size_t rounds = 0;
    for (; rounds < ROUNDS_MOST && (rounds < ROUNDS_LEAST || bench_now_ns() < end); rounds++)
        for (int k = 0; k < ASKED_COUNT; k++) {
            asked what = (asked)(((size_t)k + rounds) % ASKED_COUNT);
            ask_all(&all[what], what, questions, s.count, coherent, scratch, rounds);
        }
    tell(pair, regime, coherent, all, rounds, json);
    free(scratch);
    narrow_scene_destroy(&s);
}

int main(int argc, char **argv)
{
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64; /* EX_USAGE */
    if (!o.json) printf("ns a query (in brackets: to that of 1e-6)\n");
    for (size_t i = 0; i < narrow_pair_count; i++) {
        if (narrow_pairs[i].b == KIND_MESH || narrow_pairs[i].b == KIND_COMPOUND) continue;
        for (int regime = 0; regime < REGIME_COUNT; regime++)
            for (int coherent = 0; coherent < 2; coherent++)
                measure(&narrow_pairs[i], (narrow_regime)regime, coherent, o.seconds / ROWS, o.json);
    }
    if (!o.json) printf("\n");
    return 0;
}
