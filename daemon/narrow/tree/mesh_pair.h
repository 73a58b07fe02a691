/* mesh_pair: pairs with a mesh: how near the surfaces are, how deep they overlap, where they touch. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_TREE_MESH_PAIR_H
#define COLLIDED_NARROW_TREE_MESH_PAIR_H

#include "mesh_walk.h"
#include "narrow/convex/epa.h"
#include "union_depth.h"

/* ==== surfaces ==== */

/* The distance of two surfaces, one or both a mesh, and whether one lies inside of the other. */

/* How far a component reaches along a direction of A's frame, from its one end to the other: no less than it does. */
double mesh_component_width(const mesh_walk *w, bool of_a, uint32_t component, vec3 direction);

/* ---- mesh gap ---- */

typedef enum mesh_relation {
    MESH_APART,    /* the cores have no point in common */
    MESH_CROSSING, /* a surface passes through the other core, or is so near that rounding decides, or nearer than
                      narrow_goal.near: then lo is -INFINITY */
    MESH_HOLDS_A, /* A's core, or a component of a mesh A, is inside of B, which is a solid; no surface meets another */
    MESH_HOLDS_B  /* the other way round */
} mesh_relation;

typedef struct mesh_gap {
    span nearest; /* of the surfaces: lo <= distance <= hi, the axis from A to B, the nearest points. Where one of
                     several components is held: of a point of it, and the surface about it */
    uint32_t triangle_a, triangle_b; /* the nearest of the surfaces */
    mesh_relation relation;
    uint32_t component; /* of a mesh, that is held: the first in its order */
    bool cut;           /* the effort of the query ended before it was certain which pair of parts is the nearest */
} mesh_gap;

/* The parts that were the nearest at another time; any would do. */
typedef struct mesh_seed {
    uint32_t triangle_a, triangle_b;
} mesh_seed;

/* The state of the walk. Every triangle counts: what was not looked at was proven to be no nearer. A seed (or NULL)
 * changes the time, and not a bit of the answer. */
void mesh_gap_find(mesh_walk *w, const narrow_goal *goal, const mesh_seed *seed, mesh_gap *out);

/* ==== depths ==== */

/* How deep a mesh overlaps, bracketed.
 *
 * A convex mesh is its hull. Of other solids that convex pieces fill (geom/mesh_pieces.c), and of most machine parts
 * that is all of them, the least translation out of the union of the pieces' differences is searched (union_depth.h);
 * that it separates is proven by all triangles. What is said below is for what has no pieces, or in part. All searches
 * end after a counted work, so that an answer depends on the poses alone; where that is before the goal, the bracket is
 * wide and says so.
 *
 * At least so deep: each part of either shape overlaps the other by no more than the whole does, so the deepest pair of
 * parts is a lower bound of the depth; inside of a solid, so is the way to its surface, and a ball that fits in beside
 * it. At most so deep: a translation after which the surfaces are proven to be apart, found along the direction of the
 * deepest pair; or that which separates the convex hulls. The two meet where the contact is with one side, and may be
 * far apart in a crevice. */

/* `whole`: the pair with its meshes; `gap`: what mesh_gap_find said of it; `goal->brief`: the first bracket is enough:
 * the pieces for as long as a walk over the triangles takes, else the first triangles that cross, and the hulls. Fills
 * *out as if the depth were one of cores (narrow.c takes the radii off both bounds). */
void mesh_depth_find(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    epa_scratch *scratch, union_scratch *pieces, span *out);

/* For a verdict alone: sets out->lo from the convex hulls along out->axis. */
void mesh_depth_rough(const unit_pair *whole, span *out);

/* The same pair with the convex hulls in place of the meshes. */
unit_pair mesh_depth_hulls(const unit_pair *whole);

/* ==== whole answers ==== */

/* The functions that narrow.c calls for pairs with a mesh. */

/* Is one shape a mesh, and the other no half-space? A half-space meets a mesh exactly as it meets its convex hull. */
static inline bool mesh_pair_applies(const shape *a, const shape *b)
{
    return b->type == SHAPE_MESH && a->type != SHAPE_HALFSPACE;
}

/* Sets the bounds of rounding and of hulls for pairs with a mesh. It is called before goal_of. */
void mesh_pair_prepare(unit_pair *p, const shape *a);

/* Measures the pair. The search begins with the triangles of `cache`, and writes the nearest ones to it; it may be
 * NULL. */
void mesh_pair_measure(const unit_pair *p, const shape *a, const shape *b, const narrow_goal *goal, narrow_cache *cache,
    epa_scratch *scratch, union_scratch *pieces, span *out);

/* Does what manifold_build does, over all triangles. */
void mesh_pair_manifold(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_result *answer, double threshold, manifold *out);

#endif
