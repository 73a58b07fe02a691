/* elementary: the two tests that continuous collision of deformable bodies is made of. A vertex against a triangle, and
 * an edge against an edge, while each point moves along a straight line from t = 0 to t = 1.
 *
 * Nothing that touches is ever called free, and no time is told that is later than the first contact: both are proofs,
 * by planes that separate over intervals of time. What is called a hit touches, or comes so near that rounding cannot
 * tell it from a contact; which of both, and how near, is said. Pure functions: no memory, no state, any thread. All
 * points are in one frame, m, and taken as the exact numbers that they are. The answer is the same, bit for bit, in
 * whichever order the corners of the face, the ends of an edge and the two edges are given; and scaling all lengths by
 * a power of two scales `gap` alone (extents from 2^-900 to 2^1000 m).
 *
 * Method: the vertex meets the face, or the edges meet, when the origin lies in the polygon of their differences: three
 * or four corners, each moving along a line. See elementary.c. */
#ifndef COLLIDED_SOFT_ELEMENTARY_H
#define COLLIDED_SOFT_ELEMENTARY_H

#include "geom/vec.h"

typedef enum elementary_status {
    ELEMENTARY_FREE, /* apart at every time in [0, 1], by more than the separation */
    ELEMENTARY_HIT,
} elementary_status;

typedef enum elementary_proof {
    ELEMENTARY_CERTAIN,   /* free: always. Hit: the separation is reached within [t_lo, t_hi] */
    ELEMENTARY_WITHIN,    /* at t_hi they are as near as rounding can tell: gap <= ELEMENTARY_NEAR of the extent */
    ELEMENTARY_UNDECIDED, /* given up, or no numbers, or an extent above 2^1000 m: gap says how near they are at t_hi */
} elementary_proof;

/* The extent is the greatest difference of coordinates, vertex to face or edge to edge, at t = 0 and t = 1. */
#define ELEMENTARY_NEAR 0x1p-44

enum { ELEMENTARY_STEPS_MAX = 64 }; /* planes marched past in one query; then a hit, undecided */

typedef struct elementary_result {
    elementary_status status;
    elementary_proof proof;
    double t_lo; /* apart, by more than the separation, at every time before; 1 when free */
    double t_hi; /* of a certain hit: reached by then; else equal to t_lo */
    double gap;  /* m; of a hit: at t_hi the distance is at most separation + gap; 0 when certain, INFINITY = unknown */
    int steps;   /* planes that were marched past */
} elementary_result;

/* start and end: the vertex and the three corners of the face. separation >= 0, m: how near counts as contact. */
void elementary_vertex_face(const vec3 start[4], const vec3 end[4], double separation, elementary_result *out);

/* start and end: the two ends of one edge, and of the other. */
void elementary_edge_edge(const vec3 start[4], const vec3 end[4], double separation, elementary_result *out);

/* What a caller with many pairs asks instead. `until`, in (0, 1]: a pair that is apart at every time before it is told
 * as free, with t_lo = t_hi = until; what is told of a hit before it is, bit for bit, what is told with until = 1.
 * `verdict`: whether they meet at all is enough: a certain hit may be told with a wide bracket (with until = 1 only);
 * status is that of the full test, and proof is at least as strong. */
typedef struct elementary_terms {
    double separation, until;
    bool verdict;
} elementary_terms;

void elementary_vertex_face_on(
    const vec3 start[4], const vec3 end[4], const elementary_terms *terms, elementary_result *out);
void elementary_edge_edge_on(
    const vec3 start[4], const vec3 end[4], const elementary_terms *terms, elementary_result *out);

/* The distance at one time: lo <= it <= hi, m; lo is proven by a plane, hi by two points. lo is 0 where they touch. */
void elementary_vertex_face_distance(const vec3 at[4], double *lo, double *hi);
void elementary_edge_edge_distance(const vec3 at[4], double *lo, double *hi);

#endif
