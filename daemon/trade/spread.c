/* spread: bins whose widths grow with the value. */
#include "spread.h"

#include <stddef.h>

static size_t bin_of(uint64_t ns)
{
    if (ns < 64) return ns;
    unsigned power = 63u - (unsigned)__builtin_clzll(ns);
    size_t bin = 64 + (size_t)(power - 6) * 32 + (ns >> (power - 5) & 31);
    return bin < SPREAD_BINS ? bin : SPREAD_BINS - 1;
}

void spread_add(spread *s, int64_t ns)
{
    size_t bin = bin_of(ns > 0 ? (uint64_t)ns : 0);
    double value = ns > 0 ? (double)ns : 0;
    s->count++;
    s->bins[bin]++;
    s->sum += value;
    s->sums[bin] += value;
}

double spread_mean(const spread *s)
{
    return s->count ? s->sum / (double)s->count : 0;
}

/* The bin in which the `share`-th value lies, and how many values and what sum lie in it and below. */
static size_t find(const spread *s, double share, uint64_t *count, double *sum)
{
    *count = 0;
    *sum = 0;
    for (size_t i = 0; i < SPREAD_BINS; i++) {
        *count += s->bins[i];
        *sum += s->sums[i];
        if ((double)*count >= share * (double)s->count) return i;
    }
    return SPREAD_BINS - 1;
}

double spread_percentile(const spread *s, double share)
{
    uint64_t count;
    double sum;
    if (!s->count) return 0;
    size_t i = find(s, share, &count, &sum);
    return s->bins[i] ? s->sums[i] / (double)s->bins[i] : 0;
}

double spread_calm_mean(const spread *s)
{
    uint64_t count;
    double sum;
    if (!s->count) return 0;
    find(s, 0.99, &count, &sum);
    return sum / (double)count;
}
