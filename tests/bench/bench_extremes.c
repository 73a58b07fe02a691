/* bench_extremes: who is right where it gets hard, and how far. Along each axis (scale, distance from the origin, size
 * ratio, aspect ratio, gap, depth, near-parallel faces) each contender is asked about the same configurations and
 * judged by the truth in 113 bits (narrow_truth.h): error, verdict errors, failures; a crash or 0.2 s without an
 * answer is a failure (extremes_guard.h). No times: bench_pareto has them. Then the ends of the stated range: what lies
 * beyond is refused, by a text that names the limit (extremes_limits.h).
 *
 * A verdict is judged where the truth has a sign beyond 1e-25 of the size. An answer that is an interval with 0 in it
 * is no verdict: undecided. Errors are relative to the pair's size. One thread. */
#include "bench.h"
#include "extremes_guard.h"
#include "extremes_limits.h"
#include "narrow_truth.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ITEMS = 4, ITEMS_FULL = 32, ITEMS_MOST = 10000, VALUES_MOST = 8, LIMITS_MOST = 64, ENTRIES_MOST = 32 };

/* ---- the axes ---- */

typedef enum axis_kind { SCALE, DISTANCE, RATIO, ASPECT, GAP, DEPTH, TILT } axis_kind;

typedef struct axis {
    const char *name;
    axis_kind kind;
    bool proven; /* the sweep of depths is too coarse there: bounds from both sides */
    size_t count;
    double values[VALUES_MOST];
} axis;

static const axis AXES[] = {
    {"scale", SCALE, false, 7, {0x1p-30, 0x1p-20, 0x1p-10, 1, 0x1p10, 0x1p20, 0x1p30}},
    {"distance", DISTANCE, false, 7, {1, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12}},
    {"size ratio", RATIO, true, 6, {1, 1e1, 1e3, 1e5, 1e7, 1e9}},
    {"aspect ratio", ASPECT, true, 6, {1, 1e1, 1e2, 1e3, 1e4, 1e6}},
    {"gap", GAP, true, 8, {1e-16, 1e-15, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3, 1}},
    {"depth", DEPTH, true, 8, {1e-16, 1e-15, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3, 1e-1}},
    {"tilt", TILT, true, 7, {0, 1e-16, 1e-14, 1e-12, 1e-8, 1e-4, 1e-1}},
};
enum { AXIS_COUNT = sizeof AXES / sizeof *AXES };

/* At 2^30 the largest half extent must stay within the stated 1e9 m: sizes are drawn up to 1. */
static const double SCALE_KEPT = 0.9;

static narrow_extreme extreme_at(const axis *x, double value)
{
    narrow_extreme e = {SCALE_KEPT, 0, 1, 1, NAN, NAN};
    if (x->kind == SCALE) e.scale *= value;
    if (x->kind == DISTANCE) e.distance = value;
    if (x->kind == RATIO) e.ratio = value;
    if (x->kind == ASPECT) e.aspect = value;
    if (x->kind == GAP || x->kind == DEPTH) e.amount = value;
    if (x->kind == TILT) e.tilt = value;
    return e;
}

/* Which regimes an axis has. */
static bool has(const axis *x, narrow_regime regime)
{
    if (x->kind == GAP) return regime == REGIME_SEPARATED;
    if (x->kind == DEPTH) return regime == REGIME_SHALLOW;
    return true;
}

/* Balls have no faces and no aspect, hulls of random points no parallel faces. */
static bool fits(const axis *x, const narrow_pair *pair)
{
    static const char *const PAIRS[] = {"sphere-sphere", "capsule-capsule", "box-box", "cylinder-cylinder", "cone-box",
        "ellipsoid-ellipsoid", "hull16-hull16", "hull64-box", "cylinder-box", "capsule-box"};
    bool raced = false;
    for (size_t i = 0; i < sizeof PAIRS / sizeof *PAIRS; i++) raced |= strcmp(PAIRS[i], pair->name) == 0;
    bool faces = pair->a != KIND_SPHERE && pair->a != KIND_ELLIPSOID && pair->b != KIND_HULL;
    if (x->kind == TILT) return raced && faces;
    return raced && (x->kind != ASPECT || pair->a != KIND_SPHERE);
}

/* ---- a row: one axis, value and pair ---- */

typedef struct options {
    bool json, full;
    const char *axis, *pair;
    unsigned long items; /* a regime */
    FILE *lines;         /* JSON lines go there, too */
} options;

typedef struct figures {
    double error_max;     /* NAN = nothing was measured */
    double undecided_max; /* the truth farthest from 0 of those undecided, relative to the size */
    size_t wrong, failed, items;
    size_t undecided;    /* of intervals: they hold 0 */
    size_t missed_truth; /* of intervals */
} figures;

