/* oracle: support heights, separations and membership in 113 bits, from the shapes' definitions and the poses' exact
 * values alone. Nothing here shares code with daemon/narrow or geom/support. */
#ifndef NARROW_ORACLE_H
#define NARROW_ORACLE_H

#include "narrow/narrow.h"

typedef __float128 real;

typedef struct real3 {
    real x, y, z;
} real3;

typedef struct placed { /* a shape at its exact pose: columns of the rotation, position */
    const shape *s;
    real3 rx, ry, rz, p;
} placed;

real real_sqrt(real x);
real3 real3_of(vec3 v);
real real3_dot(real3 a, real3 b);
real3 real3_sub(real3 a, real3 b);
real3 real3_cross(real3 a, real3 b);
real3 real3_scale(real3 a, real s);

/* The quaternion is normalised exactly. `origin` is subtracted from the position, exactly. */
placed oracle_place(const shape *s, pose at, vec3 origin);
real3 oracle_point(const placed *s, real3 local);

/* Greatest dot(n, x) over the shape (radius included), for any n, not only unit; INFINITY-like 1e4000 if unbounded. */
real oracle_height(const placed *s, real3 n);

/* min over B of dot(n, x) minus max over A, for n scaled to unit length: a lower bound of the signed distance. */
real oracle_separation(const placed *a, const placed *b, real3 n);

/* The greatest separation found by a multi-start search over directions: a lower bound of the signed distance, and the
 * signed distance itself where the search found its axis. */
real oracle_search(const placed *a, const placed *b);

/* How far the point is outside the shape: 0 inside, else a lower bound of the distance. */
real oracle_outside(const placed *s, vec3 point);

#endif
