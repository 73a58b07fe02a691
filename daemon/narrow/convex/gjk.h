/* gjk: the distance of two convex cores, bracketed by a duality gap.
 *
 * Gilbert, Johnson, Keerthi 1988, on B - A in A's frame. `lo` is the best support-plane separation seen, `hi` the least
 * |point of B - A| seen: both hold at every iteration, so it never fails, it only stops. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_GJK_H
#define COLLIDED_NARROW_CONVEX_GJK_H

#include "narrow/pair/unit_pair.h"

/* ==== the simplex ==== */

/* The point of the hull of up to four points that is nearest to the origin.
 *
 * A search of the sub-simplices that hold the newest point (the others were searched before it came); the least of the
 * valid candidates wins. Faces that surely cannot hold it are passed over, and one that surely does ends the search;
 * what rounding could blur (flat tetrahedra, slivers) is compared in full. Directions come from the
 * features (normal by a cross product, orthogonal to the edge), not from the nearest point, so that they stay accurate
 * when that point is close to the origin. */

typedef struct simplex {
    minkowski v[4];
    double weight[4]; /* of the nearest point: >= 0, sum 1 */
    int count;
} simplex;

typedef struct nearest_feature {
    vec3 point;  /* nearest to the origin: the weighted sum */
    double norm; /* |point| */
    vec3 axis;   /* unit, from the origin towards the feature that it lies on */
    bool inside; /* the origin is inside four points: point and axis are zero */
} nearest_feature;

/* Reduces *s to the feature on which the nearest point lies. s->v[count - 1] is the newest. */
nearest_feature simplex_reduce(simplex *s);

/* Not unit; counter-clockwise. The cross product of the two shortest edges: the longest carries the most rounding. */
static inline vec3 triangle_normal(vec3 a, vec3 b, vec3 c)
{
    vec3 ab = vec_sub(b, a), bc = vec_sub(c, b), ca = vec_sub(a, c);
    double l_ab = vec_norm2(ab), l_bc = vec_norm2(bc), l_ca = vec_norm2(ca);
    if (l_ab >= l_bc && l_ab >= l_ca) return vec_cross(bc, ca);
    return l_bc >= l_ca ? vec_cross(ca, ab) : vec_cross(ab, bc);
}

/* The nearest point of a triangle alone; weight[3] gets its coordinates, *normal the triangle's own (unit; p0, p1, p2
 * counter-clockwise), *axis the unit direction of the feature it lies on (the normal when inside it). Its distance. */
double triangle_nearest(vec3 p0, vec3 p1, vec3 p2, double weight[3], vec3 *normal, vec3 *axis);

/* Six times the volume of the tetrahedron of the origin and three points; positive when p0, p1, p2 are
 * counter-clockwise seen from the side on which the origin is not. In double-double: there is no doubt about its sign.
 */
double origin_volume(vec3 p0, vec3 p1, vec3 p2);

/* The two witness points that belong to the weights. */
void simplex_witness(const simplex *s, vec3 *point_a, vec3 *point_b);

/* Is that point of B - A one of its corners? */
static inline bool simplex_has(const simplex *s, vec3 w)
{
    for (int i = 0; i < s->count; i++)
        if (s->v[i].w.x == w.x && s->v[i].w.y == w.y && s->v[i].w.z == w.z) return true;
    return false;
}

/* Its nearest point, at that distance, becomes the upper bound. */
static inline void simplex_lower_upper(const simplex *s, double distance, span *best)
{
    best->hi = distance;
    simplex_witness(s, &best->point_a, &best->point_b);
}

/* ==== the search ==== */

typedef enum gjk_state {
    GJK_APART, /* the span is the distance (or enough for the goal) */
    GJK_TOUCH, /* the origin is within rounding of the simplex, or no progress could be made: depth decides */
    GJK_INSIDE /* the simplex has four points and holds the origin */
} gjk_state;

typedef struct gjk_result {
    gjk_state state;
    span span;
    simplex simplex;
} gjk_result;

/* `seed`: the first axis to try, unit, or zero for the line of the centres. */
void gjk_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);

/* Narrows the bracket *s as far as doubles let a search, from its axis on. */
typedef void gjk_search(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);
void gjk_narrow_down(gjk_search *by, const unit_pair *p, const narrow_goal *goal, span *s);

/* ---- rough depth ---- */

/* That two cores overlap, and about how deep, from where GJK ended: for who asks for no more. */

/* True when the bounds are enough for the goal: GJK's tetrahedron holds the origin, so that the ball up to its nearest
 * face is in B - A; and each face's normal is an axis along which the overlap ends. The points are the deepest along
 * the axis. False: *out is as it was. */
bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* ---- moved apart ---- */

/* A better axis for two cores that overlap by almost nothing, where a search for their depth ended early: the origin
 * lies on the surface of B - A, and a polytope grown there is all slivers. */

/* Raises the lower bound of a pair whose interval is wide, and replaces its axis, if an axis is found that proves more.
 */
void moved_apart_raise(const unit_pair *p, span *s);

/* ==== points that face each other ==== */

/* The points that an answer names when two cores overlap: the deepest along the axis. */

/* Where the cores touch once B is moved apart along s->axis by the depth: points that face each other. */
void witness_apart(const unit_pair *p, span *s);

/* Keeps s->point_a and s->point_b if they lie on the support planes of their cores along s->axis and face each other;
 * else takes witness_apart's, or where even those fall short, a support point of each. */
void witness_deepest(const unit_pair *p, span *s);

/* Writes points on the support planes that face each other, found by a formula; of an axis that is not that
 * of the least depth there need not be any. False: none are known, and the points are `top`, the support points. */
bool witness_facing(const unit_pair *p, const minkowski *top, span *s);

#endif
