/* bench_pareto: speed against accuracy. Every pair type separated, in shallow and in deep contact, cold and coherent
 * (narrow_scene.h); ours at each stage of the dial, and each peer at each tolerance that it can be given
 * (pareto_sweep.h), interleaved in one process (narrow_race.h) and judged by the truth in 113 bits (narrow_truth.h).
 * One thread. Tables, or one JSON object a line, on stdout; progress and the count of who is dominated on stderr.
 *
 * A peer at one of its tolerances is dominated in a row if ours at some tolerance, without a wrong verdict or a
 * failure, takes at most its mean time at an error not above its own. Errors up to 4e-15 of the size are the rounding
 * of poses in doubles and count as equal. Of a peer that does not measure, only the verdict is asked of ours; but a
 * verdict that is proven: bounds that leave it open beat nobody. */
#include "bench.h"
#include "pareto_sweep.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ITEMS = 80, ITEMS_FULL = 512, ITEMS_MESH = 32, ITEMS_MOST = 100000, FIGURES_MOST = 128 };
static const double SECONDS = 0.7, SECONDS_FULL = 6, ERROR_FLOOR = 4e-15;

typedef struct options {
    bool json, full;
    const char *pair;
    unsigned long items; /* 0 = the default */
    double seconds;      /* a row; 0 = the default */
    FILE *lines;         /* JSON lines go there, too */
} options;

static bool usage(const char *program)
{
    fprintf(stderr,
        "usage: %s [--json] [--full] [--pair PAIR] [--items 48..%d] [--seconds A_ROW] [--lines FILE]\npairs:", program,
        ITEMS_MOST);
    for (size_t i = 0; i < narrow_pair_count; i++) fprintf(stderr, " %s", narrow_pairs[i].name);
    fprintf(stderr, "\n--full: more configurations, longer; --lines: JSON lines go there, too\n");
    return false;
}

static bool is_pair(const char *name)
{
    for (size_t i = 0; i < narrow_pair_count; i++)
        if (strcmp(narrow_pairs[i].name, name) == 0) return true;
    return false;
}

