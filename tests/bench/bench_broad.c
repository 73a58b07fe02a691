/* bench_broad: our broad phase beside those of Bullet, FCL and ODE (broad_race.h), in worlds of 1,000 to 1,000,000
 * spheres and boxes (broad_scene.h), and alone (broad_alone.h). One thread. Tables, or one JSON object a line, on
 * stdout; progress on stderr.
 *
 * A step is all that a user does in a tick: hand in the boxes that moved, and get the pairs up to date. ratio = median
 * step / median step of the best peer that missed no pair; the ratio of the means beside it shows what a median hides.
 */
#include "bench.h"
#include "broad_alone.h"
#include "broad_race.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const size_t SIZES[] = {1000, 10000, 100000, 1000000};
static const double PERCENTS[] = {1, 10, 100};
enum { SIZE_COUNT = 4, PERCENT_COUNT = 3, LARGE = 1000000, PILE = 200, DRIFT_TICKS = 10000, ONE_SIZES = 7 };

typedef struct options {
    bool json, full, race_only, alone_only;
    size_t count;   /* 0 = all sizes */
    double percent; /* 0 = all shares */
    double seconds; /* a cell; 0 = the default */
    const char *only, *plot;
} options;

static bool usage(const char *program)
{
    fprintf(stderr,
        "usage: %s [--json] [--full] [--n 2..1000000] [--moving PERCENT] [--only PEER] [--seconds A_CELL] [--race] "
        "[--alone] [--plot FILE.svg]\n"
        "  --full   each cell for longer; peers may take a minute for a build or a step\n"
        "  --race   only the race; --alone: only ours alone; --plot: one moving body against the size, by gnuplot\n",
        program);
    return false;
}

