/* manifold_choice: up to four of any number of contact points, by the rule of manifold.c: the deepest, the one farthest
 * from it, the farthest from their line on either side. Of several that are equally deep, as on a flat floor, one at a
 * corner is taken and not one at a seam. One pass over all points for each, so that none is stored and there is no cap
 * on how many there are. Pure; any thread. */
#ifndef COLLIDED_NARROW_MANIFOLD_CHOICE_H
#define COLLIDED_NARROW_MANIFOLD_CHOICE_H

#include "narrow.h"

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

#endif
