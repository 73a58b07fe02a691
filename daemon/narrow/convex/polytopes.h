/* polytopes: methods that use the vertices, edges and facets of hulls: separating axes, a quick search for a gap or an
 * overlap, and the facets of the difference of two small hulls. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_POLYTOPES_H
#define COLLIDED_NARROW_CONVEX_POLYTOPES_H

#include "narrow/pair/unit_pair.h"

/* ==== separating axes ==== */

/* The depth of two overlapping polytopes, one a hull, exactly: least overlap over all candidate axes.
 *
 * The facets of B - A have the normals of A's faces, of B's faces, or the cross product of an edge of each, so the
 * least overlap over those is the depth. Points, segments and boxes count as boxes with three axes of their own; hulls
 * give their faces, and pairs of edges whose arcs cross on the Gauss map (Gregorius, "The Separating Axis Test", 2013).
 * Each candidate that may win is measured by support points of both, so every answer is a certificate. */

/* True when both are points, segments, boxes or hulls with faces, and the edge pairs are few enough. */
bool sat_applies(const unit_pair *p);

/* The same for two hulls with faces. With more pairs of edges the expanding polytope is quicker. */
#define SAT_EDGE_PAIRS_MAX (1u << 20)
static inline bool sat_affords(const hull *a, const hull *b)
{
    return (uint64_t)a->edge_count * b->edge_count <= SAT_EDGE_PAIRS_MAX;
}

/* True when there are at most fifteen axes: for boxes, segments and points. */
bool sat_is_quick(const unit_pair *p);

/* For a hull and another. out->lo = the greatest separation (negative: minus the depth), out->axis its axis. Fills lo,
 * hi, axis, iterations. */
void sat_depth(const unit_pair *p, span *out);

/* ==== a quick search for the features of hulls ==== */

/* Proposes where two hulls are nearest, or where they overlap, by a search without proofs.
 *
 * Gilbert, Johnson, Keerthi 1988, as gjk.h, but for what gjk.h proves: here are no bounds, no witnesses and no care for
 * rounding. What is proposed is worth nothing until near_features_span has proven it; and if that does, it is the
 * answer of any search, to the bit (features.h). Of four corners it is asked of each facet whether it has the
 * origin on its inner side (polytope_depth.h). */

typedef enum hull_seek_end {
    HULL_SEEK_PROPOSES, /* *out are the features */
    HULL_SEEK_APART,    /* they are apart, except for rounding; no features are known */
    HULL_SEEK_INSIDE,   /* *holds has four corners of B - A with the origin between them */
    HULL_SEEK_UNKNOWN
} hull_seek_end;

typedef struct hull_corners { /* by the vertices that they are made of (box_corner) */
    uint16_t a[4], b[4];
} hull_corners;

/* Adds a vertex to an ascending set of up to four. */
static inline void hull_features_include(uint32_t vertex, uint16_t *set, uint8_t *count)
{
    uint8_t at = *count;
    for (uint8_t i = 0; i < *count; i++)
        if (set[i] == vertex) return;
    for (; at > 0 && set[at - 1] > vertex; at--) set[at] = set[at - 1];
    set[at] = (uint16_t)vertex;
    ++*count;
}

enum { HULL_SEEK_ON = 1 << 20 }; /* without a limit of axes */

/* For two hulls of up to HULL_SCAN_MAX vertices, or a box and such a hull. The search gives up after `patience` axes
 * unless the shapes are apart along one of them. Unless `proposes` is set, it ends as soon as they are apart. */
hull_seek_end hull_seek(const unit_pair *p, int patience, bool proposes, narrow_features *out, hull_corners *holds);

/* ==== the axes of small hulls ==== */

/* The depth of two small hulls by the separating axes above, most of which are ruled out unseen.
 *
 * For hulls that both have a map (geom/hull_map.h). The heights of all faces of the one over all vertices of the other
 * are worked out side by side in single precision; the least of them bounds the depth from above. Along the arc of an
 * edge, from a face's normal n0 to its neighbour's n1, B - A reaches at least as far as the vertex that it reaches
 * farthest with at n0, and as the one at n1. w.n of a point w is concave along an arc wherever it is positive; so the
 * greater of the two is least at the ends of the arc, or where they are equal. Where that is above the bound, no facet
 * of the arc is the nearest. Of the arcs that are left (a tenth, about), each of A is tried with each of B, in doubles.
 *
 * What is answered: F (features.h) is strict, and all other facets of B - A are more than NEAR_DEPTH_MARGIN
 * farther away than F, so that a search from nothing finds F (polytope_depth.h), and the formula of F gives its bits.
 * Where that cannot be decided, nothing is answered, and the search follows. So neither single precision, nor its
 * width, nor what a pair remembers changes any bit of an answer.
 *
 * Rounding: a height in single precision errs by 8 * 2^-24 of the size, and by 2^-18 of itself, for the vertex it is of
 * stands in its last bits. With heights that err by e, the bound of an arc errs by e / c, c the cosine of half the
 * arc; arcs so long that c < 1/4 are always left. All that is below 2^-15 of the size, SLACK is 2^-14. What is left is
 * worked out in doubles: the normals of the map are off by 2^-34, heights along edges' axes by 2^-32 of the size or
 * nothing is answered; and twice NEAR_DEPTH_MARGIN is asked for, 2^-29.  About 25 kB on the stack. */

bool hull_axes_apply(const unit_pair *p);

/* Are the hulls apart along the line between their origins? Most hulls that are apart are, and need no depth. */
bool hull_axes_parted(const unit_pair *p);

/* For goals that near_features_reach_depths accepts. If it returns false, this method cannot decide, and *out is not
 * valid. */
bool hull_axes_depth(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
