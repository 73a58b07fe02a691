/* mesh_pair: what narrow.c asks of pairs with a mesh. Pure; any thread. */
#ifndef COLLIDED_NARROW_MESH_PAIR_H
#define COLLIDED_NARROW_MESH_PAIR_H

#include "epa.h"
#include "mesh_walk.h"
#include "union_depth.h"

/* ---- mesh part ---- */

/* The distance of the two parts that a walk visits. */

/* As gjk_distance, from what belongs to the parts alone (w->lead, w->from, w->edges): so the answer about two parts
 * does not depend on which others were looked at before. */
void mesh_part_distance(const mesh_walk *w, const narrow_goal *goal, span *out);

/* ---- mesh held ---- */

/* Which component of one mesh is inside of another, a solid. */

#define MESH_NOT_HELD UINT32_MAX
#define MESH_HELD_UNKNOWN (UINT32_MAX - 1) /* the effort of the query ended */

/* No surface is within rounding of the other. The first component of B (`of_a`: of A) in the order of its mesh that is
 * inside of the other, whatever the walk is aimed at and within; it is moved to where it is, and forgets its axis.
 * Or one of the two above. */
uint32_t mesh_held_component(mesh_walk *w, bool of_a);

/* A point of a component, in A's frame and units of the pair. */
vec3 mesh_component_point(const mesh_walk *w, bool of_a, uint32_t component);

/* How far a component reaches along a direction of A's frame, from its one end to the other: no less than it does. */
double mesh_component_width(const mesh_walk *w, bool of_a, uint32_t component, vec3 direction);

/* ---- mesh pair ---- */

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
