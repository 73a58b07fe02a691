/* motion: how a body moves over a span of time: its origin along a straight line at a constant speed, and all of it
 * about its origin, at a constant angular velocity. Plain values; pure; any thread.
 *
 * Units: m, s, m/s, rad/s; world frame. No libm transcendentals: sine, cosine and arc tangent are polynomials of our
 * own (after fdlibm, Sun Microsystems 1993), so that every machine gets the same bits. */
#ifndef COLLIDED_GEOM_MOTION_H
#define COLLIDED_GEOM_MOTION_H

#include "bounds.h"

typedef struct motion {
    pose start; /* of the body at time 0 */
    vec3 linear;
    vec3 angular;
} motion;

/* Beyond it an angle has lost too many bits to be turned by: callers refuse such speeds. */
#define MOTION_ANGLE_MAX 1e6 /* rad */

/* The motion from one pose to another in `span` seconds (> 0), turned the shorter way: two poses hide whole turns. Its
 * pose at `span` is `to`, but for rounding. */
motion motion_between(pose from, pose to, double span);

/* The body's pose at a time: off by at most motion_error from the motion that the numbers say, for each of its points
 * within `reach` of its origin. |angular| * time <= MOTION_ANGLE_MAX. */
pose motion_pose(const motion *m, double time);

/* A constant turning, made ready for many times. */
typedef struct motion_spin {
    vec3 axis;    /* unit, or zero */
    double speed; /* rad/s */
} motion_spin;
motion_spin motion_spin_of(vec3 angular);
quat motion_spun(motion_spin spin, quat start, double time); /* `start`, turned for so long */
mat3 motion_turn(motion_spin spin, double time);             /* that turning itself */

/* m; rounding of motion_pose for times up to `time` and points up to `reach` from the body's origin. */
double motion_error(const motion *m, double time, double reach);

/* m, rounded up: how far the core of a shape at `local` in its body reaches from the axis of its turning: the line
 * along `axis` (unit, or zero: no turning, 0) through the body's origin, both in the body's frame. INFINITY for
 * half-spaces.
 */
double motion_radius(const shape *s, pose local, vec3 axis);

/* The box of a shape at `local` in its body, over all times from 0 to `span`, rounded outward. */
aabb motion_bounds(const motion *m, const shape *s, pose local, double span);

#endif
