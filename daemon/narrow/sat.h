/* sat: the depth of two overlapping polytopes, one a hull, exactly: least overlap over all candidate axes.
 *
 * The facets of B - A have the normals of A's faces, of B's faces, or the cross product of an edge of each, so the
 * least overlap over those is the depth. Points, segments and boxes count as boxes with three axes of their own; hulls
 * give their faces, and pairs of edges whose arcs cross on the Gauss map (Gregorius, "The Separating Axis Test", 2013).
 * Each candidate that may win is measured by support points of both, so every answer is a certificate. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_SAT_H
#define COLLIDED_NARROW_SAT_H

#include "unit_pair.h"

/* True when both are points, segments, boxes or hulls with faces, and the edge pairs are few enough. */
bool sat_applies(const unit_pair *p);

/* The same of two hulls with faces. Beyond it all pairs of edges take too long for what they may gain over the
 * expanding polytope. */
#define SAT_EDGE_PAIRS_MAX (1u << 20)
static inline bool sat_affords(const hull *a, const hull *b)
{
    return (uint64_t)a->edge_count * b->edge_count <= SAT_EDGE_PAIRS_MAX;
}

/* True when there are at most fifteen axes: two boxes, or what counts as one. */
bool sat_is_quick(const unit_pair *p);

/* For a hull and another. out->lo = the greatest separation (negative: minus the depth), out->axis its axis. Fills lo,
 * hi, axis, iterations. */
void sat_depth(const unit_pair *p, span *out);

#endif
