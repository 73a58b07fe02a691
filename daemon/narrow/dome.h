/* dome: a cone of directions in which two overlapping cores are surely no shallower than at its middle.
 *
 * The overlap of the support intervals along a unit direction n is h(n), the support function of B - A, and the depth
 * is the least h. Where a cylinder or a cone is met at its rim, B - A is curved, and triangles inscribed in it come to
 * within eps only when they are sqrt(eps) small. A dome takes the curved pieces as they are: from the vertices of a
 * facet it knows on which rims (or corners) they lie, finds the least of the greatest of those pieces' support
 * functions by Newton's method, and bounds its second derivatives over a whole cone of directions (the second-order
 * sufficient condition of a minimax; Fletcher, "Practical Methods of Optimization", 1987, ch. 14). All of this is of
 * support functions of parts of B - A, so it is a lower bound of h whether or not the pieces are the right ones.
 *
 * Lengths between cores, directions from the origin outward (minus the axis of a span). Pure; any thread. */
#ifndef COLLIDED_NARROW_DOME_H
#define COLLIDED_NARROW_DOME_H

#include "unit_pair.h"

typedef struct dome {
    vec3 direction;        /* unit; its middle */
    double cosine;         /* of the angle from there to its rim; > 0 */
    double depth;          /* h(n) is not less for any unit n of the dome */
    vec3 point_a, point_b; /* the deepest points at `direction` */
} dome;

/* Has the pair rims that bend, and only pieces of which there are formulas? */
bool dome_applies(const unit_pair *p);

/* Is `m` on one of the pieces that the three points lie on? */
bool dome_knows(const unit_pair *p, const minkowski *const vertex[3], const minkowski *m);

/* The dome about a local least near the unit direction `near`, of the pieces that the three points lie on. `close`:
 * by which `depth` may fall short of what it might be. False: there is none, or it was not found. */
bool dome_raise(const unit_pair *p, const minkowski *const vertex[3], vec3 near, double close, dome *out);

/* Is every direction that leaves through the triangle `w`, and along which none of its corners is as high as `depth`
 * (at most the dome's), in the dome? Then nothing behind that triangle is nearer than `depth`. `nearest`: its point
 * nearest to the origin, by which most are refused. */
bool dome_covers(const dome *d, const vec3 w[3], vec3 nearest, double depth, double size);

#endif
