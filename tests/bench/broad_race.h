/* broad_race: all contenders through the same scene, side by side in one process: block of ticks by block of ticks, in
 * rotating order, so that whatever else the machine does falls on all of them. One thread. */
#ifndef COLLIDED_TESTS_BENCH_BROAD_RACE_H
#define COLLIDED_TESTS_BENCH_BROAD_RACE_H

#include "broad_scene.h"

typedef struct race_limits {
    double build_s, step_s; /* a peer that needs longer for one build is left out; for one step, of that cell */
    double cell_s;          /* each cell is measured for so long, but for no fewer than three blocks */
    const char *only;       /* race only this peer, and ours; NULL = all */
} race_limits;

typedef struct race_row {
    size_t count, moved;
    double percent;
    const char *contender, *called; /* called: the functions that are timed */
    bool ours;
    char left_out[96]; /* why; empty = it took part, and the rest is valid */
    size_t ticks;      /* measured */
    double us_median, us_mean, us_p99;
    double ns_per_moved;          /* of the median */
    double bytes_per_body;        /* held between ticks, the caller's objects included */
    double build_s;               /* all bodies put in, and the first pairs found */
    double ratio, ratio_of_means; /* to the best peer that missed nothing; NAN = there is none */
    size_t pairs, extra, missed;  /* at the last check; missed: in all checks */
    double neighbours;            /* that a body truly has, on the average */
} race_row;

typedef void race_report(void *context, const race_row *row);

/* One world size, and the cells of it in turn. Rows come cell by cell. */
void race_run(size_t count, const double *percents, size_t percent_count, const race_limits *limits,
    race_report *report, void *context);

/* Bytes that malloc has handed out and not got back. */
size_t race_allocated(void);

#endif
