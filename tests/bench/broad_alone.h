/* broad_alone: what is asked of our broad phase beside the race: one body that moves in a large world, coincident
 * bodies, drift, and memory. One thread. */
#ifndef COLLIDED_TESTS_BENCH_BROAD_ALONE_H
#define COLLIDED_TESTS_BENCH_BROAD_ALONE_H

#include <stddef.h>

/* One body moves, in a world of `count`: always the same one, a tick of its motion each time; or each time another one,
 * by eight ticks at once: its boxes are in no cache, and it leaves its fat box, the worst that can be. us a tick. */
typedef struct alone_one {
    size_t count, ticks;
    double same_median, same_mean, same_p99;
    double any_median, any_mean, any_p99;
} alone_one;
alone_one alone_move_one(size_t count);

/* `count` spheres of radius 0.5 m on one spot. us. */
typedef struct alone_pile {
    size_t count, pairs, wanted;
    double build_us, step_us; /* of all put at once; of all moved together by more than their margin */
} alone_pile;
alone_pile alone_coincident(size_t count);

/* Everybody moves, for `ticks`: mean us a tick of the first and of the last tenth. */
typedef struct alone_drift {
    size_t count, ticks;
    double first_us, last_us;
} alone_drift;
alone_drift alone_keep_moving(size_t count, size_t ticks);

/* After a few ticks of everybody moving. */
typedef struct alone_memory {
    size_t count, pairs;
    double bytes_per_body, bytes_per_pair;
} alone_memory;
alone_memory alone_bytes(size_t count);

#endif
