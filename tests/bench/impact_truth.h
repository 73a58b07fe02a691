/* impact_truth: when two moving bodies first touch, by marching from one certified distance to the next. It shares with
 * what it judges the static distances alone: no direction is carried from one time to another, and no bound is used but
 * that no point is faster than the linear speed plus the turning times the reach. Slow, and one line long. */
#ifndef COLLIDED_TESTS_BENCH_IMPACT_TRUTH_H
#define COLLIDED_TESTS_BENCH_IMPACT_TRUTH_H

#include "impact_peer.h"

typedef enum impact_verdict {
    IMPACT_FREE,
    IMPACT_HIT,
    IMPACT_UNCLEAR /* in contact at the beginning, or so near that neither is proven */
} impact_verdict;

typedef struct impact_truth {
    impact_verdict verdict;
    double lo, hi;  /* s; HIT: apart before lo, touching at hi */
    double nearest; /* m; FREE: a lower bound of the least distance */
} impact_truth;

impact_truth impact_truth_of(const impact_item *item);

#endif
