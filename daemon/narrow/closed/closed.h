/* closed: distances that have a formula. Each fills the span of two cores. It returns false if the two bounds are left
 * farther apart than the goal allows (by rounding, or at corners of boxes), and the general method takes over from
 * out->axis. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_CLOSED_CLOSED_H
#define COLLIDED_NARROW_CLOSED_CLOSED_H

#include "narrow/pair/unit_pair.h"

typedef bool closed_form(const unit_pair *p, const narrow_goal *goal, span *out);

closed_form closed_sphere_revolved; /* cylinder or cone */
closed_form closed_any_halfspace;   /* B is the half-space */
closed_form closed_halfspace_any;   /* A is the half-space */
closed_form closed_halfspace_halfspace;

/* ==== boxes by separating axes ==== */

/* Two boxes (or points and segments, which are boxes with zero sides) by their fifteen axes.
 *
 * B - A is a zonotope: its facets have the normals of A's faces, of B's faces, or cross products of an edge of each, so
 * the greatest separation over those fifteen is minus the depth when the boxes overlap, and a lower bound of the
 * distance when they do not. No axis is favoured: the greatest wins, ties go to the first. */

/* Measures two boxes. It returns false for separated boxes that are nearest at corners, or at a corner and an edge, if
 * that leaves the bounds too wide: then out->axis is the axis of the fifteen that separates them most. */
closed_form closed_box_box;

/* Fills lo, hi, axis, method and iterations; hi is an upper bound only when it is negative. */
void box_pair_axes(const unit_pair *p, span *out);

/* Of the fifteen axes of boxes that overlap, as bits (A's faces, B's faces, edge i of A with edge j of B at BOX_FACES +
 * 3 i + j): those along which the exact separation may be the greatest, as far as the rounding of doubles can show.
 */
enum { BOX_FACES = 6 };
unsigned box_pair_near_best(const unit_pair *p);

/* ==== the axes of two boxes ==== */

/* The fifteen axes of two boxes, in A's frame, and how far each separates. Inlined: for the depth and
 * distance of boxes and for their march along a motion. */

/* r[i][j] = component i of B's axis j; t in A's axes, u in B's. */
typedef struct box_pair {
    const unit_pair *p;
    double a[3], b[3], t[3], u[3], r[3][3], abs[3][3];
} box_pair;

static inline double box_face_of_a(const box_pair *x, int i)
{
    double reach_b = x->abs[i][0] * x->b[0] + x->abs[i][1] * x->b[1] + x->abs[i][2] * x->b[2];
    return fabs(x->t[i]) - x->a[i] - reach_b;
}

static inline double box_face_of_b(const box_pair *x, int j)
{
    double reach_a = x->abs[0][j] * x->a[0] + x->abs[1][j] * x->a[1] + x->abs[2][j] * x->a[2];
    return fabs(x->u[j]) - x->b[j] - reach_a;
}

/* An edge's axis before it is divided by its length, the sine of the angle between the edges. */
typedef struct box_edge_axis {
    double separation, norm2;
} box_edge_axis;

/* Along n = e_i x r_j, which has no component i, and d, c = -r[k][j], r[h][j] for the other two: so n is orthogonal to
 * r_j to the last bit, however small it is. */
static inline box_edge_axis box_edge_axis_of(const box_pair *x, int i, int j)
{
    int h = (i + 1) % 3, k = (i + 2) % 3, l = (j + 1) % 3, m = (j + 2) % 3;
    double nh = -x->r[k][j], nk = x->r[h][j];
    double along_l = nh * x->r[h][l] + nk * x->r[k][l], along_m = nh * x->r[h][m] + nk * x->r[k][m];
    double reach = x->a[h] * x->abs[k][j] + x->a[k] * x->abs[h][j] + x->b[l] * fabs(along_l) + x->b[m] * fabs(along_m);
    return (box_edge_axis){fabs(nh * x->t[h] + nk * x->t[k]) - reach, nh * nh + nk * nk};
}

/* ==== ellipsoids ==== */

/* The signed distance of two ellipsoids, or of a ball and one, by Newton's method and one global proof.
 *
 * The support function of B - A along a unit n is h(n) = c.n + |A n| + |B n|, smooth; its least over all n is the depth
 * (minus the distance when the cores are apart). Apart, any n and any two points bracket it. Overlapping, h may have
 * several least places, and the proof has to be of all directions at once: for every orthogonal S
 *     |A n| + |B n| >= |(A + S B) n|
 * by the triangle inequality, with equality at n0 where S turns B n0 towards A n0 (an ellipsoid inside B - A that
 * touches it there: Kurzhanski and Valyi, "Ellipsoidal Calculus", 1997). And c.n + |M n| >= d holds for all unit n when
 * a quadratic form says so (the S-lemma, which on a sphere loses nothing). A few hundred operations, where a hull of
 * support points needs fifty expansions. */

/* If it returns false, nothing is proved, and only out->axis is valid: another search may begin with it. */
bool ellipsoid_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