static bool is_apart(const narrow_truth *t)
{
    return t->lo > (quad)1e-25 * (quad)t->size;
}

static bool is_overlap(const narrow_truth *t)
{
    return t->hi < (quad)1e-25 * (quad)t->size;
}

static void judge(const narrow_answer *a, const narrow_truth *t, figures *f)
{
    f->items++;
    bool garbage = !a->failed && a->measured && !isfinite(a->distance);
    f->failed += a->failed || garbage;
    if (a->failed || garbage) return;
    bool undecided = a->bounded && a->lo <= 0 && a->hi >= 0;
    f->undecided += undecided;
    if (undecided) f->undecided_max = fmax(f->undecided_max, (double)(q_abs(t->distance) / (quad)t->size));
    if (!undecided) f->wrong += a->overlap ? is_apart(t) : is_overlap(t);
    f->missed_truth += a->bounded && ((quad)a->lo > t->hi || (quad)a->hi < t->lo);
    if (!a->measured) return;
    f->error_max = fmax(f->error_max, (double)(q_abs((quad)a->distance - t->distance) / (quad)t->size));
}

static void run_regime(
    const axis *x, double value, const narrow_pair *pair, narrow_regime regime, const options *o, figures *of)
{
    narrow_extreme e = extreme_at(x, value);
    narrow_scene s = narrow_scene_create_extreme(pair, regime, o->items, &e);
    narrow_truth *truths = calloc(s.count, sizeof *truths);
    narrow_answer *answers = calloc(s.count, sizeof *answers);
    if (!truths || !answers) abort();
    for (size_t i = 0; i < s.count; i++)
        truths[i] = x->proven ? narrow_truth_proven(&s.items[i]) : narrow_truth_of(&s.items[i]);
    for (size_t k = 0; k < extremes_entry_count; k++) {
        const narrow_entry *entry = &extremes_entries[k];
        bool asked = regime == REGIME_SEPARATED ? entry->gaps : entry->contacts;
        if (!asked || !entry->peer->takes(&s.row)) continue;
        extremes_ask(entry, s.items, s.count, &s.row, answers);
        for (size_t i = 0; i < s.count; i++) judge(&answers[i], &truths[i], &of[k]);
    }
    free(truths);
    free(answers);
    narrow_scene_destroy(&s);
}

/* ---- output ---- */

static void print_json(
    FILE *out, const axis *x, double value, const narrow_pair *pair, const narrow_entry *e, const figures *f)
{
    bool named = !(e->own > 0);
    fprintf(out,
        "{\"bench\":\"extremes\",\"axis\":\"%s\",\"value\":%.17g,\"pair\":\"%s\",\"contender\":\"%s\",\"entry\":\"%"
        "s\",",
        x->name, value, pair->name, e->peer->name, e->peer->entry);
    fprintf(out, "\"tolerance\":%s%s%s,\"error_max\":", named ? "\"" : "", e->label, named ? "\"" : "");
    if (isnan(f->error_max))
        fprintf(out, "null");
    else
        fprintf(out, "%.3e", f->error_max);
    fprintf(out,
        ",\"wrong\":%zu,\"failed\":%zu,\"undecided\":%zu,\"undecided_max\":%.3e,\"items\":%zu,"
        "\"missed_truth\":%zu}\n",
        f->wrong, f->failed, f->undecided, f->undecided_max, f->items, f->missed_truth);
}

static void print_row(const options *o, const axis *x, double value, const narrow_pair *pair, const figures *of)
{
    if (!o->json) printf("\n%s %g, %s\n", x->name, value, pair->name);
    for (size_t k = 0; k < extremes_entry_count; k++) {
        const narrow_entry *e = &extremes_entries[k];
        const figures *f = &of[k];
        if (!f->items) continue;
        if (o->json) print_json(stdout, x, value, pair, e, f);
        if (o->lines) print_json(o->lines, x, value, pair, e, f);
        if (o->json) continue;
        printf("%-18s %-6s error %9.1e  wrong %2zu  failed %2zu  undecided %2zu  of %2zu%s\n", e->peer->name, e->label,
            f->error_max, f->wrong, f->failed, f->undecided, f->items,
            f->missed_truth ? "  INTERVAL WITHOUT THE TRUTH" : "");
    }
    fflush(stdout);
}

/* What ours may not have inside the range. */
static size_t faults_of_ours(const figures *of)
{
    size_t faults = 0;
    for (size_t k = 0; k < extremes_entry_count; k++)
        if (extremes_entries[k].peer->ours) faults += of[k].wrong + of[k].failed + of[k].missed_truth;
    return faults;
}

