/* features: the distance of two hulls, or of two boxes, by a formula of the features that they are nearest at
 * (bodies with rims: curved.h).
 *
 * A search may start anywhere and stop anywhere within its tolerance; so its last bits depend on its start. Here the
 * answer is made anew from the features alone, and it does not matter who named them: a search from nothing, or the
 * pair's own past.
 *
 * What a feature pair F is: vertices S_A of A and S_B of B (one and one, one and two, one and three, two and two); for
 * boxes, one of which may overlap a hull, the sides that the nearest points lie on. Its formula gives the unit normal n
 * of the plane, edge or pair of edges, the nearest points as weighted means of the vertices, lo = the least n.(b - a)
 * of the pair, hi = the points' distance. F is *strict* when
 *   1. every weight is above a margin, and edges and triangles are no slivers;
 *   2. every other vertex of A is lower along n, and every other one of B higher, by more than a margin (of boxes: n
 *      points out of each of the sides by more than a margin);
 *   3. lo is above a margin.
 *
 * At most one F is strict. The nearest points of two polytopes minimise a convex function, |b - a|^2, so 1 to 3 without
 * margins are sufficient for a minimum (Karush, Kuhn, Tucker); the vector b - a of least length is unique, and n is its
 * direction n*. By 2, S_A and S_B are all the vertices that are highest along n*, hence they are unique, too. The
 * margins are 2^-13 and more of the size, rounding in the formula is below 2^-30 (slivers are excluded): so an F that
 * passes in floating point is the one F that the exact points have.
 *
 * Whoever searches finds it. A bracket [lo, hi] with the axis n, from any search, has the angle to n* bounded by
 * angle^2
 * <= 2 (hi - lo) / hi. When hi - lo is below 2^-36 hi, that is below 2^-17, heights along n differ from those along n*
 * by less than half the margin of 2, and S_A and S_B are what is within half that margin of the top: read off by one
 * scan. A search that ends wider (none has been seen) has all features tried. So if some F is strict, the search
 * from nothing ends with F's formula, and so does whoever tests F first: the same function, of the same numbers. Where
 * no F is strict, the pair's past is of no use, and the search from nothing answers.
 *
 * A search from nothing may also end because it knows enough: a gap beyond what is asked. near_features_apply and the
 * test of hi in near_features_span exclude that, by the request and by F alone.
 *
 * Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_FEATURES_H
#define COLLIDED_NARROW_CONVEX_FEATURES_H

#include "narrow/pair/unit_pair.h"

/* Do features answer? They do for two hulls of up to HULL_SCAN_MAX vertices, two boxes, or a capsule and a box, if the
 * distance is asked for with a small tolerance. */
static inline bool features_are_of_boxes(const unit_pair *p)
{
    return (p->a.type == SHAPE_BOX || p->a.type == SHAPE_CAPSULE) && p->b.type == SHAPE_BOX;
}
bool near_features_apply(const unit_pair *p, const narrow_goal *goal);

/* As a share of the size. For a looser tolerance of boxes a search that stops early is quicker. */
#define NEAR_CLOSE_TOLERANCE 0x1p-16
static inline bool near_features_apply_to_boxes(const narrow_goal *goal, double size)
{
    return goal->near == -INFINITY && goal->tolerance <= NEAR_CLOSE_TOLERANCE * size;
}

bool near_features_scans(const shape *a, const shape *b); /* are both hulls of up to HULL_SCAN_MAX vertices? */

/* Do features answer for the depth? They do for a box and a hull, and for two hulls whose edges are few enough for
 * polytopes.h, if the tolerance is above a few roundings and up to ROUGH_TOLERANCE: with few facets no search ends much
 * sooner. */
bool near_features_reach_depths(const unit_pair *p, const narrow_goal *goal);

/* Answers if `f`, which is checked anew, is strict; else it returns false, and *out is not valid. With f->deep the
 * facet is strict only if all other facets of B - A are known to be farther away. */
bool near_features_span(const unit_pair *p, const narrow_goal *goal, const narrow_features *f, span *out);

/* ---- the features of either kind: hull_features.c, box_features.c, box_facing.h ---- */

/* As shares of the pair's size, unless a comment says otherwise. */
#define NEAR_LEAST_DISTANCE 0x1p-10
#define NEAR_LEAST_DEPTH 0x1p-16   /* far above all rounding, as polytope_depth.h needs it */
#define NEAR_HEIGHT_MARGIN 0x1p-15 /* all other vertices are lower by more than this */
#define NEAR_SINE_MARGIN 0x1p-13   /* between n and the sides of a box */
#define NEAR_WEIGHT_MARGIN 0x1p-13
#define NEAR_INSIDE 0x1p-12       /* for depths: how far the nearest point lies inside its facet of B - A */
#define NEAR_DEPTH_MARGIN 0x1p-30 /* for depths: all other facets of B - A are farther by more than this */
#define NEAR_DEPTH_WIDTHS 2 /* in errors: how far the bounds of a depth lie on either side of the facet's distance */
#define NEAR_NAMING_WIDTH 0x1p-36 /* of hi: bounds so close name the features */
#define NEAR_SLIVER2 0x1p-20 /* square of the least ratio: edge to size, height of a triangle to its longest edge */

/* A feature of a box: for each of its axes the side that the nearest point lies on, or that it lies between the two. */
enum { NEAR_BETWEEN, NEAR_HIGH, NEAR_LOW, NEAR_SIDES };

bool hull_features_span(const unit_pair *p, const narrow_features *f, span *out);
void hull_features_of(const minkowski *const *m, int count, narrow_features *out); /* the vertices they are made of */

/* The features of a facet of B - A by its corners, where the two shapes overlap. A may be a box. */
void hull_features_of_facet(const unit_pair *p, const minkowski *const *m, narrow_features *out);

static inline minkowski hull_pair_of(const unit_pair *p, uint32_t a, uint32_t b) /* of two vertices */
{
    minkowski m = {.vertex_a = a, .vertex_b = b};
    m.a = p->a.type == SHAPE_BOX ? box_corner(p->a.half, a) : vec_scale(hull_vertex(p->a.hull, a), p->scale);
    m.b_local = vec_scale(hull_vertex(p->b.hull, b), p->scale);
    m.b = transform_point(&p->b_in_a, m.b_local);
    m.w = vec_sub(m.b, m.a);
    return m;
}

bool hull_features_descend(const unit_pair *p, const narrow_features *from, narrow_features *out);
bool hull_features_along(const unit_pair *p, vec3 axis, narrow_features *out); /* on top to within half the margin */
uint32_t hull_features_count(const hull *h);                                   /* vertices, edges, triangles */
uint8_t hull_feature(const hull *h, uint32_t i, uint16_t vertex[3]);           /* how many vertices; 0: no triangle */

bool box_features_span(const unit_pair *p, const narrow_features *f, span *out);
void box_features_along(const unit_pair *p, vec3 axis, narrow_features *out);

#endif
