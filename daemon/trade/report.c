/* report: rows in the order of types and levels. One thread. */
#include "report.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

typedef struct row {
    spread times;
    uint64_t errors, outside, events, missed, false_ones;
    double error_max, error_sum, bytes;
} row;

static void add(row *to, const row *from)
{
    for (size_t i = 0; i < SPREAD_BINS; i++) {
        to->times.bins[i] += from->times.bins[i];
        to->times.sums[i] += from->times.sums[i];
    }
    to->times.count += from->times.count;
    to->times.sum += from->times.sum;
    to->errors += from->errors;
    to->outside += from->outside;
    to->events += from->events;
    to->missed += from->missed;
    to->false_ones += from->false_ones;
    to->error_max = fmax(to->error_max, from->error_max);
    to->error_sum += from->error_sum;
    to->bytes += from->bytes;
}

static void print(FILE *out, const char *pair, size_t level, const row *r, const spread *ticks, double seconds)
{
    fprintf(out,
        "row\t%s\t%s\t%" PRIu64 "\t%.9g\t%.9g\t%" PRIu64 "\t%.9g\t%.9g\t%" PRIu64 "\t%" PRIu64 "\t%" PRIu64 "\t%" PRIu64
        "\t%.9g\t%.9g\t%.9g\n",
        pair, trade_levels[level].name, r->times.count, spread_mean(&r->times), spread_percentile(&r->times, 0.99),
        r->errors, r->error_max, r->errors ? r->error_sum / (double)r->errors : 0, r->outside, r->events, r->missed,
        r->false_ones, seconds > 0 ? r->bytes / seconds : 0, ticks ? spread_calm_mean(ticks) : 0,
        ticks ? spread_percentile(ticks, 0.99) : 0);
}

static void fill(
    const trade_result *t, size_t pair, size_t level, const uint64_t *missed, const uint64_t *false_ones, row *r)
{
    *r = (row){.events = t->reported[level]->pair_events[pair],
        .bytes = t->reported[level]->pair_bytes[pair],
        .missed = missed[pair],
        .false_ones = false_ones[pair]};
    if (pair == METER_PAIRS || !t->meter->cells[pair]) return;
    const meter_cell *c = &t->meter->cells[pair][level];
    r->times = c->times;
    r->errors = c->errors;
    r->outside = c->outside;
    r->error_max = c->error_max;
    r->error_sum = c->error_sum;
}

typedef uint64_t pair_counts[METER_PAIRS + 1];

void report_rows(FILE *out, const trade_result *t)
{
    pair_counts *missed = base_zalloc(TRADE_LEVELS, sizeof *missed);
    pair_counts *false_ones = base_zalloc(TRADE_LEVELS, sizeof *false_ones);
    row *all = base_zalloc(TRADE_LEVELS, sizeof *all), *one = base_zalloc(TRADE_LEVELS, sizeof *one);
    for (size_t level = 0; level < TRADE_LEVELS; level++) {
        episodes_missing(t->reported[TRADE_EXACT], t->reported[level], missed[level]);
        episodes_missing(t->reported[level], t->reported[TRADE_EXACT], false_ones[level]);
    }
    for (size_t pair = 0; pair <= METER_PAIRS; pair++) {
        char name[64] = "bodies"; /* what is reported of whole ones, and batches without events */
        bool shown = false;
        if (pair < METER_PAIRS)
            snprintf(name, sizeof name, "%s-%s", shape_type_name((shape_type)(pair / SHAPE_TYPE_COUNT)),
                shape_type_name((shape_type)(pair % SHAPE_TYPE_COUNT)));
        for (size_t level = 0; level < TRADE_LEVELS; level++) {
            fill(t, pair, level, missed[level], false_ones[level], &one[level]);
            add(&all[level], &one[level]);
            shown |= one[level].times.count || one[level].events || one[level].missed;
        }
        for (size_t level = 0; shown && level < TRADE_LEVELS; level++)
            print(out, name, level, &one[level], NULL, t->seconds);
    }
    for (size_t level = 0; level < TRADE_LEVELS; level++)
        print(out, "all", level, &all[level], t->ticks[level], t->seconds);
    free(missed);
    free(false_ones);
    free(all);
    free(one);
}
