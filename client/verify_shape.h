/* verify_shape: what a proof needs to know of a shape, by formulas of its own: how far it reaches along a direction,
 * and whether a point is of it. Nothing here is shared with the daemon, so that a mistake there is not repeated here.
 * In doubles, whose rounding is a small part of what verify.c allows for. Pure; any thread. */
#ifndef COLLIDED_CLIENT_VERIFY_SHAPE_H
#define COLLIDED_CLIENT_VERIFY_SHAPE_H

#include "collided.h"
#include "verify_hull.h"
#include "verify_scan.h"

#include <math.h>

static inline vec vec_of(const double v[3])
{
    return (vec){v[0], v[1], v[2]};
}
static inline vec add(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec sub(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec scale(real s, vec a)
{
    return (vec){s * a.x, s * a.y, s * a.z};
}
static inline real dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline real length(vec a)
{
    return sqrt(dot(a, a));
}

/* A shape where it stands. */
typedef struct placed {
    const collided_shape *shape;
    const double *points; /* of a hull */
    size_t point_count;
    const collided_prepared_hull *prepared; /* those points; NULL if they are not */
    vec columns[3];                         /* the shape's axes in the world */
    vec origin;                             /* of the shape relative to its body's position, in world directions */
    vec body;                               /* position of the body */
    real rounding;                          /* of a compound's child: what the compound adds to the child's own */
    real top, reach2;                       /* of a hull's points, in their frame, by placed_look */
    union {                                 /* what it saw */
        points_scan scan;
        prepared_scan prepared_scan;
    };
} placed;

/* The points of a hull, if there is one: count triples, or prepared. */
typedef struct hull_points {
    const double *at;
    size_t count;
    const collided_prepared_hull *prepared;
} hull_points;

/* False if the shape or its poses are not usable: not finite, no rotation, negative sizes, no points; or if it is a
 * mesh, a height field, or a compound of anything but convex shapes with an end and a formula. Then placed_look: false
 * if the points of a hull are not finite; `n` is the direction along which it will be asked for its support. */
bool placed_make(placed *p, const collided_shape *shape, const collided_pose *body, hull_points points);
bool placed_look(placed *p, vec n);

real placed_reach(const placed *p); /* of its points from the body's position; a half-space: of its origin */
real placed_support(
    const placed *p, vec n); /* greatest n . x of its points, relative to the body's position; for a
                                half-space n is taken to be its normal, for a hull what placed_look got */
/* Is a point not farther than `slack` from the shape? `n`, unit or zero, is where the shape ends next to it, most
 * likely: it changes the time. Never true of a point that is farther. *deviation: how far such a point may be from what
 * the shape stands for. */
bool placed_holds(const placed *p, vec world, vec n, real slack, real *deviation);
vec placed_normal(const placed *p); /* of a half-space, outward, world */

#endif
