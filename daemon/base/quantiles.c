/* quantiles: see quantiles.h. A class is the three bits below the highest one; below 8 ns each number is its own. */
#include "quantiles.h"

#include <math.h>
#include <string.h>

static unsigned class_of(uint64_t ns)
{
    if (ns < 8) return (unsigned)ns;
    unsigned top = 63u - (unsigned)__builtin_clzll(ns);
    return 8 * (top - 2) + (unsigned)(ns >> (top - 3) & 7);
}

/* The highest number of a class. */
static int64_t end_of(unsigned class)
{
    if (class < 8) return class;
    unsigned shift = class / 8 - 1;
    uint64_t begin = (UINT64_C(8) + class % 8) << shift;
    return (int64_t)(begin + (UINT64_C(1) << shift) - 1);
}

void quantiles_add(quantiles *q, int64_t ns)
{
    if (ns < 0) ns = 0;
    q->in[class_of((uint64_t)ns)]++;
    q->count++;
    if (ns > q->most_ns) q->most_ns = ns;
}

int64_t quantiles_at(const quantiles *q, double share)
{
    uint64_t wanted = (uint64_t)ceil(share * (double)q->count), below = 0;
    if (wanted < 1) wanted = 1;
    for (unsigned i = 0; i < QUANTILES_CLASSES && q->count; i++) {
        below += q->in[i];
        if (below >= wanted) return end_of(i) < q->most_ns ? end_of(i) : q->most_ns;
    }
    return q->most_ns;
}

void quantiles_clear(quantiles *q)
{
    memset(q, 0, sizeof *q);
}
