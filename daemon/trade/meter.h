/* meter: what the answers of a tick cost at each level, and how far they are from the truth.
 *
 * Each answer that the exact run's narrow phase gave is asked again at every level, from nothing and by one thread, in
 * turn, so that all levels see the same pairs at the same poses and the same machine. Its time is the least of three,
 * so that the spread is that of the answers and not that of the scheduler. Its error is how far the farther end of its
 * interval can be from the truth: max(hi - LO, HI - lo), where [LO, HI] is as narrow as arithmetic gives. Errors count
 * for pairs within what somebody asked (beyond it a lower bound is all that is owed, and nobody is told of it). An
 * interval that does not meet [LO, HI] excludes the truth: such ones are counted, and there must be none. */
#ifndef COLLIDED_TRADE_METER_H
#define COLLIDED_TRADE_METER_H

#include "level.h"
#include "spread.h"

enum { METER_PAIRS = SHAPE_TYPE_COUNT * SHAPE_TYPE_COUNT, METER_A_TICK = 200 };

typedef struct meter_cell { /* of a pair of types at one level */
    spread times;           /* ns */
    uint64_t errors, outside;
    double error_max, error_sum; /* m */
} meter_cell;

typedef struct meter {
    meter_cell *cells[METER_PAIRS]; /* TRADE_LEVELS each, or NULL: no such pair was asked */
    uint64_t answers, measured;     /* of a tick at most METER_A_TICK are measured, spread over all of them */
    int64_t clock_ns;               /* what looking at the clock twice costs */
} meter;

meter *meter_create(void);
void meter_destroy(meter *m);
/* After a tick of the exact run. */
void meter_tick(meter *m, const world *exact);
/* Where a pair of types is counted, in any order of the two; METER_PAIRS if one is no type. */
size_t meter_pair(shape_type a, shape_type b);

#endif
