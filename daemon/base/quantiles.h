/* quantiles: how long things took, as shares of a window: half of them at most so long, 99 of 100 at most so long.
 * Eight classes a doubling, so that what is reported is at most an eighth above the truth, and never below it. One
 * thread writes and reads; nothing is allocated. */
#ifndef COLLIDED_BASE_QUANTILES_H
#define COLLIDED_BASE_QUANTILES_H

#include <stdint.h>

enum { QUANTILES_CLASSES = 8 * 61 };

typedef struct quantiles {
    uint32_t in[QUANTILES_CLASSES];
    uint64_t count;
    int64_t most_ns; /* exact */
} quantiles;

void quantiles_add(quantiles *q, int64_t ns); /* below 0 counts as 0 */
/* The least time that a share (0 to 1) of those added did not exceed, rounded up to its class; 0: none was added. */
int64_t quantiles_at(const quantiles *q, double share);
void quantiles_clear(quantiles *q);

#endif
