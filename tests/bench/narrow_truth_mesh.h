/* narrow_truth_mesh: the gap between a mesh and a box or another mesh: the least over all pairs of their pieces, each
 * by brute force in 113 bits; pairs whose bounding balls are farther apart than that are left out. One thread. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_TRUTH_MESH_H
#define COLLIDED_TESTS_BENCH_NARROW_TRUTH_MESH_H

#include "narrow_truth.h"

/* Of bodies that are apart; A is a mesh or a box, B a mesh. */
narrow_truth narrow_truth_of_meshes(const narrow_item *item);

#endif
