/* curved_depth: the depth of two overlapping cores of which one at least has a rim, by the expanding polytope with
 * domes, as epa.h, for the common case: few points, no slivers.
 *
 * What is proved and how is epa.h's: each direction tried bounds the depth from above, the nearest triangle of a closed
 * surface of points of B - A from below, and where rims would take thousands of triangles, domes (dome.h) say that
 * nothing behind a triangle is nearer. With domes some twenty points are enough, and the machine of surface.h is
 * quicker than epa.c's. Nothing is remembered from query to query. Pure; any thread. */
#ifndef COLLIDED_NARROW_CURVED_DEPTH_H
#define COLLIDED_NARROW_CURVED_DEPTH_H

#include "gjk.h"

/* For pairs of which pieces_apply. `start`: where gjk_distance ended. False: the simplex holds no tetrahedron, or the
 * surface got slivers, folds or too many points: epa_depth has to answer, *out is as if nothing had been tried but for
 * the count of iterations. */
bool curved_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* The same in registers of 32 or of 16 bytes, for tests: `wide` only where lanes_wide() (lanes.h). */
bool curved_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

#endif
