/* manifold: up to four contact points of a pair whose axis and depth are already known.
 *
 * The features of both shapes that face each other along the axis (face, cap, side line, edge) are clipped against each
 * other. Depends on the shapes, the pose and the axis alone: no history. Discs are clipped as octagons
 * (geom/feature.h); where such a rim passes above the true deepest point, that point joins. Curved spots, crossing
 * edges and corners give one point, and so do flat hulls, which have no faces. */
#ifndef COLLIDED_NARROW_CONTACT_MANIFOLD_H
#define COLLIDED_NARROW_CONTACT_MANIFOLD_H

#include "narrow/pair/request.h"

/* ---- manifold choice ---- */

/* Up to four of any number of contact points, by the rule of manifold.c: the deepest, the one farthest from it, the
 * farthest from their line on either side. Of several that are equally deep, as on a flat floor, one at a corner is
 * taken and not one at a seam. One pass over all points for each, so that none is stored and there is no cap on how
 * many there are. */

typedef enum manifold_pass {
    PASS_DEEPEST,
    PASS_FARTHEST,
    PASS_CORNER,
    PASS_LEFT,
    PASS_RIGHT,
    PASS_COUNT
} manifold_pass;

typedef struct manifold_choice {
    manifold chosen;
    manifold_pass pass; /* what is looked for */
    bool found;
    double best;
    manifold_point point; /* the best of this pass */
    double same;          /* points nearer to each other than this, across the axis, are one; and equally deep */
    vec3 u, v;            /* across the axis */
} manifold_choice;

void manifold_choice_begin(manifold_choice *c, vec3 axis, double same);
void manifold_choice_offer(manifold_choice *c, const manifold_point *p);
bool manifold_choice_next(manifold_choice *c); /* after a pass; false: there are no more */

/* In the order of their features. */
void manifold_choice_write(const manifold_choice *c, manifold *out);

/* ---- manifold ---- */

/* `axis` is unit, in A's frame, from A towards B; `point_a`, `point_b` are the deepest (or nearest) points of the
 * answer, used when the features meet in one point only. Points farther apart than `threshold` along the axis are left
 * out, but there is always at least one point; of more than four the deepest and the widest spread are kept, in the
 * order of their features. Ids stay while the pose moves by less than 1e-6 of the smaller feature. Everything in A's
 * frame. */
void manifold_build(const shape *a, const shape *b, const transform *b_in_a, vec3 axis, vec3 point_a, vec3 point_b,
    double threshold, manifold *out);

/* The one point of an answer whose parts bring none: midway between its points. The axis need not be that of the parts
 * whose points these are, so the distance along it is taken into the interval. */
manifold_point manifold_witness(const narrow_result *answer);

#endif
