/* box_axes: the fifteen axes of two boxes, in A's frame, and how far each separates. Inlined: for the depth and
 * distance of boxes and for their march along a motion. Pure; any thread. */
#ifndef COLLIDED_NARROW_BOX_AXES_H
#define COLLIDED_NARROW_BOX_AXES_H

#include "unit_pair.h"

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

#endif
