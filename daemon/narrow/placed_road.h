/* placed_road: balls against balls, capsules and boxes, and two capsules, in world axes: their formulas need no frame
 * of A, so that no rotations are multiplied. Pure; any thread. */
#ifndef COLLIDED_NARROW_PLACED_ROAD_H
#define COLLIDED_NARROW_PLACED_ROAD_H

#include "narrow.h"

/* The answer in world axes with the origin at A's, where it is as narrow as asked; false otherwise, and then nothing is
 * written that counts. Of balls the matrices are not read. */
typedef bool placed_road(const shape *a, const narrow_placement *at_a, const shape *b, const narrow_placement *at_b,
    const narrow_request *request, narrow_result *out);

/* By the two types; NULL: none, or not in canonical order. */
enum { PLACED_TYPES = SHAPE_BOX + 1 };
extern placed_road *const placed_roads[PLACED_TYPES][PLACED_TYPES];

/* What answers for this pair, if a formula in doubles may: no manifold is asked for, not every bit, and the shapes are
 * all there is. */
static inline placed_road *placed_road_for(const shape *a, const shape *b, const narrow_request *r)
{
    bool known = (unsigned)a->type < PLACED_TYPES && (unsigned)b->type < PLACED_TYPES;
    bool plain = r->engine == NARROW_ENGINE_AUTO && !(r->facts & NARROW_MANIFOLD) && r->tolerance > 0;
    return known && plain && !(a->deviation + b->deviation > 0) ? placed_roads[a->type][b->type] : NULL;
}

#endif