static bool parse(int argc, char **argv, options *o)
{
    static const struct option known[] = {{"json", no_argument, NULL, 'j'}, {"full", no_argument, NULL, 'f'},
        {"n", required_argument, NULL, 'n'}, {"moving", required_argument, NULL, 'm'},
        {"only", required_argument, NULL, 'o'}, {"seconds", required_argument, NULL, 's'},
        {"race", no_argument, NULL, 'r'}, {"alone", no_argument, NULL, 'a'}, {"plot", required_argument, NULL, 'p'},
        {NULL, 0, NULL, 0}};
    *o = (options){0};
    for (int c; (c = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        if (c == 'j') o->json = true;
        if (c == 'f') o->full = true;
        if (c == 'n') o->count = strtoul(optarg, NULL, 10);
        if (c == 'm') o->percent = strtod(optarg, NULL);
        if (c == 'o') o->only = optarg;
        if (c == 's') o->seconds = strtod(optarg, NULL);
        if (c == 'r') o->race_only = true;
        if (c == 'a') o->alone_only = true;
        if (c == 'p') o->plot = optarg;
        if (c == '?') return usage(argv[0]);
    }
    bool count_is_right = !o->count || (o->count >= 2 && o->count <= LARGE);
    bool rest_is_right = o->percent >= 0 && o->percent <= 100 && o->seconds >= 0 && o->seconds <= 3600;
    return (optind == argc && count_is_right && rest_is_right) || usage(argv[0]);
}

/* ---- the race ---- */

typedef struct printer {
    bool json;
    size_t count; /* of the last row: a new size or share gets a head */
    double percent;
    size_t missed; /* by ours */
} printer;

/* JSON has no NaN. */
static const char *number(char out[32], double value, int decimals)
{
    if (isfinite(value))
        snprintf(out, 32, "%.*f", decimals, value);
    else
        snprintf(out, 32, "null");
    return out;
}

static void print_race_json(const race_row *r)
{
    char ratio[32], means[32];
    printf("{\"bench\":\"broad\",\"scene\":\"race\",\"n\":%zu,\"moving\":%g,\"contender\":\"%s\",\"entry\":\"%s\",",
        r->count, r->percent, r->contender, r->called);
    if (r->left_out[0]) {
        printf("\"us_per_step\":null,\"ns_per_moved\":null,\"ratio_to_best_peer\":null,\"left_out\":\"%s\"}\n",
            r->left_out);
        return;
    }
    printf("\"us_per_step\":%.3f,\"ns_per_moved\":%.2f,\"ratio_to_best_peer\":%s,\"ratio_of_means\":%s,", r->us_median,
        r->ns_per_moved, number(ratio, r->ratio, 4), number(means, r->ratio_of_means, 4));
    printf("\"us_mean\":%.3f,\"us_p99\":%.3f,\"ticks\":%zu,\"bytes_per_body\":%.1f,\"build_s\":%.4f,", r->us_mean,
        r->us_p99, r->ticks, r->bytes_per_body, r->build_s);
    printf("\"pairs\":%zu,\"extra\":%zu,\"missed\":%zu,\"neighbours\":%.3f}\n", r->pairs, r->extra, r->missed,
        r->neighbours);
}

static void print_race_head(const race_row *r)
{
    printf("\n%zu bodies, %g %% moving; a body has %.2f neighbours\n", r->count, r->percent, r->neighbours);
    printf("%-16s %11s %11s %11s %9s %7s %7s %8s %8s %8s %7s %7s\n", "", "us a step", "mean", "p99", "ns/moved",
        "ratio", "(means)", "B/body", "pairs", "extra", "missed", "ticks");
}

static void print_race_table(printer *p, const race_row *r)
{
    char ratio[32], means[32];
    if (r->count != p->count || r->percent != p->percent) print_race_head(r);
    p->count = r->count;
    p->percent = r->percent;
    if (r->left_out[0]) {
        printf("%-16s left out: %s\n", r->contender, r->left_out);
        return;
    }
    printf("%-16s %11.2f %11.2f %11.2f %9.1f %7s %7s %8.0f %8zu %8zu %7zu %7zu%s\n", r->contender, r->us_median,
        r->us_mean, r->us_p99, r->ns_per_moved, isfinite(r->ratio) ? number(ratio, r->ratio, 3) : "-",
        isfinite(r->ratio) ? number(means, r->ratio_of_means, 3) : "-", r->bytes_per_body, r->pairs, r->extra,
        r->missed, r->ticks, r->missed ? "  out: it misses pairs" : "");
}

static void print_race(void *context, const race_row *r)
{
    printer *p = context;
    if (r->ours) p->missed += r->missed;
    if (p->json)
        print_race_json(r);
    else
        print_race_table(p, r);
    fflush(stdout);
}

/* By default the whole run ends within five minutes: what a peer needs more time for is left to --full. */
static race_limits limits_for(const options *o, size_t count)
{
    bool large = count >= LARGE;
    race_limits limits = {.build_s = 25, .step_s = large ? 4 : 1, .cell_s = large ? 6 : 2.5, .only = o->only};
    if (o->full) limits = (race_limits){.build_s = 60, .step_s = 60, .cell_s = 5 * limits.cell_s, .only = o->only};
    if (o->seconds > 0) limits.cell_s = o->seconds;
    return limits;
}

/* Ours must not miss a pair. */
static bool run_race(const options *o)
{
    printer p = {.json = o->json};
    bool one_share = o->percent > 0;
    for (size_t i = 0; i < SIZE_COUNT; i++) {
        size_t count = o->count ? o->count : SIZES[i];
        race_limits limits = limits_for(o, count);
        race_run(count, one_share ? &o->percent : PERCENTS, one_share ? 1 : PERCENT_COUNT, &limits, print_race, &p);
        if (o->count) break;
    }
    return p.missed == 0;
}

/* ---- alone ---- */

/* The keys that each line has; ours alone has no peer. */
static void print_alone_keys(const char *part, size_t count, double percent, double us, double moved)
{
    printf("{\"bench\":\"broad\",\"scene\":\"%s\",\"n\":%zu,\"moving\":%g,\"contender\":\"%s\",\"entry\":\"%s\",\"us_"
           "per_step\":%.3f,"
           "\"ns_per_moved\":%.2f,\"ratio_to_best_peer\":null,",
        part, count, percent, peer_ours.name, peer_ours.entry, us, 1e3 * us / moved);
}

static void print_one(const options *o, const alone_one *r)
{
    if (!o->json) {
        printf("%-10zu %9.3f %9.3f %9.3f | %9.3f %9.3f %9.3f\n", r->count, r->same_median, r->same_mean, r->same_p99,
            r->any_median, r->any_mean, r->any_p99);
        return;
    }
    print_alone_keys("one", r->count, 100.0 / (double)r->count, r->same_median, 1);
    printf("\"us_mean\":%.3f,\"us_p99\":%.3f,\"any_us\":%.3f,\"any_us_mean\":%.3f,\"any_us_p99\":%.3f,\"ticks\":%zu}\n",
        r->same_mean, r->same_p99, r->any_median, r->any_mean, r->any_p99, r->ticks);
}

static bool plot_one(const char *path, const alone_one *rows, size_t count)
{
    FILE *f = popen("gnuplot", "w"); /* NOLINT(cert-env33-c): a fixed line */
    if (!f) return false;
    fprintf(f, "set terminal svg size 720,440\nset output '%s'\nset logscale x\nset xrange [700:1400000]\n", path);
    fprintf(f, "set yrange [0:*]\nset grid\nset key left top\nset xlabel 'bodies in the world'\n"
               "set ylabel 'us a tick, one body moves (mean)'\n"
               "plot '-' using 1:2 with linespoints title 'the same body', "
               "'-' using 1:2 with linespoints title 'another body each time, out of its fat box'\n");
    for (size_t i = 0; i < count; i++) fprintf(f, "%zu %.4f\n", rows[i].count, rows[i].same_mean);
    fprintf(f, "e\n");
    for (size_t i = 0; i < count; i++) fprintf(f, "%zu %.4f\n", rows[i].count, rows[i].any_mean);
    fprintf(f, "e\n");
    return pclose(f) == 0;
}

static bool run_one(const options *o)
{
    static const size_t sizes[ONE_SIZES] = {1000, 3000, 10000, 30000, 100000, 300000, 1000000};
    alone_one rows[ONE_SIZES];
    size_t count = 0;
    if (!o->json)
        printf("\none body moves (us a tick)\n%-10s %29s | %s\n%-10s %9s %9s %9s | %9s %9s %9s\n", "", "the same",
            "another each time, out of its fat box", "bodies", "median", "mean", "p99", "median", "mean", "p99");
    for (size_t i = 0; i < ONE_SIZES; i += o->full ? 1 : 2) { /* every power of ten; --full: and between */
        if (o->count && sizes[i] > o->count) break;
        fprintf(stderr, "one body of %zu\n", sizes[i]);
        rows[count] = alone_move_one(sizes[i]);
        print_one(o, &rows[count++]);
        fflush(stdout);
    }
    if (!o->plot || plot_one(o->plot, rows, count)) return true;
    fprintf(stderr, "no plot %s: is gnuplot installed (package gnuplot-nox)?\n", o->plot);
    return false;
}

static bool run_pile(const options *o)
{
    alone_pile r = alone_coincident(PILE);
    if (o->json) {
        print_alone_keys("coincident", r.count, 100, r.step_us, (double)r.count);
        printf("\"build_us\":%.1f,\"pairs\":%zu,\"missed\":%zu}\n", r.build_us, r.pairs, r.wanted - r.pairs);
    } else {
        printf("\n%zu spheres on one spot: %zu of %zu pairs; put in %.0f us, all moved on together in %.0f us a step\n",
            r.count, r.pairs, r.wanted, r.build_us, r.step_us);
    }
    return r.pairs == r.wanted;
}

static void run_drift(const options *o, size_t count)
{
    fprintf(stderr, "drift: %zu bodies, %d ticks\n", count, DRIFT_TICKS);
    alone_drift r = alone_keep_moving(count, DRIFT_TICKS);
    if (o->json) {
        print_alone_keys("drift", r.count, 100, r.last_us, (double)r.count);
        printf("\"ticks\":%zu,\"first_tenth_us\":%.2f,\"last_tenth_us\":%.2f,\"last_to_first\":%.4f}\n", r.ticks,
            r.first_us, r.last_us, r.last_us / r.first_us);
    } else {
        printf("\ndrift: %zu bodies, all moving, %zu ticks: %.1f us a tick in the first tenth, %.1f in the last: %.3f "
               "times\n",
            r.count, r.ticks, r.first_us, r.last_us, r.last_us / r.first_us);
    }
    fflush(stdout);
}

static void run_memory(const options *o)
{
    size_t count = o->count ? o->count : LARGE;
    fprintf(stderr, "memory of %zu\n", count);
    alone_memory r = alone_bytes(count);
    if (o->json)
        printf(
            "{\"bench\":\"broad\",\"scene\":\"memory\",\"n\":%zu,\"moving\":100,\"contender\":\"%s\",\"entry\":\"%s\","
            "\"us_per_step\":null,\"ns_per_moved\":null,\"ratio_to_best_peer\":null,\"bytes_per_body\":%.1f,"
            "\"bytes_per_pair\":%.1f,\"pairs\":%zu}\n",
            r.count, peer_ours.name, peer_ours.entry, r.bytes_per_body, r.bytes_per_pair, r.pairs);
    else
        printf("\nmemory of %zu bodies with %zu pairs: %.1f bytes a body, %.1f bytes a pair\n", r.count, r.pairs,
            r.bytes_per_body, r.bytes_per_pair);
}

static bool run_alone(const options *o)
{
    bool right = run_one(o);
    right &= run_pile(o);
    run_drift(o, 1000);
    if (o->full) run_drift(o, 10000);
    run_memory(o);
    return right;
}

int main(int argc, char **argv)
{
    options o;
    bool right = true;
    if (!parse(argc, argv, &o)) return 64; /* EX_USAGE */
    if (broad_contender_count == broad_ours_count)
        fprintf(stderr, "without peers: configure with -DCOLLIDED_PEERS=ON (libbullet-dev, libfcl-dev, libode-dev)\n");
    if (!o.alone_only) right &= run_race(&o);
    if (!o.race_only) right &= run_alone(&o);
    if (!right) fprintf(stderr, "failed: see above\n");
    return right ? EXIT_SUCCESS : EXIT_FAILURE;
}
