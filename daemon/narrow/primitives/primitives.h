/* primitives: spheres, capsules and boxes against each other, and verdicts of two ellipsoids, by formulas: the quickest
 * queries of all, and the most frequent. Pure; any thread. */
#ifndef COLLIDED_NARROW_PRIMITIVES_PRIMITIVES_H
#define COLLIDED_NARROW_PRIMITIVES_PRIMITIVES_H

#include "narrow/convex/epa.h"

/* Can a formula answer this request about a shape and this one, in canonical order? */
static inline bool primitives_apply(const shape *b, const narrow_request *r)
{
    return b->type <= SHAPE_ELLIPSOID && r->engine == NARROW_ENGINE_AUTO;
}

/* The answer in A's frame, as narrow_query gives it but for points of contact, where it is as narrow as asked. Where
 * not, false, and nothing is written that counts. The features by which the distance of two boxes was found are read
 * from `cache` and written to it; NULL: none are. Without a scratch (NULL) nothing is searched. */
bool primitives_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, epa_scratch *scratch, narrow_result *result);

/* The same in world axes, with the origin at A's: of a sphere or a capsule beside each other or a box. The poses are
 * not multiplied. */
bool primitives_answer_in_world(const shape *a, const pose *at_a, const shape *b, const pose *at_b,
    const narrow_request *request, narrow_result *result);

#endif
