/* pieces: B - A as the hull of a few smooth pieces, and the direction along which the highest of them is lowest.
 *
 * A piece is a disc or a point of B plus a disc or a point of -A: the rims of cylinders and cones, their apices, the
 * corners of all else. Its support function along a unit n is
 *     h(n) = c.n + ra |Pa n| + rb |Pb n|,   P the projection along the disc's axis,
 * and that of B - A, the overlap of the support intervals, is the greatest of all pieces' h. Its least over all n is
 * the depth when the cores overlap, and minus the distance when they do not. Which pieces matter there is learnt from
 * support points; the rest is Newton's method for a minimax (Fletcher, "Practical Methods of Optimization", 1987, ch.
 * 14), which converges quadratically where a hull of support points comes nearer by a constant factor.
 *
 * Lengths between cores, directions from the origin outward (minus the axis of a span). The result is
 * a proposal, which the caller proves. Pure; any thread. */
#ifndef COLLIDED_NARROW_CURVED_PIECES_H
#define COLLIDED_NARROW_CURVED_PIECES_H

#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

enum { PIECES_MAX = 3 }; /* as many hold a minimum in general */

typedef struct piece {
    vec3 a, b;     /* the discs' centres (or the points) of A and of B, in A's frame */
    double ra, rb; /* and radii */
} piece;

typedef struct view { /* a direction, the plane orthogonal to it, and both discs' frames in it */
    vec3 n, x, y;
    vec3 u[2];        /* of A's discs and of B's: Pn / |Pn|; zero when n is the axis, or there are no discs */
    double sine[2];   /* |Pn| */
    plane2 across[2]; /* axis x u */
} view;

typedef struct bundle { /* pieces, seen along one direction */
    int count;
    piece piece[PIECES_MAX];
    double height[PIECES_MAX];   /* h(n) */
    plane2 gradient[PIECES_MAX]; /* of h in the plane orthogonal to n */
    double weight[PIECES_MAX];   /* by which the gradients balance */
} bundle;

typedef struct curvature { /* symmetric */
    double xx, xy, yy;
} curvature;

/* Does the pair have rims, and only parts for which there are pieces? */
bool pieces_apply(const unit_pair *p);

bool pieces_know(const unit_pair *p, const bundle *b, const minkowski *m); /* is it on one of them? */

/* Adds the piece on which the support point lies, if it is new. If there are PIECES_MAX already, it replaces the
 * lowest. */
void pieces_add(const unit_pair *p, bundle *b, const minkowski *m);

view pieces_view(const unit_pair *p, vec3 n);

void pieces_points(const bundle *b, const view *v, vec3 *point_a, vec3 *point_b); /* of A and B, by the weights */

/* m += share r / width t t' */
void curvature_add(curvature *m, double share, double r, double width, plane2 t);

/* From v->n to where the greatest of the pieces is least; pieces that do not hold it are dropped. A step whose square
 * is at most near2 is the last: what is left is of the size of near2, and the height is off by its square. Then *b and
 * *v are of that place. False: not found. */
bool pieces_descend(const unit_pair *p, bundle *b, view *v, double near2);

/* Is it along the normal of a flat face of A or of B, near `near`? There h has a kink: E + G.d + r |d|, with the height
 * E and the gradient G of all but that disc. */
typedef struct pieces_face {
    vec3 normal;
    double height, margin; /* E; r - |G| > 0 */
    vec3 point_a, point_b;
} pieces_face;
bool pieces_find_face(const unit_pair *p, const bundle *b, vec3 near, pieces_face *out);

#endif
