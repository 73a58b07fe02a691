/* polytope_depth: the depth of two overlapping polytopes by the expanding polytope, as epa.h, for the common case: few
 * vertices, no slivers.
 *
 * The points of two polytopes' difference are finitely many, so the search ends on a facet of it, not close to one.
 * That allows a smaller machine than epa.c's: at most 64 points; facets in columns, looked at side by side; which facet
 * is left of a directed edge stands in a table. The proof of both bounds is that of epa.h.
 *
 * Nothing is remembered from query to query. What is costly is the proof that no other facet is nearer, and that has to
 * be made anew however good a guess the last facet is. Pure; any thread. */
#ifndef COLLIDED_NARROW_POLYTOPE_DEPTH_H
#define COLLIDED_NARROW_POLYTOPE_DEPTH_H

#include "gjk.h"

/* True when both cores are points, segments, boxes or hulls. */
bool polytope_depth_applies(const unit_pair *p);

/* `start`: where gjk_distance ended. False: the simplex holds no tetrahedron, or the surface got slivers, folds or too
 * many points: epa_depth has to answer, *out is as if nothing had been tried but for the count of iterations. */
bool polytope_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* The same in registers of 32 or of 16 bytes, for tests: `wide` only where lanes_wide() (lanes.h). */
bool polytope_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

#endif
