/* gjk: the distance of two convex cores, bracketed by a duality gap.
 *
 * Gilbert, Johnson, Keerthi 1988, on B - A in A's frame. `lo` is the best support-plane separation seen, `hi` the least
 * |point of B - A| seen. Both hold at every iteration, so the search never fails; it only stops. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_GJK_H
#define COLLIDED_NARROW_CONVEX_GJK_H

#include "narrow/pair/unit_pair.h"

/* ==== the simplex ==== */

/* The point of the hull of up to four points that is nearest to the origin.
 *
 * A search of the sub-simplices that contain the newest point (the others were searched before); the least of the
 * valid candidates wins. Faces that certainly cannot contain it are skipped, and one that certainly does ends the
 * search; what rounding could blur (flat tetrahedra, slivers) is compared in full. Directions come from the features
 * (normal by a cross product, orthogonal to the edge), not from the nearest point, so that they stay accurate when that
 * point is close to the origin. */

typedef struct simplex {
    minkowski v[4];
    double weight[4]; /* of the nearest point: >= 0, sum 1 */
    int count;
} simplex;

typedef struct nearest_feature {
    vec3 point;  /* nearest to the origin: the weighted sum */
    double norm; /* |point| */
    vec3 axis;   /* unit, from the origin towards the feature on which the point lies */
    bool inside; /* the origin is inside four points: point and axis are zero */
} nearest_feature;

/* Reduces *s to the feature on which the nearest point lies. s->v[count - 1] is the newest. */
nearest_feature simplex_reduce(simplex *s);

/* The normal of a triangle, counter-clockwise, not unit. It is the cross product of the two shortest edges, because the
 * longest carries the most rounding. */
static inline vec3 triangle_normal(vec3 a, vec3 b, vec3 c)
{
    vec3 ab = vec_sub(b, a), bc = vec_sub(c, b), ca = vec_sub(a, c);
    double l_ab = vec_norm2(ab), l_bc = vec_norm2(bc), l_ca = vec_norm2(ca);
    if (l_ab >= l_bc && l_ab >= l_ca) return vec_cross(bc, ca);
    return l_bc >= l_ca ? vec_cross(ca, ab) : vec_cross(ab, bc);
}

/* Returns the distance of a triangle from the origin. weight[3] gets the coordinates of its nearest point, *normal the
 * triangle's unit normal (p0, p1, p2 are counter-clockwise), *axis the unit direction of the feature on which the point
 * lies, which is the normal if it lies inside. */
double triangle_nearest(vec3 p0, vec3 p1, vec3 p2, double weight[3], vec3 *normal, vec3 *axis);

/* Six times the volume of the tetrahedron of the origin and three points; positive when p0, p1, p2 are
 * counter-clockwise seen from the side opposite to the origin. It is computed in double-double, so that its sign is
 * certain. */
double origin_volume(vec3 p0, vec3 p1, vec3 p2);

/* The two witness points that belong to the weights. */
void simplex_witness(const simplex *s, vec3 *point_a, vec3 *point_b);

/* Is this point of B - A a corner of the simplex? */
static inline bool simplex_has(const simplex *s, vec3 w)
{
    for (int i = 0; i < s->count; i++)
        if (s->v[i].w.x == w.x && s->v[i].w.y == w.y && s->v[i].w.z == w.z) return true;
    return false;
}

/* Makes the nearest point of the simplex, at that distance, the upper bound. */
static inline void simplex_lower_upper(const simplex *s, double distance, span *best)
{
    best->hi = distance;
    simplex_witness(s, &best->point_a, &best->point_b);
}

/* ==== the search ==== */

typedef enum gjk_state {
    GJK_APART, /* the interval is the distance, or enough for the goal */
    GJK_TOUCH, /* the origin is within rounding of the simplex, or no progress could be made: depth decides */
    GJK_INSIDE /* the simplex has four points and holds the origin */
} gjk_state;

typedef struct gjk_result {
    gjk_state state;
    span span;
    simplex simplex;
} gjk_result;

/* Searches the distance. `seed` is the first axis, unit, or zero for the line between the centres. */
void gjk_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);

/* Searches on from the axis of *s, and narrows its interval as far as doubles allow. */
typedef void gjk_search(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out);
void gjk_narrow_down(gjk_search *by, const unit_pair *p, const narrow_goal *goal, span *s);

/* ---- rough depth ---- */

/* For requests that need no more: two cores overlap, and about how deep, as GJK's last simplex shows. */

/* GJK's tetrahedron contains the origin, so the ball up to its nearest face is in B - A; and along each face's normal
 * the overlap ends. Returns whether these bounds are enough for the goal; then the points are the deepest along the
 * axis. If not, *out is unchanged. */
bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out);

/* ---- moved apart ---- */

/* For two cores that hardly overlap the origin lies on the surface of B - A; a polytope expanded there has only
 * slivers, and its search ends early. A small move apart gives a better axis. */

/* Raises the lower bound of a wide interval, and replaces its axis, if it finds an axis that proves more. */
void moved_apart_raise(const unit_pair *p, span *s);

/* ==== points that face each other ==== */

/* If two cores overlap, the answer names the points that are deepest along the axis. */

/* Finds points that face each other: those at which the cores touch after B has moved along s->axis by the depth. */
void witness_apart(const unit_pair *p, span *s);

/* Keeps s->point_a and s->point_b if they lie on the support planes of their cores along s->axis and face each other.
 * If not, it takes those of witness_apart; if these do not do so either, a support point of each core. */
void witness_deepest(const unit_pair *p, span *s);

/* Writes points on the support planes that face each other, by a formula. Along an axis that is not that of the least
 * depth there may be none. If it returns false, none are known, and the points written are `top`, the support points.
 */
bool witness_facing(const unit_pair *p, const minkowski *top, span *s);

#endif
