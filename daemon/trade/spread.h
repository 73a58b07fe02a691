/* spread: how times are distributed, in memory that does not grow: counts by size, 32 to each doubling, so that a
 * percentile is told within 3 %. One thread. */
#ifndef COLLIDED_TRADE_SPREAD_H
#define COLLIDED_TRADE_SPREAD_H

#include <stdint.h>

enum { SPREAD_BINS = 64 + 40 * 32 }; /* up to 2^46 ns, 19 hours */

typedef struct spread {
    uint64_t count, bins[SPREAD_BINS];
    double sum, sums[SPREAD_BINS]; /* ns */
} spread;

void spread_add(spread *s, int64_t ns);                  /* below 0 counts as 0 */
double spread_mean(const spread *s);                     /* 0 if it is empty */
double spread_percentile(const spread *s, double share); /* ns, below which that share of them is */
/* The mean without the slowest 1 %: what the scheduler did to a tick is no property of it. */
double spread_calm_mean(const spread *s);

#endif
