/* mesh_depth: how deep a mesh overlaps, bracketed. Pure; any thread.
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
#ifndef COLLIDED_NARROW_MESH_DEPTH_H
#define COLLIDED_NARROW_MESH_DEPTH_H

#include "epa.h"
#include "mesh_gap.h"
#include "union_depth.h"

/* `whole`: the pair with its meshes; `gap`: what mesh_gap_find said of it; `goal->brief`: the first bracket is enough:
 * the pieces for as long as a walk over the triangles takes, else the first triangles that cross, and the hulls. Fills
 * *out as if the depth were one of cores (narrow.c takes the radii off both bounds). */
void mesh_depth_find(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    epa_scratch *scratch, union_scratch *pieces, span *out);

/* Where a verdict is all that was asked: out->lo from the convex hulls along out->axis. */
void mesh_depth_rough(const unit_pair *whole, span *out);

/* The pair of the convex hulls. */
unit_pair mesh_depth_hulls(const unit_pair *whole);

#endif
