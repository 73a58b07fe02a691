/* oracle: the truth that the engine is judged by, computed another way and in 113 bits.
 *
 * Signed distance of convex bodies: positive = gap, negative = minus the least translation that separates. Cores are
 * measured without their rounding radius, which is subtracted at the end: for the separation along a unit n,
 *     f(n) = min over B of n.x - max over A of n.x,
 * rounding subtracts the same sum of radii for every n, and the signed distance is the greatest f.
 *
 * Two methods that share nothing: features (every vertex-face and edge-edge pair; every face normal and edge cross
 * product) for polytopes, and bounds from inside and outside for any convex body. Pure, single-threaded; memory from
 * malloc, and a failure to get it ends the test program. */
#ifndef COLLIDED_TESTS_ORACLE_H
#define COLLIDED_TESTS_ORACLE_H

#include "quad.h"

#include <stdbool.h>
#include <stddef.h>

typedef enum oracle_core {
    ORACLE_POINTS,    /* convex hull of `points`: one = a sphere's centre, two = a capsule's axis, ... */
    ORACLE_CYLINDER,  /* x^2 + y^2 <= half.x^2, |z| <= half.z */
    ORACLE_CONE,      /* apex at +half.z, base disc of radius half.x at -half.z */
    ORACLE_ELLIPSOID, /* semi-axes `half` */
    ORACLE_HALFSPACE  /* z <= 0 */
} oracle_core;

typedef struct oracle_body {
    oracle_core core;
    quad radius; /* rounding */
    qvec half;
    const qvec *points; /* ORACLE_POINTS: borrowed, in the body's frame */
    size_t count;
    qmat rotation; /* world = rotation * local + position; used as given, orthonormal or not */
    qvec position;
} oracle_body;

typedef struct oracle_truth {
    quad lo, hi; /* the signed distance lies between. lo = f(axis), polished, and is the better estimate: where many
                    axes are equally deep (round bodies, one within the other) hi comes closer very slowly */
    qvec axis;   /* unit, A to B */
} oracle_truth;

enum { ORACLE_FEATURES_MAX = 96 }; /* points a body, for the method of features */

qmat oracle_rotation(quad w, quad x, quad y, quad z); /* of a quaternion, normalised first */

/* The point of the core with the greatest dot(direction, x), in the world; not for half-spaces. */
qvec oracle_support(const oracle_body *body, qvec direction);

/* f(n) of the rounded bodies, for n of any length but 0. -INFINITY where a half-space gives no bound. */
quad oracle_separation(const oracle_body *a, const oracle_body *b, qvec n);

/* The signed distance by the method that fits the pair. Two half-spaces: 0 depth is never said, -INFINITY is. */
oracle_truth oracle_distance(const oracle_body *a, const oracle_body *b);

/* The two methods by themselves. Features: both bodies ORACLE_POINTS, of at most ORACLE_FEATURES_MAX. Bounds: no
 * half-spaces. */
oracle_truth oracle_distance_features(const oracle_body *a, const oracle_body *b);
oracle_truth oracle_distance_bounds(const oracle_body *a, const oracle_body *b);
/* The same in at most so many steps (600 above) of what bounds a depth from inside: its time goes with their cube. */
oracle_truth oracle_distance_bounds_in(const oracle_body *a, const oracle_body *b, int steps);

/* How far a world point is outside of the rounded body; 0 inside. */
quad oracle_outside(const oracle_body *body, qvec point);

/* The greatest |coordinate| that enters: extents of both bodies and the distance of their positions. */
quad oracle_size(const oracle_body *a, const oracle_body *b);

/* A claim of the engine: an interval with its proof. Points are relative to `origin` (world axes). */
typedef struct oracle_claim {
    double lo, hi;
    double axis[3], point_a[3], point_b[3];
    qvec origin;
} oracle_claim;

/* Is the proof a proof? lo <= f(axis) without slack; the witness points not farther outside than `slack`; apart: their
 * distance <= hi; overlapping: deepest along the axis within `slack`. NULL, or what is wrong with it. */
const char *oracle_check(const oracle_body *a, const oracle_body *b, const oracle_claim *claim, quad slack);

#endif