static size_t run_axis(const options *o, const axis *x)
{
    size_t faults = 0;
    int64_t start = bench_now_ns();
    for (size_t v = 0; v < x->count; v++)
        for (size_t p = 0; p < narrow_pair_count; p++) {
            const narrow_pair *pair = &narrow_pairs[p];
            if (!fits(x, pair) || (o->pair && strcmp(o->pair, pair->name) != 0)) continue;
            figures of[ENTRIES_MOST];
            for (size_t k = 0; k < extremes_entry_count; k++) of[k] = (figures){.error_max = NAN};
            for (int regime = 0; regime < REGIME_COUNT; regime++)
                if (has(x, (narrow_regime)regime)) run_regime(x, x->values[v], pair, (narrow_regime)regime, o, of);
            print_row(o, x, x->values[v], pair, of);
            faults += faults_of_ours(of);
        }
    fprintf(stderr, "%s: %.1f s\n", x->name, 1e-9 * (double)(bench_now_ns() - start));
    return faults;
}

static void print_limit(FILE *out, const extremes_limit *l)
{
    fprintf(out, "{\"bench\":\"extremes\",\"axis\":\"limit: %s\",\"value\":", l->name);
    if (isfinite(l->value))
        fprintf(out, "%.17g", l->value);
    else
        fprintf(out, "\"%s\"", isnan(l->value) ? "NaN" : "infinity");
    fprintf(out,
        ",\"pair\":\"-\",\"contender\":\"collided\",\"entry\":\"wire_check\",\"error_max\":null,\"wrong\":%d,"
        "\"failed\":0,",
        l->beyond != l->refused || (l->refused && !l->named));
    fprintf(out, "\"refused\":%s,\"text\":\"%s\"}\n", l->refused ? "true" : "false", l->text);
}

static size_t run_limits(const options *o)
{
    extremes_limit limits[LIMITS_MOST];
    size_t count = extremes_limits(limits, LIMITS_MOST), faults = 0;
    if (!o->json) printf("\nthe ends of the stated range\n");
    for (size_t i = 0; i < count; i++) {
        const extremes_limit *l = &limits[i];
        faults += l->beyond != l->refused || (l->refused && !l->named);
        if (o->json) print_limit(stdout, l);
        if (o->lines) print_limit(o->lines, l);
        if (!o->json) printf("%-24s %-24.17g %s\n", l->name, l->value, l->refused ? l->text : "accepted");
    }
    return faults;
}

/* ---- options ---- */

static bool usage(const char *program)
{
    fprintf(stderr,
        "usage: %s [--json] [--full] [--axis AXIS] [--pair PAIR] [--items 1..%d] [--lines FILE]\naxes:", program,
        ITEMS_MOST);
    for (size_t i = 0; i < AXIS_COUNT; i++) fprintf(stderr, " \"%s\"", AXES[i].name);
    fprintf(stderr, "\n--items: configurations a regime; --full: more of them; --lines: JSON lines go there, too\n");
    return false;
}

static bool parse(int argc, char **argv, options *o)
{
    static const struct option known[] = {{"json", no_argument, NULL, 'j'}, {"full", no_argument, NULL, 'f'},
        {"axis", required_argument, NULL, 'a'}, {"pair", required_argument, NULL, 'p'},
        {"items", required_argument, NULL, 'i'}, {"lines", required_argument, NULL, 'l'}, {NULL, 0, NULL, 0}};
    *o = (options){.items = ITEMS};
    for (int c; (c = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        if (c == 'j') o->json = true;
        if (c == 'f') o->items = ITEMS_FULL;
        if (c == 'a') o->axis = optarg;
        if (c == 'p') o->pair = optarg;
        if (c == 'i') o->items = strtoul(optarg, NULL, 10);
        if (c == 'l' && !(o->lines = fopen(optarg, "w"))) return usage(argv[0]);
        if (c == '?') return usage(argv[0]);
    }
    return (optind == argc && o->items >= 1 && o->items <= ITEMS_MOST) || usage(argv[0]);
}

int main(int argc, char **argv)
{
    options o;
    if (!parse(argc, argv, &o)) return 64; /* EX_USAGE */
    size_t faults = 0;
    for (size_t i = 0; i < AXIS_COUNT; i++)
        if (!o.axis || strcmp(o.axis, AXES[i].name) == 0) faults += run_axis(&o, &AXES[i]);
    faults += run_limits(&o);
    if (o.lines && fclose(o.lines) != 0) return EXIT_FAILURE;
    if (faults)
        fprintf(
            stderr, "failed: %zu wrong verdicts, failures, intervals without the truth or refusals of ours\n", faults);
    return faults ? EXIT_FAILURE : EXIT_SUCCESS;
}
