/* rim_newton: two features of rim_features.h along the direction in which they are farthest apart. A's frame, a
 * unit_pair's units. Pure; any thread. */
#ifndef COLLIDED_NARROW_RIM_NEWTON_H
#define COLLIDED_NARROW_RIM_NEWTON_H

#include "rim_parts.h"

/* n: unit, from A towards B. */
typedef struct rim_stand { /* both parts along n, and the next step */
    vec3 n, point_a, point_b;
    double lo, share_a, share_b; /* of the second discs */
    double uneven;               /* the difference of what should be equally high */
    vec3 step;                   /* orthogonal to n */
} rim_stand;

/* Where Newton's method ends from s->n, to the last bits by the cell and the features alone (rim_features.h). `size`:
 * the pair's. False: not found. */
bool rim_stand_between(const rim_part *a, const rim_part *b, double size, rim_stand *s);

/* `other` along the normal of `face`; `sign`: 1 when the face is A's. False: `other` is no corner, apex or rim. Fills
 * n, the points and lo. */
bool rim_stand_on_face(const rim_part *face, const rim_part *other, double sign, rim_stand *s);

#endif
