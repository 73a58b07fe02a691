/* bench_elementary: the elementary tests of continuous collision beside a plain floating-point cubic, without and with
 * the usual tolerance. Each set against exact arithmetic: contacts missed, hits that are none, times later than the
 * truth. Contenders are interleaved; a query's time is the median over the passes, less that of an empty reading of the
 * clock; the table gives median and 99th percentile over the queries. --bodies N: at most N a set. One thread. */
#include "bench.h"

#include "elementary/elementary_sets.h"
#include "elementary_cubic.h"
#include "soft/elementary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { QUERIES = 2000, PASSES_MAX = 101, PASSES_MIN = 3 };

static const double SECONDS = 1, SECONDS_FULL = 10; /* a set */

/* ---- contenders ---- */

typedef struct answer {
    bool hit;
    double t;
} answer;

static answer ask_ours(const elementary_query *q)
{
    elementary_result r;
    if (q->kind == ELEMENTARY_VF)
        elementary_vertex_face(q->start, q->end, 0, &r);
    else
        elementary_edge_edge(q->start, q->end, 0, &r);
    return (answer){r.status == ELEMENTARY_HIT, r.t_lo};
}

static answer ask_cubic(const elementary_query *q)
{
    answer a = {0};
    a.hit = elementary_cubic(q, 0, &a.t);
    return a;
}

static answer ask_tolerant(const elementary_query *q)
{
    answer a = {0};
    a.hit = elementary_cubic(q, 1e-6, &a.t);
    return a;
}

static const struct contender {
    const char *name;
    answer (*ask)(const elementary_query *q);
    const char *entry; /* ours: nothing that ships calls it yet (tests/bench/check_shipped.py) */
} CONTENDERS[] = {{"collided", ask_ours, "elementary_vertex_face, elementary_edge_edge"},
    {"cubic", ask_cubic, "elementary_cubic"}, {"cubic, tolerance 1e-6", ask_tolerant, "elementary_cubic"}};

enum { CONTENDER_COUNT = sizeof CONTENDERS / sizeof *CONTENDERS };

/* ---- one set ---- */

typedef struct score {
    double ns_median, ns_p99, late_max;
    size_t misses, false_hits, late;
} score;

static double median_of(bench_samples *s)
{
    return 1e3 * bench_percentile_us(s, 0.5);
}

static double empty_ns(void)
{
    bench_samples s;
    if (!bench_samples_init(&s, 1001)) abort();
    for (int i = 0; i < 1001; i++) {
        int64_t start = bench_now_ns();
        bench_samples_add(&s, bench_now_ns() - start);
    }
    double ns = median_of(&s);
    bench_samples_free(&s);
    return ns;
}

static void judge(score *s, answer a, const elementary_truth *truth)
{
    s->misses += truth->touches && !a.hit;
    s->false_hits += a.hit && !truth->touches;
    if (!(a.hit && truth->touches && a.t > truth->hi)) return;
    s->late++;
    s->late_max = fmax(s->late_max, a.t - truth->hi);
}

static void measure(const elementary_case *cases, size_t count, double seconds, score out[CONTENDER_COUNT])
{
    bench_samples *times = calloc(count * CONTENDER_COUNT, sizeof *times), all;
    if (!times) abort();
    for (size_t i = 0; i < count * CONTENDER_COUNT; i++)
        if (!bench_samples_init(&times[i], PASSES_MAX)) abort();
    double empty = empty_ns();
    int64_t end = bench_now_ns() + (int64_t)(1e9 * seconds);
    for (int pass = 0; pass < PASSES_MAX && (pass < PASSES_MIN || bench_now_ns() < end); pass++)
        for (size_t k = 0; k < CONTENDER_COUNT; k++)
            for (size_t i = 0; i < count; i++) {
                int64_t start = bench_now_ns();
                answer a = CONTENDERS[k].ask(&cases[i].query);
                bench_samples_add(&times[k * count + i], bench_now_ns() - start);
                if (pass == 0) judge(&out[k], a, &cases[i].truth);
            }
    for (size_t k = 0; k < CONTENDER_COUNT; k++) {
        if (!bench_samples_init(&all, count)) abort();
        for (size_t i = 0; i < count; i++) bench_samples_add(&all, llround(median_of(&times[k * count + i])));
        out[k].ns_median = fmax(median_of(&all) - empty, 0);
        out[k].ns_p99 = fmax(1e3 * bench_percentile_us(&all, 0.99) - empty, 0);
        bench_samples_free(&all);
    }
    for (size_t i = 0; i < count * CONTENDER_COUNT; i++) bench_samples_free(&times[i]);
    free(times);
}