static bool parse(int argc, char **argv, options *o)
{
    static const struct option known[] = {{"json", no_argument, NULL, 'j'}, {"full", no_argument, NULL, 'f'},
        {"pair", required_argument, NULL, 'p'}, {"items", required_argument, NULL, 'i'},
        {"seconds", required_argument, NULL, 's'}, {"lines", required_argument, NULL, 'l'}, {NULL, 0, NULL, 0}};
    *o = (options){0};
    for (int c; (c = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        if (c == 'j') o->json = true;
        if (c == 'f') o->full = true;
        if (c == 'p') o->pair = optarg;
        if (c == 'i') o->items = strtoul(optarg, NULL, 10);
        if (c == 's') o->seconds = strtod(optarg, NULL);
        if (c == 'l' && !(o->lines = fopen(optarg, "w"))) return usage(argv[0]);
        if (c == '?') return usage(argv[0]);
    }
    bool items = !o->items || (o->items >= 48 && o->items <= ITEMS_MOST);
    bool right = optind == argc && items && (!o->pair || is_pair(o->pair)) && o->seconds >= 0 && o->seconds <= 3600;
    return right || usage(argv[0]);
}

/* ---- who is dominated ---- */

typedef struct collected { /* of one pair type and regime: the cold row and the coherent one */
    narrow_figures at[FIGURES_MOST];
    size_t count;
} collected;

static void collect(void *context, const narrow_figures *f)
{
    collected *c = context;
    if (c->count < FIGURES_MOST) c->at[c->count++] = *f;
}

/* Boxes and bounds may say "perhaps", which is counted as an overlap: only where all are apart have they decided. */
static bool decides(const narrow_figures *f)
{
    bool may_not = f->entry->peer == &narrow_dial_boxes || f->entry->peer == &narrow_dial_bounds;
    return !may_not || f->regime == REGIME_SEPARATED;
}

static bool beats(const narrow_figures *ours, const narrow_figures *peer)
{
    bool sound = ours->wrong == 0 && ours->failed == 0 && ours->coherent == peer->coherent && decides(ours);
    bool measures = ours->measured == ours->items && ours->error_max <= fmax(peer->error_max, ERROR_FLOOR);
    return sound && ours->ns_mean <= peer->ns_mean && (peer->measured == 0 || measures);
}

static bool is_dominated(const collected *c, const narrow_figures *peer)
{
    for (size_t i = 0; i < c->count; i++)
        if (c->at[i].ours && beats(&c->at[i], peer)) return true;
    return false;
}

/* A peer at a tolerance at which it errs or fails is no choice. */
static bool is_sound(const narrow_figures *f)
{
    return f->wrong == 0 && f->failed == 0;
}

typedef struct tally { /* of a pair type: rows of peers */
    size_t sound, sound_dominated, all, all_dominated, missed_by_ours, intervals_off;
} tally;

static void count_row(tally *t, const narrow_figures *f, bool dominated)
{
    if (f->ours) {
        t->missed_by_ours += f->missed + f->failed;
        t->intervals_off += f->missed_truth;
        return;
    }
    t->all++;
    t->all_dominated += dominated;
    t->sound += is_sound(f);
    t->sound_dominated += is_sound(f) && dominated;
}

/* ---- output ---- */

/* JSON has no NaN. */
static const char *number(char out[32], double value, const char *none)
{
    if (isfinite(value))
        snprintf(out, 32, "%.3e", value);
    else
        snprintf(out, 32, "%s", none);
    return out;
}

static void print_json(FILE *out, const narrow_figures *f, bool dominated)
{
    char text[2][32];
    bool named = !(f->entry->own > 0);
    fprintf(out, "{\"bench\":\"pareto\",\"pair\":\"%s\",\"regime\":\"%s\",\"coherent\":%s,\"contender\":\"%s\",",
        f->pair->name, narrow_regime_names[f->regime], f->coherent ? "true" : "false", f->contender);
    fprintf(out, "\"tolerance\":%s%s%s,\"ns_mean\":%.2f,\"ns_p99\":%.2f,", named ? "\"" : "", f->entry->label,
        named ? "\"" : "", f->ns_mean, f->ns_p99);
    fprintf(out, "\"error_max\":%s,\"error_p99\":%s,\"missed\":%zu,\"false\":%zu,\"failed\":%zu,",
        number(text[0], f->error_max, "null"), number(text[1], f->error_p99, "null"), f->missed, f->false_hits,
        f->failed);
    fprintf(out, "\"measured\":%zu,\"items\":%zu,\"dominated\":%s,\"entry\":\"%s\",\"settings\":\"%s\"}\n", f->measured,
        f->items,
        f->ours     ? "null"
        : dominated ? "true"
                    : "false",
        f->called, f->settings);
}

static void print_head(const narrow_figures *f)
{
    printf("\n%s, %s, %s: %zu configurations\n", f->pair->name, narrow_regime_names[f->regime],
        f->coherent ? "coherent" : "cold", f->items);
    printf("%-18s %-9s %9s %9s | %9s %9s | %6s %6s %6s\n", "", "tolerance", "ns mean", "p99", "error max", "p99",
        "missed", "false", "failed");
}

static void print_table(const narrow_figures *f, bool dominated)
{
    char text[2][32];
    printf("%-18s %-9s %9.1f %9.1f | %9s %9s | %6zu %6zu %6zu%s\n", f->contender, f->entry->label, f->ns_mean,
        f->ns_p99, number(text[0], f->error_max, "-"), number(text[1], f->error_p99, "-"), f->missed, f->false_hits,
        f->failed,
        f->ours || dominated ? ""
        : is_sound(f)        ? "  not dominated"
                             : "  not dominated, but wrong");
}

static void print_rows(const collected *c, const options *o, tally *t)
{
    for (size_t i = 0; i < c->count; i++) {
        const narrow_figures *f = &c->at[i];
        bool dominated = !f->ours && is_dominated(c, f);
        if (!o->json && (i == 0 || f->coherent != c->at[i - 1].coherent)) print_head(f);
        if (o->lines) print_json(o->lines, f, dominated);
        if (o->json)
            print_json(stdout, f, dominated);
        else
            print_table(f, dominated);
        count_row(t, f, dominated);
    }
    fflush(stdout);
}

/* ---- all rows ---- */

static narrow_limits limits_for(const options *o, const narrow_pair *pair)
{
    narrow_limits limits = {.items = o->full                ? ITEMS_FULL
                                     : pair->b == KIND_MESH ? ITEMS_MESH
                                                            : ITEMS,
        .seconds = o->full ? SECONDS_FULL : SECONDS,
        .entries = pareto_sweep,
        .entry_count = pareto_sweep_count};
    if (o->items) limits.items = o->items;
    if (o->seconds > 0) limits.seconds = o->seconds;
    return limits;
}

static tally run_pair(const options *o, const narrow_pair *pair)
{
    tally t = {0};
    bool only_gaps = pair->b == KIND_MESH || pair->b == KIND_COMPOUND; /* their depths have no truth here */
    narrow_limits limits = limits_for(o, pair);
    for (int regime = 0; regime < (only_gaps ? 1 : REGIME_COUNT); regime++) {
        collected c = {.count = 0};
        narrow_race_run(pair, (narrow_regime)regime, &limits, collect, &c);
        print_rows(&c, o, &t);
    }
    return t;
}

int main(int argc, char **argv)
{
    options o;
    if (!parse(argc, argv, &o)) return 64; /* EX_USAGE */
    size_t pairs = 0, won = 0, won_all = 0, missed = 0, off = 0;
    for (size_t i = 0; i < narrow_pair_count; i++) {
        if (o.pair && strcmp(o.pair, narrow_pairs[i].name) != 0) continue;
        tally t = run_pair(&o, &narrow_pairs[i]);
        if (t.all)
            fprintf(stderr, "%s: of %zu sound rows of peers %zu are dominated; of all %zu, %zu\n", narrow_pairs[i].name,
                t.sound, t.sound_dominated, t.all, t.all_dominated);
        missed += t.missed_by_ours;
        off += t.intervals_off;
        if (!t.all) continue; /* no peer can */
        pairs++;
        won += t.sound == t.sound_dominated;
        won_all += t.all == t.all_dominated;
    }
    fprintf(stderr, "every sound row of every peer is dominated in %zu of %zu pair types; every row at all in %zu\n",
        won, pairs, won_all);
    if (o.lines && fclose(o.lines) != 0) return EXIT_FAILURE;
    if (missed || off)
        fprintf(stderr, "failed: ours missed %zu, and %zu intervals are without the truth\n", missed, off);
    return missed || off ? EXIT_FAILURE : EXIT_SUCCESS;
}
