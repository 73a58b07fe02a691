/* curved: distances and depths of cores with rims, and of those that share an axis. Pure; any thread. */
#ifndef COLLIDED_NARROW_CURVED_CURVED_H
#define COLLIDED_NARROW_CURVED_CURVED_H

#include "narrow/convex/gjk.h"
#include "narrow/pair/unit_pair.h"
#include "pieces.h"

/* ==== distances ==== */

/* The distance of cores with rims, from where GJK has found out which way they are apart.
 *
 * GJK comes nearer to a rim by a constant factor a step. Its simplex tells on which pieces of B - A (pieces.h) the
 * nearest point is likely to be; Newton's method finds the axis that they have, a support point along it tells whether
 * a piece was missing. Both bounds are proved as GJK proves them: `lo` by that support point, `hi` by a point of each
 * core. */

/* GJK until it knows (GJK_TOUCH or GJK_INSIDE: as gjk_distance ends), then the descent; where that does not reach the
 * goal, GJK from the best axis. For pairs of which pieces_apply. `seed`: see gjk_distance. */
void descent_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);

/* The end of a search from nothing of bodies with rims (rim_features.h): *s is its bracket, unless it is the answer of
 * strict features already; it becomes that if there are any: then it holds them. */
void descent_settle_rims(const unit_pair *p, const narrow_goal *goal, span *s);

/* ==== depths ==== */

/* The depth of two overlapping cores of which one at least has a rim, by the expanding polytope with
 * domes, as epa.h, for the common case: few points, no slivers.
 *
 * What is proved and how is epa.h's: each direction tried bounds the depth from above, the nearest triangle of a closed
 * surface of points of B - A from below, and where rims would take thousands of triangles, domes (curved.h) say
 * that nothing behind a triangle is nearer. With domes some twenty points are enough, and the machine of surface.h is
 * quicker than epa.c's. Nothing is remembered from query to query. */

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

/* The same in registers of 32 or of 16 bytes, for tests: `wide` only where lanes_wide() (simd.h). */
bool curved_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* ==== about one axis ==== */

/* The depth of two cores that share their axis of revolution, where a whole ring of directions is equally deep
 * and a polytope grown from inside converges slowly. */

/* ---- inscribed ---- */

/* An upper bound of deep curved pairs by a ball in one core. B is no deeper in A than in A's ball: separation(A, B)
 * <= separation(ball in A, B) = signed distance of the ball's centre from B - its radius, and the distance of a
 * point has a formula. About one axis, or about one centre, many directions are equally deep, and a surface of
 * support points has to be refined along all of them; the ball touches them all at once. */

/* Is the centre of either core about on the other's axis? Else two directions are seldom equally deep. */
bool inscribed_promises(const unit_pair *p);

/* Narrows *s, of cores that overlap, from both sides where the ball of either is nearer to the truth. */
void inscribed_depth(const unit_pair *p, const narrow_goal *goal, span *s);

/* ---- coaxial ---- */

/* Narrows the bounds of overlapping cores, if they are capsules, cylinders or cones on one axis to within rounding. */
void coaxial_depth(const unit_pair *p, span *s);

#endif
