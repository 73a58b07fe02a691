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
 * facet of B - A is nearer. It is made anew in each pose, but from the surface that was grown in the pose before, whose
 * points are placed anew. It need not be convex any more; what is asked is that each facet has the origin strictly on
 * its inner side. Then every direction from the origin meets it: a closed surface whose facets all turn in the same
 * sense round the origin winds round it. Growing keeps that: what is replaced and what replaces it bound the tetrahedra
 * between the facets that see the new point and the point, all of which lie on the outer sides of those facets, so not
 * one holds the origin. As every direction meets the surface at its least distance or beyond, and its points are B -
 * A's, the ball of that radius is in B - A. Facets that have come too near are grown on; where a facet is a sliver or
 * would have the origin outside, it is given up.
 *
 * Why that gives the bits of a search from nothing. F is a facet of B - A, strict as features.h says but for 3, of
 * which the nearest point is inside by r >= NEAR_INSIDE; D its distance, at least NEAR_LEAST_DEPTH, n its normal;
 * the pair's size is 1. What is proven is that all facets of the surface but those in F's plane are at least D +
 * NEAR_DEPTH_MARGIN away; and D is greater than the tolerance (near_features_span sees to that). Claim: a search from
 * nothing ends with an axis within 2^-17 of n, and so reads F off it.
 * Proof: GJK, which is asked for the tolerance and no more, does not end it: apart with closed bounds means lo < 0 <=
 * hi <= lo + tolerance, where lo <= error - D. So the bounds end closed to `error` (2^-49): the searches here are asked
 * to, and where they and epa.h give up, the axes of polytopes.h, which are all there are, come after (dispatch.c; pairs
 * too large for polytopes.h remember nothing). So the axis n' has a height h(n') <= D + 2 error. The ray along n'
 * leaves the surface at h(n') at most, so in F's plane, inside of F: at D / cos t, t the angle of n and n'; hence D /
 * cos t <= D + 2 error. And F has a disc of radius r about D n: h(n') >= D cos t + r sin t. Together r sin t <= 2 error
 * + D (1 - cos t) <= 4 error, so t <= 2^-34. The same holds of any other facet: none is within error of F, so that the
 * winner of a search, if it is strict, is F. Both answer by F's formula; its hi is NEAR_DEPTH_WIDTHS errors above what
 * it finds, which holds what either of them has proven, and its lo is as far below, so that the middle is what it
 * finds.
 */
#ifndef COLLIDED_NARROW_CONVEX_POLYTOPE_DEPTH_H
#define COLLIDED_NARROW_CONVEX_POLYTOPE_DEPTH_H

#include "gjk.h"
#include "polytopes.h"

/* True when both cores are points, segments, boxes or hulls. */
bool polytope_depth_applies(const unit_pair *p);

/* Searches the depth from the simplex with which gjk_distance ended. It returns false if that is no tetrahedron, or if
 * the surface gets slivers, folds or too many points: then epa_depth has to answer, and only the count of iterations in
 * *out has changed. */
bool polytope_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* The same from four corners that hull_seek found. It also returns false if the overlap is too shallow for this method;
 * then *out is not valid. */
bool polytope_depth_from(const unit_pair *p, const narrow_goal *goal, const hull_corners *holds, span *out);

/* Answers by the surface in p->shell with the bits of a search without it, and updates that surface. `nearest` is the
 * facet that was the nearest before; it is checked anew. It returns false if this cannot decide; then *out is not
 * valid. */
bool polytope_depth_again(const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, span *out);

/* polytope_depth in registers of 32 or of 16 bytes, for tests. `wide` needs lanes_wide() (simd.h). */
bool polytope_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

#endif
