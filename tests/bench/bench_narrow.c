/* bench_narrow: our narrow phase beside FCL, Bullet, ODE and libccd (narrow_race.h), each pair type separated, in
 * shallow and in deep contact, cold and coherent (narrow_scene.h), judged by the truth in 113 bits (narrow_truth.h).
 * One thread. Tables, or one JSON object a line, on stdout; progress on stderr.
 *
 * collided_again is ours with the cache of the frame before, which answers as without, to the bit.
 *
 * collided_verify is a client's check of the certificate that ours gave (not of meshes): the issue allows it 300 ns.
 *
 * ratio = median / median of the best peer that is right in that regime, cold and coherent: no wrong verdict, no
 * failure, all measured, and no error beyond 1e-9 of the pair's size (1e-6 of curved pairs). goal: what the ratio is to
 * be at most. */
#include "bench.h"
#include "narrow_race.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ITEMS = 128, ITEMS_FULL = 512, ITEMS_MESH = 32, ITEMS_MOST = 100000 };
static const double SECONDS = 0.6, SECONDS_FULL = 4;

typedef struct options {
    bool json, full, mesh;
    const char *only, *pair, *regime;
    unsigned long items; /* 0 = the default */
    double seconds;      /* a row; 0 = the default */
} options;

static bool usage(const char *program)
{
    fprintf(stderr,
        "usage: %s [--json] [--full] [--mesh] [--only PEER] [--pair PAIR] [--regime separated|shallow|deep] [--items "
        "48..%d] "
        "[--seconds A_ROW]\npairs:",
        program, ITEMS_MOST);
    for (size_t i = 0; i < narrow_pair_count; i++) fprintf(stderr, " %s", narrow_pairs[i].name);
    fprintf(stderr, "\npeers:");
    for (size_t i = 0; i < narrow_contender_count; i++) fprintf(stderr, " %s", narrow_contenders[i]->name);
    fprintf(stderr, "\n--mesh: the pairs with meshes instead (slower truths); --full: more configurations, longer\n");
    return false;
}

static bool is_name(const char *name)
{
    for (size_t i = 0; i < narrow_contender_count; i++)
        if (strcmp(narrow_contenders[i]->name, name) == 0) return true;
    return false;
}

static bool is_pair(const char *name)
{
    for (size_t i = 0; i < narrow_pair_count; i++)
        if (strcmp(narrow_pairs[i].name, name) == 0) return true;
    return false;
}

static bool is_regime(const char *name)
{
    for (size_t i = 0; i < REGIME_COUNT; i++)
        if (strcmp(narrow_regime_names[i], name) == 0) return true;
    return false;
}

static bool are_right(const options *o)
{
    bool names =
        (!o->only || is_name(o->only)) && (!o->pair || is_pair(o->pair)) && (!o->regime || is_regime(o->regime));
    bool items = !o->items || (o->items >= 48 && o->items <= ITEMS_MOST);
    return names && items && o->seconds >= 0 && o->seconds <= 3600;
}

