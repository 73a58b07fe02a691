/* mesh_pair: what narrow.c asks of pairs with a mesh. Pure; any thread. */
#ifndef COLLIDED_NARROW_MESH_PAIR_H
#define COLLIDED_NARROW_MESH_PAIR_H

#include "epa.h"
#include "mesh_walk.h"
#include "union_depth.h"

/* Is one a mesh, and the other no half-space? A half-space meets a mesh as it meets its convex hull. */
static inline bool mesh_pair_applies(const shape *a, const shape *b)
{
    return b->type == SHAPE_MESH && a->type != SHAPE_HALFSPACE;
}

/* The allowance for rounding and for hulls that fits pairs with a mesh. Before the goal is made of it. */
void mesh_pair_prepare(unit_pair *p, const shape *a);

/* `cache` (or NULL): its triangles are where the search begins, and come to be the nearest ones. */
void mesh_pair_measure(const unit_pair *p, const shape *a, const shape *b, const narrow_goal *goal, narrow_cache *cache,
    epa_scratch *scratch, union_scratch *pieces, span *out);

/* As manifold_build, over all triangles. */
void mesh_pair_manifold(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_result *answer, double threshold, manifold *out);

#endif
