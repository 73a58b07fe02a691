/* curved_depth: the depth of two overlapping cores of which one at least has a rim, by the expanding polytope with
 * domes, as epa.h, for the common case: few points, no slivers.
 *
 * What is proved and how is epa.h's: each direction tried bounds the depth from above, the nearest triangle of a closed
 * surface of points of B - A from below, and where rims would take thousands of triangles, domes (curved_depth.h) say
 * that nothing behind a triangle is nearer. With domes some twenty points are enough, and the machine of surface.h is
 * quicker than epa.c's. Nothing is remembered from query to query. Pure; any thread. */
#ifndef COLLIDED_NARROW_CURVED_DEPTH_H
#define COLLIDED_NARROW_CURVED_DEPTH_H

#include "gjk.h"
#include "pieces.h"

/* ---- dome ---- */

/* A cone of directions in which two overlapping cores are surely no shallower than at its middle.
 *
 * Where a cylinder or a cone is met at its rim, B - A is curved, and triangles inscribed in it come to within eps only
 * when they are sqrt(eps) small. A dome takes the curved pieces (pieces.h) as they are: about a least of the greatest
 * of some of them it bounds their second derivatives over a whole cone of directions (the second-order sufficient
 * condition of a minimax). All of this is of support functions of parts of B - A, so it is a lower bound of its support
 * function h, the overlap of the support intervals, whether or not the pieces are the right ones.
 *
 * Lengths between cores, directions from the origin outward (minus the axis of a span). */

typedef struct dome {
    vec3 direction;        /* unit; its middle */
    double cosine;         /* of the angle from there to its rim; > 0 */
    double depth;          /* h(n) is not less for any unit n of the dome; > 0 */
    vec3 point_a, point_b; /* the deepest points at `direction` */
} dome;

/* The dome about a local least near the unit direction `near`. `close`: by which `depth` may fall short of what it
 * might be. False: there is none, or it was not found. */
bool dome_raise(const unit_pair *p, const bundle *pieces, vec3 near, double close, dome *out);

/* Is every direction that leaves through the triangle `w`, and along which none of its corners is as high as `depth`
 * (at most the dome's), in the dome? Then nothing behind that triangle is nearer than `depth`. `nearest`: its point
 * nearest to the origin, by which most are refused. */
bool dome_covers(const dome *d, const vec3 w[3], vec3 nearest, double depth, double size);

/* ---- curved depth ---- */

/* For pairs of which pieces_apply. `start`: where gjk_distance ended. False: the simplex holds no tetrahedron, or the
 * surface got slivers, folds or too many points: epa_depth has to answer, *out is as if nothing had been tried but for
 * the count of iterations. */
bool curved_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* The same in registers of 32 or of 16 bytes, for tests: `wide` only where lanes_wide() (lanes.h). */
bool curved_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

#endif
