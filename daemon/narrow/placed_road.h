/* placed_road: balls, capsules and boxes against each other, and verdicts of two ellipsoids, in world axes: their
 * formulas need no frame of A, or get there by the matrices at hand; no quaternions are multiplied. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_PLACED_ROAD_H
#define COLLIDED_NARROW_PLACED_ROAD_H

#include "narrow.h"

/* The answer in world axes with the origin at A's, where it is as narrow as asked. Where not, narrow_query answers, if
 * there is a scratch; if there is none (NULL), false, and nothing is written that counts. Of balls the matrices are not
 * read. With the arguments of narrow_query_placed, so that a jump is all that leads here. */
typedef bool placed_road(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result);

/* narrow_query by the relative pose, turned to world axes. */
bool placed_by_relative_pose(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result);

/* short_road_boxes_apart, with the caller's scratch. */
struct box_pair;
bool placed_boxes_apart(const struct box_pair *x, double most, int face, const narrow_request *request,
    narrow_scratch *scratch, narrow_features *nearest, narrow_result *result);

/* What a shape is to the formulas. Other is all that none knows: shapes that stand for something else, too. */
enum { PLACED_BALL, PLACED_CAPSULE, PLACED_BOX, PLACED_ELLIPSOID, PLACED_OTHER, PLACED_KINDS };

/* With a shape of this kind as A, by the kind of B: the formula, or placed_by_relative_pose where there is none or they
 * are not in canonical order. */
typedef struct placed_row {
    placed_road *with[PLACED_KINDS];
} placed_row;

/* placed_balls.c; and wide: with registers of 32 bytes, for processors that have them (lanes.h). The same bits. */
placed_road two_balls_placed, two_balls_placed_wide, ball_and_box_placed, ball_and_box_placed_wide;
placed_road two_capsules_placed, two_capsules_placed_wide; /* placed_road.c, placed_balls_wide.c */

/* What answers for this pair: a formula, unless a manifold is asked for. */
static inline placed_road *placed_road_for(const narrow_placed *a, const narrow_placed *b, const narrow_request *r)
{
    bool plain = ((unsigned)r->engine | (r->facts & NARROW_MANIFOLD)) == 0;
    return plain ? a->row->with[b->kind] : placed_by_relative_pose;
}

#endif
