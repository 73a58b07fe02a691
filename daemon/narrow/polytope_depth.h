/* polytope_depth: the depth of two overlapping polytopes by the expanding polytope, as epa.h, for the common case: few
 * vertices, no slivers.
 *
 * The points of two polytopes' difference are finitely many, so the search ends on a facet of it, not close to one.
 * That allows a smaller machine than epa.c's: at most 64 points; facets in columns, looked at side by side; which facet
 * is left of a directed edge stands in a table. The proof of both bounds is that of epa.h.
 *
 * Pure; any thread.
 *
 * What a pair may remember: the surface, as pairs of vertices (narrow_shell). What is costly is the proof that no other
 * facet of B - A is nearer. It is made anew in each pose, but from the surface that was grown in the pose before: its
 * points are placed anew, and as long as each of its facets sees the origin on its inner side, it is a closed surface
 * around it, and the origin is as deep inside as the nearest of its facets is away, as of any surface of epa.h. Facets
 * that have come too near are grown on.
 *
 * Why that gives the bits of a search from nothing. F is a facet of B - A, strict as near_features.h says but for 3,
 * of which the nearest point is inside by r >= NEAR_INSIDE; D its distance, n its normal; sizes are 1. What is proven
 * is that all facets of the surface but those in F's plane are at least D + 2m away, 2m = NEAR_DEPTH_MARGIN. Claim: a
 * search from nothing that ends with bounds closed to `error` has an axis n' within 2^-17 of n, and so reads F off it.
 * Proof: n' has the height h(n') <= D + 2 error < D + 2m. The ray along n' leaves the surface at most h(n') away from
 * the origin, so in F's plane, inside of F: at D / cos t, t the angle of n and n', so cos t >= D / h(n'). And F has a
 * disc of radius r about D n, so h(n') >= D cos t + r sin t. Both together: r sin t <= 2 error + D (1 - cos t) <= 4
 * error, t <= 2^-36. All its ends but epa.h's and SAT's, which comes after, are closed (dispatch.c); SAT's is exact.
 * So the features that the search names are F's, F is strict for it, too, and both answer by F's formula. Its hi is
 * NEAR_DEPTH_WIDTHS errors above its lo, which holds what either of them has proven. */
#ifndef COLLIDED_NARROW_POLYTOPE_DEPTH_H
#define COLLIDED_NARROW_POLYTOPE_DEPTH_H

#include "gjk.h"

/* True when both cores are points, segments, boxes or hulls. */
bool polytope_depth_applies(const unit_pair *p);

/* `start`: where gjk_distance ended. False: the simplex holds no tetrahedron, or the surface got slivers, folds or too
 * many points: epa_depth has to answer, *out is as if nothing had been tried but for the count of iterations. */
bool polytope_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* For two hulls that lie deep in each other, without GJK: from the octahedron of six support points, if it holds the
 * origin. False: they do not, or it does not, or as above; *out counts for nothing. */
bool polytope_depth_at_once(const unit_pair *p, const narrow_goal *goal, span *out);

/* The answer of a search from nothing, to the bit, by the surface in p->shell; it is kept up. False: that cannot be
 * told, and *out counts for nothing. `nearest`: the facet that won before; nothing is believed of it. */
bool polytope_depth_again(const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, span *out);

/* The same in registers of 32 or of 16 bytes, for tests: `wide` only where lanes_wide() (lanes.h). */
bool polytope_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

#endif
