/* narrow_truth: the signed distance of each item in 113 bits, by the oracles of the tests (tests/narrow/oracle), which
 * share no code with the engine. One thread.
 *
 * Gaps: bounds from both sides, closed to 1e-26. Depths of polytopes (and of what is one but for its radius): all
 * features by brute force, or for many vertices the polytope grown from inside until nothing is nearer. Depths of
 * curved bodies: a sweep of directions over the whole sphere and along the ridges that their flat faces and straight
 * lines make, the best ones climbed. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_TRUTH_H
#define COLLIDED_TESTS_BENCH_NARROW_TRUTH_H

#include "narrow_scene.h"
#include "oracle/oracle.h"

typedef struct narrow_truth {
    quad distance; /* m */
    quad lo, hi;   /* it lies between; hi - lo is far below 1e-12 of the size */
    double size;   /* the greatest coordinate of the pair, m */
} narrow_truth;

narrow_truth narrow_truth_of(const narrow_item *item);

/* As that, and of curved bodies that overlap, or do so but for the rounding of the sweep, proven bounds from both
 * sides: [lo, hi] may be wide there, but its sign is certain where it has one. `distance` is lo, the deepest direction
 * that was found, by the sweep or by ours, evaluated in 113 bits. */
narrow_truth narrow_truth_proven(const narrow_item *item);

#endif
