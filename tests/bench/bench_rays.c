/* bench_rays: the first body along a ray among many, ours as the service asks it beside its peers. All contenders are
 * asked the same rays, interleaved; a figure is the median over the passes of the processor time that a ray takes, so
 * other load shows less. Each answer is held against brute force: "wrong" counts those that are off by more than a
 * millimetre; of ours, those whose interval does not hold the truth. --bodies N: only a world of so
 * many. One thread. */
#include "base/clock.h"
#include "bench.h"
#include "rays_peer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { RAYS = 1000, PASSES_MAX = 1001, PASSES_MIN = 3, CONTENDERS_MAX = 8 };

static const double SECONDS = 3, SECONDS_FULL = 20; /* a row */
static const double LENGTHS[] = {10, 1000};         /* m */
static const double ROUNDING = 1e-12;               /* m: of the truth itself */

typedef struct score {
    bool there;
    double ns_median, width_max; /* m, of intervals that are told */
    size_t wrong;
    bench_samples passes;
} score;

static bool is_right(const rays_peer *p, rays_answer a, double truth, double length)
{
    double slack = p->error + ROUNDING;
    if (fabs(truth - length) <= slack) return true;
    if (truth > length) return a.lo == INFINITY;
    return a.lo <= truth + slack && truth <= a.hi + slack;
}

static void judge(const rays_scene *s, const double *truth, double length, void **selves, score *scores)
{
    for (size_t k = 0; k < rays_contender_count; k++) {
        const rays_peer *p = rays_contenders[k];
        for (size_t i = 0; selves[k] && i < s->ray_count; i++) {
            rays_answer a = p->ask(selves[k], &s->rays[i], length);
            scores[k].wrong += !is_right(p, a, truth[i], length);
            if (a.lo < INFINITY && a.hi < INFINITY) scores[k].width_max = fmax(scores[k].width_max, a.hi - a.lo);
        }
    }
}

static void run_passes(const rays_scene *s, double length, void **selves, double seconds, score *scores)
{
    int64_t end = bench_now_ns() + (int64_t)(1e9 * seconds);
    for (int pass = 0; pass < PASSES_MAX && (pass < PASSES_MIN || bench_now_ns() < end); pass++)
        for (size_t k = 0; k < rays_contender_count; k++) {
            if (!selves[k]) continue;
            int64_t start = clock_thread_ns();
            for (size_t i = 0; i < s->ray_count; i++) (void)rays_contenders[k]->ask(selves[k], &s->rays[i], length);
            bench_samples_add(&scores[k].passes, clock_thread_ns() - start);
        }
    for (size_t k = 0; k < rays_contender_count; k++)
        if (selves[k]) scores[k].ns_median = 1e3 * bench_percentile_us(&scores[k].passes, 0.5) / (double)s->ray_count;
}

static double best_peer(const score *scores)
{
    double best = NAN;
    for (size_t k = 1; k < rays_contender_count; k++)
        if (scores[k].there && !(scores[k].ns_median >= best)) best = scores[k].ns_median;
    return best;
}

static void tell(const rays_scene *s, const double *truth, double length, const score *scores, bool json)
{
    size_t hits = 0;
    for (size_t i = 0; i < s->ray_count; i++) hits += truth[i] <= length;
    double best = best_peer(scores);
    for (size_t k = 0; k < rays_contender_count; k++) {
        const score *c = &scores[k];
        char ratio[32] = "null";
        if (!c->there) continue;
        if (best > 0) snprintf(ratio, sizeof ratio, "%.2f", c->ns_median / best);
        if (json)
            printf("{\"bench\":\"rays\",\"bodies\":%zu,\"length\":%.0f,\"ns_median\":%.0f,\"contender\":\"%s\","
                   "\"ratio_to_best_peer\":%s,\"rays\":%zu,\"hits\":%zu,\"wrong\":%zu,\"width_max\":%.3g,"
                   "\"entry\":\"%s\"}\n",
                s->body_count, length, c->ns_median, rays_contenders[k]->name, ratio, s->ray_count, hits, c->wrong,
                c->width_max, rays_contenders[k]->entry);
        else
            printf("%8zu %8.0f %-12s %9.0f %7s %6zu %6zu %6zu %10.2g\n", s->body_count, length,
                rays_contenders[k]->name, c->ns_median, best > 0 ? ratio : "", s->ray_count, hits, c->wrong,
                c->width_max);
    }
}

static void race(size_t bodies, const bench_options *o)
{
    rays_scene s = rays_scene_make(bodies, RAYS, 18);
    void *selves[CONTENDERS_MAX];
    double *truth = calloc(RAYS, sizeof *truth);
    if (!truth || rays_contender_count > CONTENDERS_MAX) abort();
    for (size_t i = 0; i < s.ray_count; i++) truth[i] = rays_truth(&s, &s.rays[i]);
    for (size_t k = 0; k < rays_contender_count; k++) selves[k] = rays_contenders[k]->create(&s);
    for (size_t l = 0; l < sizeof LENGTHS / sizeof *LENGTHS; l++) {
        score scores[CONTENDERS_MAX] = {0};
        for (size_t k = 0; k < rays_contender_count; k++) {
            scores[k].there = selves[k] != NULL;
            if (!bench_samples_init(&scores[k].passes, PASSES_MAX)) abort();
        }
        judge(&s, truth, LENGTHS[l], selves, scores);
        run_passes(&s, LENGTHS[l], selves, o->seconds, scores);
        tell(&s, truth, LENGTHS[l], scores, o->json);
        for (size_t k = 0; k < rays_contender_count; k++) bench_samples_free(&scores[k].passes);
    }
    for (size_t k = 0; k < rays_contender_count; k++)
        if (selves[k]) rays_contenders[k]->destroy(selves[k]);
    free(truth);
    rays_scene_free(&s);
}

int main(int argc, char **argv)
{
    static const size_t BODIES[] = {1000, 10000, 100000};
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    if (!o.json)
        printf("%8s %8s %-12s %9s %7s %6s %6s %6s %10s\n", "bodies", "length", "contender", "ns", "ratio", "rays",
            "hits", "wrong", "width");
    if (o.bodies) return race((size_t)o.bodies, &o), 0;
    for (size_t i = 0; i < sizeof BODIES / sizeof *BODIES; i++) race(BODIES[i], &o);
    return 0;
}
