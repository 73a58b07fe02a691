/* dome: a cone of directions in which two overlapping cores are surely no shallower than at its middle.
 *
 * Where a cylinder or a cone is met at its rim, B - A is curved, and triangles inscribed in it come to within eps only
 * when they are sqrt(eps) small. A dome takes the curved pieces (pieces.h) as they are: about a least of the greatest
 * of some of them it bounds their second derivatives over a whole cone of directions (the second-order sufficient
 * condition of a minimax). All of this is of support functions of parts of B - A, so it is a lower bound of its support
 * function h, the overlap of the support intervals, whether or not the pieces are the right ones.
 *
 * Lengths between cores, directions from the origin outward (minus the axis of a span). Pure; any thread. */
#ifndef COLLIDED_NARROW_DOME_H
#define COLLIDED_NARROW_DOME_H

#include "pieces.h"

typedef struct dome {
    vec3 direction;        /* unit; its middle */
    double cosine;         /* of the angle from there to its rim; > 0 */
    double depth;          /* h(n) is not less for any unit n of the dome; > 0 */
    vec3 point_a, point_b; /* the deepest points at `direction` */
} dome;

/* The dome about a local least near the unit direction `near`. `close`: by which `depth` may fall short of what it
 * might be. False: there is none, or it was not found. */
bool dome_raise(const unit_pair *p, const bundle *pieces, vec3 near, double close, dome *out);

/* Is every direction that leaves through the triangle `w`, and along which none of its corners is as high as `depth`
 * (at most the dome's), in the dome? Then nothing behind that triangle is nearer than `depth`. `nearest`: its point
 * nearest to the origin, by which most are refused. */
bool dome_covers(const dome *d, const vec3 w[3], vec3 nearest, double depth, double size);

#endif
