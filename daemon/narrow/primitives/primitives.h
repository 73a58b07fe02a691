/* primitives: spheres, capsules and boxes against each other, and verdicts of two ellipsoids, by formulas: the quickest
 * queries of all, and the most frequent. Pure; any thread. */
#ifndef COLLIDED_NARROW_PRIMITIVES_PRIMITIVES_H
#define COLLIDED_NARROW_PRIMITIVES_PRIMITIVES_H

#include "narrow/convex/epa.h"

/* Gives the answer of narrow_query in A's frame, without contact points, if a formula makes it as narrow as asked. If
 * it returns false, *result is not valid. The features that give the distance of two boxes are read from `cache` and
 * written to it, unless it is NULL. Without scratch memory (NULL) nothing is searched. */
bool primitives_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, epa_scratch *scratch, narrow_result *result);

/* The same in world axes with the origin at A's centre, for spheres and capsules with each other or with a box. The two
 * poses are not multiplied. */
bool primitives_answer_in_world(const shape *a, const pose *at_a, const shape *b, const pose *at_b,
    const narrow_request *request, narrow_result *result);

#endif
