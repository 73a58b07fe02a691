/* narrow_truth_compound: the gap between a compound of boxes and a box or another one: the least over all pairs of
 * boxes, each by brute force in 113 bits. One thread. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_TRUTH_COMPOUND_H
#define COLLIDED_TESTS_BENCH_NARROW_TRUTH_COMPOUND_H

#include "narrow_truth.h"

/* Of bodies that are apart; A is a compound or a box, B a compound. */
narrow_truth narrow_truth_of_compounds(const narrow_item *item);

#endif
