/* expand: the depth of the origin in a convex set that is known by its support points. */
#ifndef COLLIDED_TESTS_ORACLE_EXPAND_H
#define COLLIDED_TESTS_ORACLE_EXPAND_H

#include "oracle.h"

/* The point of the set that is lowest along n. */
typedef qvec expand_lowest(const oracle_body *a, const oracle_body *b, qvec n);

/* [lo, hi] holds the depth: the least distance from the origin to the boundary of W, negative when it is outside (then
 * -hi is a lower bound of the distance). `axis` is the unit direction along which hi was found: f(axis) = -hi. false
 * when W is flat. `steps`: how often the inner polytope is grown at most; the bounds hold after any number of them. */
enum { EXPAND_STEPS_MAX = 600 };
bool expand_depth(
    const oracle_body *a, const oracle_body *b, expand_lowest *lowest, int steps, quad *lo, quad *hi, qvec *axis);

#endif
