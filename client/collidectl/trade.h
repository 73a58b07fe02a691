/* trade: what the daemon's program measured of a recording at several accuracies, and what follows from it. One thread.
 *
 *   trade_run       runs 'collided --replay FILE --trade' and reads its lines (daemon/trade/report.h)
 *   trade_advice    which accuracy to use, and why
 *   trade_show      the table, for people and as JSON
 *   trade_picture   data file, script of gnuplot, and the pictures that it makes */
#ifndef COLLIDED_COLLIDECTL_TRADE_H
#define COLLIDED_COLLIDECTL_TRADE_H

#include "ctl.h"

#include <stdint.h>
#include <sys/types.h>

typedef struct trade_row { /* one pair of shape types at one accuracy; "all": the whole session */
    const char *pair, *accuracy;
    double measured;                /* answers that were timed */
    double time_mean_s, time_p99_s; /* of an answer, from nothing, by one thread */
    double errors;                  /* intervals that were held against the truth */
    double error_max_m, error_mean_m, outside;
    double events, missed, false_ones, bytes_per_s;
    double tick_mean_s, tick_p99_s; /* of "all"; the mean without the slowest 1 % */
} trade_row;

enum { TRADE_LEVELS_MAX = 64 }; /* accuracies */

typedef struct trade {
    double ticks, seconds, subscriptions, answers, measured;
    double left_out; /* of the ticks: something was announced in them, and their times are in no row */
    trade_row *rows; /* accuracies from the loosest to exact, pair by pair, "all" last */
    size_t row_count, levels;
} trade;

/* 0, or an exit status after saying why not. `file` must be readable. */
int trade_run(ctl *c, const char *file, trade *out);

/* Waits for the end of a process, whatever signals come: its exit status, -1 - N where signal N ended it, -1 where it
 * cannot be waited for. */
int trade_end_of(pid_t child);

/* The rows of "all": `levels` of them. */
const trade_row *trade_all(const trade *t);

typedef struct trade_advice {
    const trade_row *use; /* of "all"; never NULL */
    char reason[512];
} trade_advice;

/* Of the accuracies that miss nothing and tell nothing false, those that cost at most a tenth more than the cheapest of
 * them, and of these the finest: accuracy that is nearly free is taken. */
void trade_advise(const trade *t, trade_advice *out);

void trade_show_text(const char *file, const trade *t, const trade_advice *a);
void trade_show_json(const trade *t, const trade_advice *a, bool pictures, const char *prefix);

/* Writes PREFIX.tsv and PREFIX.gnuplot and lets gnuplot make PREFIX.svg and PREFIX.png of them; *made is false where
 * there is no gnuplot, which is told with the package to install. 0, or an exit status. */
int trade_picture(ctl *c, const trade *t, const trade_advice *a, const char *prefix, bool *made);

#endif
