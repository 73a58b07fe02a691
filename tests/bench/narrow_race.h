/* narrow_race: all contenders through the same items, side by side in one process: all items of a row by one contender,
 * then by the next, in another order each round, so that whatever else the machine does falls on all of them. One
 * thread.
 *
 * A sample is a block of NARROW_BLOCK queries, for a clock read costs as much as the fastest of them; so p99 is that of
 * blocks. Cold rows visit their blocks in another order each time; coherent ones follow their tracks. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_RACE_H
#define COLLIDED_TESTS_BENCH_NARROW_RACE_H

#include "narrow_scene.h"

enum { NARROW_BLOCK = 16 };

typedef struct narrow_entry { /* a contender at one of its tolerances */
    const narrow_peer *peer;
    double own;          /* as in narrow_row */
    const char *label;   /* what that tolerance is called */
    bool gaps, contacts; /* where it is of effect, so that nothing is raced twice: apart, in contact */
} narrow_entry;

typedef struct narrow_limits {
    size_t items;                /* configurations a row */
    double seconds;              /* that a row is measured for, all contenders together */
    const char *only;            /* race only this peer, and ours; NULL = all */
    const narrow_entry *entries; /* a sweep; NULL = all contenders as their settings say */
    size_t entry_count;
} narrow_limits;

typedef struct narrow_figures {
    const narrow_pair *pair;
    narrow_regime regime;
    bool coherent, ours;
    const char *contender, *settings, *called; /* called: the functions that are timed */
    const narrow_entry *entry;                 /* of a sweep */
    size_t items, samples;
    double ns_median, ns_p99;
    double ns_mean; /* over the blocks, of each the median of its rounds: what else the machine does stays outside */
    /* relative to the pair's size, of the answers that measure; NAN = none does */
    double error_median, error_p99, error_max;
    size_t measured, wrong, failed;
    size_t missed, false_hits; /* wrong verdicts: overlaps not seen, and overlaps that are none */
    size_t missed_truth;       /* intervals that do not hold the truth */
    bool right;        /* nothing wrong or failed, all measured, and as well as is called right; cold and coherent */
    double ratio;      /* to the best right peer of the row; NAN = there is none */
    double goal_ratio; /* NAN = none is set */
} narrow_figures;

typedef void narrow_report(void *context, const narrow_figures *figures);

/* The cold row and the coherent one. */
void narrow_race_run(
    const narrow_pair *pair, narrow_regime regime, const narrow_limits *limits, narrow_report *report, void *context);

#endif
