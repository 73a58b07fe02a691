/* toi_truth: when two moving shapes first touch, by marching from one certified distance to the next.
 *
 * It shares with what it judges the static distances and motion_pose alone: no direction is carried from one time to
 * another, and no bound is used but that no two points approach faster than the linear speed plus the turning times the
 * reach. Slow, and short. The contact behind the end of the march is looked for, ever farther from it. */
#ifndef COLLIDED_TESTS_TOI_TRUTH_H
#define COLLIDED_TESTS_TOI_TRUTH_H

#include "toi/toi.h"

typedef enum toi_verdict {
    TRUTH_FREE,
    TRUTH_HIT,
    TRUTH_UNCLEAR /* so near that neither is proven, or too many steps */
} toi_verdict;

typedef struct toi_truth {
    toi_verdict verdict;
    double lo, hi;  /* s; HIT: apart before lo, touching at hi. UNCLEAR: apart before lo */
    double nearest; /* m; a lower bound of the distance up to the span, or to lo */
} toi_truth;

toi_truth toi_truth_of(const toi_mover *a, const toi_mover *b, double span, narrow_scratch *scratch);

/* The certified distance at a time. */
narrow_result toi_truth_at(
    const toi_mover *a, const toi_mover *b, double time, double tolerance, narrow_scratch *scratch);

/* m: of both shapes, half-spaces left out. */
double toi_truth_size(const toi_mover *a, const toi_mover *b);

#endif