static void tell(const char *scene, const elementary_case *cases, size_t count, const bench_options *o)
{
    score scores[CONTENDER_COUNT] = {0};
    size_t contacts = 0;
    for (size_t i = 0; i < count; i++) contacts += cases[i].truth.touches;
    measure(cases, count, o->seconds, scores);
    for (size_t k = 0; k < CONTENDER_COUNT; k++) {
        const score *s = &scores[k];
        const char *name = CONTENDERS[k].name;
        if (o->json)
            printf("{\"bench\":\"elementary\",\"scene\":\"%s\",\"contender\":\"%s\",\"entry\":\"%s\",\"queries\":%zu,"
                   "\"contacts\":%zu,"
                   "\"ns_median\":%.0f,\"ns_p99\":%.0f,\"misses\":%zu,\"false_hits\":%zu,\"late\":%zu,"
                   "\"late_max\":%.3g}\n",
                scene, name, CONTENDERS[k].entry, count, contacts, s->ns_median, s->ns_p99, s->misses, s->false_hits,
                s->late, s->late_max);
        else
            printf("%-24s %-22s %8zu %8zu %8.0f %8.0f %8zu %10zu %6zu %10.2g\n", k ? "" : scene, name, count, contacts,
                s->ns_median, s->ns_p99, s->misses, s->false_hits, s->late, s->late_max);
    }
}

/* ---- sets ---- */

static void made(elementary_class c, elementary_kind kind, const bench_options *o)
{
    static elementary_case cases[QUERIES];
    char scene[64];
    (void)snprintf(scene, sizeof scene, "%s, %s", elementary_class_name(c), kind ? "edge-edge" : "vertex-face");
    size_t count = o->bodies && o->bodies < QUERIES ? (size_t)o->bodies : QUERIES;
    for (uint64_t i = 0; i < count; i++) {
        cases[i].query = elementary_make(c, 2 * (9000000 + i) + (kind == ELEMENTARY_EE));
        cases[i].truth = elementary_oracle(&cases[i].query);
    }
    tell(scene, cases, count, o);
}

static void shared(const char *name, const bench_options *o)
{
    size_t count;
    elementary_case *cases = elementary_read(name, &count);
    if (cases && count)
        tell(name, cases, count, o);
    else
        fprintf(stderr, "cases/ccd/%s is not there (COLLIDED_SHARED)\n", name);
    free(cases);
}

int main(int argc, char **argv)
{
    static const elementary_class CLASSES[] = {
        ELEMENTARY_RANDOM, ELEMENTARY_NEAR_MISS, ELEMENTARY_CLOTH, ELEMENTARY_BUILT, ELEMENTARY_COPLANAR};
    bench_options o;
    if (!bench_parse(argc, argv, SECONDS, SECONDS_FULL, &o)) return 64;
    if (!o.json)
        printf("%-24s %-22s %8s %8s %8s %8s %8s %10s %6s %10s\n", "set", "contender", "queries", "contacts", "ns",
            "p99", "misses", "false hits", "late", "at most");
    for (size_t i = 0; i < sizeof CLASSES / sizeof *CLASSES; i++) {
        made(CLASSES[i], ELEMENTARY_VF, &o);
        made(CLASSES[i], ELEMENTARY_EE, &o);
    }
    shared("sample_vf.csv", &o);
    shared("sample_ee.csv", &o);
    shared("fuzz.csv", &o);
    return 0;
}
