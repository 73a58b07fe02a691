/* histogram: how often a measured number fell below each of some bounds. One thread writes and reads; nothing is
 * allocated. */
#ifndef COLLIDED_BASE_HISTOGRAM_H
#define COLLIDED_BASE_HISTOGRAM_H

#include <stddef.h>
#include <stdint.h>

enum { HISTOGRAM_BOUNDS_MAX = 24 };

typedef struct histogram {
    const char *name, *help;                  /* static strings; the name ends with the unit */
    const double *bounds;                     /* rising; static */
    size_t count;                             /* of bounds */
    uint64_t below[HISTOGRAM_BOUNDS_MAX + 1]; /* at or below bounds[i], and above bounds[i - 1]; the last: above all */
    double sum;                               /* of those that are finite */
} histogram;

void histogram_add(histogram *h, double number); /* NaN is not counted */
uint64_t histogram_total(const histogram *h);

#endif
