/* curved: distances and depths of cores with rims, and of those that share an axis. Pure; any thread. */
#ifndef COLLIDED_NARROW_CURVED_CURVED_H
#define COLLIDED_NARROW_CURVED_CURVED_H

#include "narrow/convex/gjk.h"
#include "narrow/pair/unit_pair.h"
#include "pieces.h"

/* ==== distances ==== */

/* The distance of cores with rims, once GJK has found about where they are nearest.
 *
 * GJK comes nearer to a rim by a constant factor a step. Its simplex shows on which pieces of B - A (pieces.h) the
 * nearest point is likely to be; Newton's method finds the axis that they have, a support point along it shows whether
 * a piece was missing. Both bounds are proved as GJK proves them: `lo` by that support point, `hi` by a point of each
 * core. */

/* Searches with GJK until it knows the pieces, or ends in GJK_TOUCH or GJK_INSIDE; then by the descent; and, if that
 * does not reach the goal, with GJK from the best axis. It needs pieces_apply. For `seed` see gjk_distance. */
void descent_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);

/* Ends a search for bodies with rims. *s is the search's interval, or the answer of strict features already. If the
 * pair has strict features, *s becomes their answer, and holds them. */
void descent_settle_rims(const unit_pair *p, const narrow_goal *goal, span *s);

/* ==== depths ==== */

/* A dome is a cone of directions in which two overlapping cores are certainly no shallower than at its middle.
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

/* Finds the dome about a local minimum near the unit direction `near`. `depth` may fall short of the best possible
 * bound by `close`. Returns false if there is no dome, or if none was found. */
bool dome_raise(const unit_pair *p, const bundle *pieces, vec3 near, double close, dome *out);

/* Is every direction that leaves through the triangle `w`, and along which none of its corners is as high as `depth`
 * (at most the dome's), in the dome? Then nothing behind that triangle is nearer than `depth`. `nearest` is the
 * point of the triangle nearest to the origin, which rules out most triangles. */
bool dome_covers(const dome *d, const vec3 w[3], vec3 nearest, double depth, double size);

/* ==== about one axis ==== */

/* The depth of two cores that share their axis of revolution, where a whole ring of directions is equally deep
 * and a polytope grown from inside converges slowly. */

/* ---- inscribed ---- */

/* An upper bound of deep curved pairs by a ball in one core. B is no deeper in A than in A's ball: separation(A, B)
 * <= separation(ball in A, B) = signed distance of the ball's centre from B - its radius, and the distance of a
 * point has a formula. About one axis, or about one centre, many directions are equally deep, and a surface of
 * support points has to be refined along all of them; the ball touches them all at once. */

/* Does the centre of either core lie near the other's axis? If not, two directions are seldom equally deep. */
bool inscribed_promises(const unit_pair *p);

/* Narrows the interval *s of overlapping cores from both sides, if the ball of either core gives a better bound. */
void inscribed_depth(const unit_pair *p, const narrow_goal *goal, span *s);

/* ---- coaxial ---- */

/* Narrows the bounds of overlapping cores, if they are capsules, cylinders or cones on one axis to within rounding. */
void coaxial_depth(const unit_pair *p, span *s);

/* ==== features of rims ==== */

/* The distance of a cylinder or a cone from a box, a capsule, a cylinder or a cone, by the features that
 * they are nearest at: features.h for bodies with rims.
 *
 * A feature is a corner, an edge or a face of a box (of a capsule: an end, or its segment), a rim, a flat end, an apex
 * or the side of a body of revolution. What a pair of features F means: the unit axis n along which they are
 * farthest apart, and the points that face each other there.
 *   - A face or a flat end: n is its normal; the other is a corner, an apex or the point of a rim.
 *   - Otherwise Newton's method finds n: every feature is one disc or two (an edge two points, a side the rims at its
 *     ends), points are discs without a radius; n is where all of them are equally near and the gap is greatest. The
 *     gap's second derivative is at most -gap in every direction, so that a step is always defined.
 *
 * Newton's last bits depend on its start. So the last steps start from a place that depends on F and n alone: the
 * centre of the cell of a grid of directions, of 2^-16, that n is in. F is *strict* in a cell when
 *   1. the points lie inside of their edges, sides and faces by a margin;
 *   2. n points out of all other faces of the box by a margin, away from the ends, sides and rims that are not of F,
 *      and is not along the axis of a rim of F, by a margin;
 *   3. the gap is above a margin, and its bounds are closed to rounding;
 *   4. from the cell's centre the steps end at a place where what is left of the gradient bounds the next step by
 *      2^-30, and which lies in the cell, 2^-26 away from its border.
 *
 * By 1 to 3 at most one F is strict, as in features.h; by 4 it is so in one cell only: places that are within
 * 2^-30 of n* cannot lie 2^-26 inside of two cells. So it does not matter who proposes F and where Newton begins, a
 * search from nothing or the pair's past: what passes has the one F, the one cell, and these bits.
 *
 * Whoever searches finds it: the angle between n* and the axis of a bracket is bounded by angle^2 <= 2 (hi - lo) / hi.
 * When it is below half of the least margin of directions, 2^-14, one feature of each is left; of a search that ends
 * wider all that are left are tried. Where no F is strict (parallel faces), the search from nothing answers.
 */

/* As a share of the size. For a looser tolerance a search that stops early is quicker. */
#define RIM_CLOSE_TOLERANCE 0x1p-9

/* Do features of rims answer? They do if B has a rim, A is no hull, and the distance is asked for with a small
 * tolerance. */
static inline bool rim_features_apply(const unit_pair *p, const narrow_goal *goal)
{
    bool kinds = shape_has_rim(&p->b) && p->a.type >= SHAPE_CAPSULE && p->a.type <= SHAPE_CONE;
    return kinds && goal->near == -INFINITY && goal->tolerance <= RIM_CLOSE_TOLERANCE * p->size;
}

/* Answers from the features that the pair remembers, beginning with `axis`. Both are checked anew. */
bool rim_features_recall(
    const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, vec3 axis, span *out);

/* During a search: *s is its interval. If the features on which its points lie are strict, *s becomes their answer. */
bool rim_features_at(const unit_pair *p, const narrow_goal *goal, span *s);

/* At the end of a search (descent_settle_rims): the answer of the features on which the points of *s lie. If the
 * interval is rough, and a point of a rim lies between others, an end may be taken for flat that is not. */
bool rim_features_find_at(const unit_pair *p, const narrow_goal *goal, const span *s, span *out);

/* The greatest angle between the bracket's axis and n*: its square is at most 2 (hi - lo) / hi. */
double rim_features_angle(const span *s);

/* The answer of any features that the interval does not rule out. If the angle is below half of the least margin of
 * directions, that is at most one feature of each shape. */
bool rim_features_find_along(const unit_pair *p, const narrow_goal *goal, const span *s, span *out);

#endif
