/* placed_road: balls, capsules and boxes against each other, and verdicts of two ellipsoids, in world axes: their
 * formulas need no frame of A, or get there by the matrices at hand; no quaternions are multiplied. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_PLACED_ROAD_H
#define COLLIDED_NARROW_PLACED_ROAD_H

#include "narrow.h"

struct placed_row;
/* A shape where it stands, with all that is the same for each pair that it is in. What balls are asked for comes first:
 * at an address divisible by 64 one cache line has it. A vector is read as four doubles: another follows each. */
typedef struct narrow_placed {
    const struct placed_row *row; /* the formulas that know it, and its column among them: below */
    uint32_t kind;
    bool unit;     /* the columns of `turn` may be told as axes: their squares are 1 but for 8 u */
    double radius; /* the shape's, as is half */
    pose at;
    vec3 half;
    mat3 turn;    /* of at.q */
    double reach; /* shape_reach */
    const shape *shape;
} narrow_placed;

narrow_placed narrow_placed_at(const shape *s, pose at);

/* The answer in world axes with the origin at A's, where it is as narrow as asked. Where not, false, and nothing is
 * written that counts. Of balls the matrices are not read. All have the same arguments, so that a jump is all that
 * leads here; without a scratch (NULL) nothing is searched. */
typedef bool placed_road(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result);

/* short_road_boxes_apart, with the caller's scratch. */
struct box_pair;
bool placed_boxes_apart(const struct box_pair *x, double most, int face, const narrow_request *request,
    narrow_scratch *scratch, narrow_features *nearest, narrow_result *result);

/* What a shape is to the formulas. Other is all that none knows: shapes that stand for something else, too. */
enum { PLACED_BALL, PLACED_CAPSULE, PLACED_BOX, PLACED_ELLIPSOID, PLACED_OTHER, PLACED_KINDS };

/* With a shape of this kind as A, by the kind of B: the formula, or one that answers nothing. */
typedef struct placed_row {
    placed_road *with[PLACED_KINDS];
} placed_row;

/* placed_balls.c; and wide: with registers of 32 bytes, for processors that have them (lanes.h). The same bits. */
placed_road two_balls_placed, two_balls_placed_wide, ball_and_box_placed, ball_and_box_placed_wide;
placed_road two_capsules_placed, two_capsules_placed_wide; /* placed_road.c, placed_balls_wide.c */

/* Can a formula answer this request? */
static inline bool placed_road_applies(const narrow_request *r)
{
    return ((unsigned)r->engine | (r->facts & NARROW_MANIFOLD)) == 0;
}

/* The answer of a formula in A's frame, with the origin at A's, as narrow_query gives it. */
bool placed_road_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result);

#endif