static bool parse(int argc, char **argv, options *o)
{
    static const struct option known[] = {{"json", no_argument, NULL, 'j'}, {"full", no_argument, NULL, 'f'},
        {"mesh", no_argument, NULL, 'm'}, {"only", required_argument, NULL, 'o'},
        {"pair", required_argument, NULL, 'p'}, {"regime", required_argument, NULL, 'r'},
        {"items", required_argument, NULL, 'i'}, {"seconds", required_argument, NULL, 's'}, {NULL, 0, NULL, 0}};
    *o = (options){0};
    for (int c; (c = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        if (c == 'j') o->json = true;
        if (c == 'f') o->full = true;
        if (c == 'm') o->mesh = true;
        if (c == 'o') o->only = optarg;
        if (c == 'p') o->pair = optarg;
        if (c == 'r') o->regime = optarg;
        if (c == 'i') o->items = strtoul(optarg, NULL, 10);
        if (c == 's') o->seconds = strtod(optarg, NULL);
        if (c == '?') return usage(argv[0]);
    }
    return (optind == argc && are_right(o)) || usage(argv[0]);
}

/* ---- output ---- */

enum { BEHIND_MOST = 200 };

typedef struct printer {
    bool json;
    size_t truths_missed;               /* intervals of ours without the truth */
    narrow_figures behind[BEHIND_MOST]; /* rows of ours that miss their goal */
    size_t behind_count;
    const narrow_pair *pair; /* of the last line: a new row gets a head */
    narrow_regime regime;
    bool coherent;
} printer;

/* JSON has no NaN. */
static const char *number(char out[32], double value, const char *format, const char *none)
{
    if (isfinite(value))
        snprintf(out, 32, format, value); /* NOLINT(clang-diagnostic-format-nonliteral): ours */
    else
        snprintf(out, 32, "%s", none);
    return out;
}

static void print_json(const narrow_figures *f)
{
    char text[5][32];
    printf("{\"bench\":\"narrow\",\"pair\":\"%s\",\"regime\":\"%s\",\"coherent\":%s,\"contender\":\"%s\",",
        f->pair->name, narrow_regime_names[f->regime], f->coherent ? "true" : "false", f->contender);
    printf("\"ns_median\":%.2f,\"ns_p99\":%.2f,\"error_median\":%s,\"error_p99\":%s,\"error_max\":%s,", f->ns_median,
        f->ns_p99, number(text[0], f->error_median, "%.3e", "null"), number(text[1], f->error_p99, "%.3e", "null"),
        number(text[2], f->error_max, "%.3e", "null"));
    printf("\"wrong\":%zu,\"failed\":%zu,\"measured\":%zu,\"missed_truth\":%zu,\"right\":%s,", f->wrong, f->failed,
        f->measured, f->missed_truth, f->right ? "true" : "false");
    printf("\"ratio_to_best_right_peer\":%s,\"goal_ratio\":%s,\"items\":%zu,\"samples\":%zu,\"block\":%d,"
           "\"entry\":\"%s\",\"settings\":\"%s\"}\n",
        number(text[3], f->ratio, "%.4f", "null"), number(text[4], f->goal_ratio, "%.4f", "null"), f->items, f->samples,
        NARROW_BLOCK, f->called, f->settings);
}

static void print_head(const narrow_figures *f)
{
    char goal[32];
    printf("\n%s, %s, %s: %zu configurations; goal: ratio <= %s\n", f->pair->name, narrow_regime_names[f->regime],
        f->coherent ? "coherent" : "cold", f->items, number(goal, f->goal_ratio, "%.3f", "-"));
    printf("%-18s %9s %9s %7s | %9s %9s %9s %8s %6s %6s\n", "", "ns", "p99", "ratio", "error 50%", "99%", "max",
        "measured", "wrong", "failed");
}

static void print_table(printer *p, const narrow_figures *f)
{
    char text[4][32];
    if (f->pair != p->pair || f->regime != p->regime || f->coherent != p->coherent) print_head(f);
    p->pair = f->pair;
    p->regime = f->regime;
    p->coherent = f->coherent;
    printf("%-18s %9.1f %9.1f %7s | %9s %9s %9s %8zu %6zu %6zu%s%s\n", f->contender, f->ns_median, f->ns_p99,
        number(text[0], f->ratio, "%.3f", "-"), number(text[1], f->error_median, "%.1e", "-"),
        number(text[2], f->error_p99, "%.1e", "-"), number(text[3], f->error_max, "%.1e", "-"), f->measured, f->wrong,
        f->failed, f->right ? "  right" : "", f->missed_truth ? "  INTERVAL WITHOUT THE TRUTH" : "");
}

static void print_figures(void *context, const narrow_figures *f)
{
    printer *p = context;
    if (f->ours) p->truths_missed += f->missed_truth;
    if (f->ours && f->ratio > f->goal_ratio && p->behind_count < BEHIND_MOST) p->behind[p->behind_count++] = *f;
    if (p->json)
        print_json(f);
    else
        print_table(p, f);
    fflush(stdout);
}

static void print_settings(void)
{
    for (size_t i = 0; i < narrow_contender_count; i++)
        printf(
            "%-18s %s: %s\n", narrow_contenders[i]->name, narrow_contenders[i]->entry, narrow_contenders[i]->settings);
    printf("one sample = %d queries; ratio: to the best peer that is right\n", NARROW_BLOCK);
}

static void print_behind(const printer *p)
{
    printf("\nours behind the goal: %zu\n", p->behind_count);
    if (p->behind_count) printf("%-20s %-10s %-9s %-16s %8s %8s %8s\n", "", "", "", "", "ratio", "goal", "factor");
    for (size_t i = 0; i < p->behind_count; i++) {
        const narrow_figures *f = &p->behind[i];
        printf("%-20s %-10s %-9s %-16s %8.3f %8.3f %8.2f\n", f->pair->name, narrow_regime_names[f->regime],
            f->coherent ? "coherent" : "cold", f->contender, f->ratio, f->goal_ratio, f->ratio / f->goal_ratio);
    }
}

static bool is_wanted(const options *o, const narrow_pair *pair, narrow_regime regime)
{
    bool mesh = pair->b == KIND_MESH;
    if (o->pair ? strcmp(o->pair, pair->name) != 0 : mesh != o->mesh) return false;
    if ((mesh || pair->b == KIND_COMPOUND) && regime != REGIME_SEPARATED) return false;
    return !o->regime || strcmp(o->regime, narrow_regime_names[regime]) == 0;
}

static narrow_limits limits_for(const options *o, const narrow_pair *pair)
{
    narrow_limits limits = {.items = o->full                ? ITEMS_FULL
                                     : pair->b == KIND_MESH ? ITEMS_MESH
                                                            : ITEMS,
        .seconds = o->full ? SECONDS_FULL : SECONDS,
        .only = o->only};
    if (o->items) limits.items = o->items;
    if (o->seconds > 0) limits.seconds = o->seconds;
    return limits;
}

int main(int argc, char **argv)
{
    options o;
    if (!parse(argc, argv, &o)) return 64; /* EX_USAGE */
    printer p = {.json = o.json};
    if (!o.json) print_settings();
    for (size_t i = 0; i < narrow_pair_count; i++) {
        narrow_limits limits = limits_for(&o, &narrow_pairs[i]);
        for (int k = 0; k < REGIME_COUNT; k++)
            if (is_wanted(&o, &narrow_pairs[i], (narrow_regime)k))
                narrow_race_run(&narrow_pairs[i], (narrow_regime)k, &limits, print_figures, &p);
    }
    if (!o.json) print_behind(&p);
    if (p.truths_missed) fprintf(stderr, "failed: %zu of our intervals do not hold the truth\n", p.truths_missed);
    return p.truths_missed ? EXIT_FAILURE : EXIT_SUCCESS;
}
