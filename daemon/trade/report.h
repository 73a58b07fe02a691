/* report: what a trade found, as lines of tab-separated values. `collidectl trade` reads them.
 *
 *   trade 2                               the version of this format
 *   session TICKS SECONDS SUBSCRIPTIONS LEFT_OUT  what is in the recording; ticks in which something was announced
 *   progress SHARE                        0 to 1, while it works
 *   answers ASKED MEASURED
 *   row PAIR ACCURACY MEASURED TIME_MEAN_NS TIME_P99_NS ERRORS ERROR_MAX_M ERROR_MEAN_M OUTSIDE EVENTS MISSED FALSE
 *       BYTES_PER_S TICK_MEAN_NS TICK_P99_NS
 *   end                                   all of it has been reported
 *
 * A row for each pair of shape types and level, then one for "all" of them, which alone has times of ticks: of those
 * that are not left out. */
#ifndef COLLIDED_TRADE_REPORT_H
#define COLLIDED_TRADE_REPORT_H

#include "episodes.h"
#include "meter.h"

#include <stdio.h>

typedef struct trade_result {
    const meter *meter;
    const episodes *reported[TRADE_LEVELS];
    const spread *ticks[TRADE_LEVELS];
    double seconds;
} trade_result;

void report_rows(FILE *out, const trade_result *r);

#endif
