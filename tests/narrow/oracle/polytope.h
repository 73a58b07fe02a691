/* polytope: faces and edges of a convex hull, found by trying every triple of vertices in 113 bits.
 *
 * Slow and simple on purpose: O(n^3) triples, each against all vertices. Points nearer to a plane than 1e-27 of the
 * size count as in it, which moves no answer by more. */
#ifndef COLLIDED_TESTS_ORACLE_POLYTOPE_H
#define COLLIDED_TESTS_ORACLE_POLYTOPE_H

#include "oracle.h"

typedef struct polytope_edge {
    size_t from, to;
    qvec inward; /* in the plane of its face, towards the face's inside; not unit */
} polytope_edge;

typedef struct polytope_face {
    qvec normal; /* unit; outward, or either way when the polytope is flat */
    size_t first_edge, edge_count;
    bool on[ORACLE_FEATURES_MAX];
} polytope_face;

typedef struct polytope {
    const qvec *points;
    size_t count;
    polytope_face *faces; /* none for a point or a line */
    size_t face_count;
    polytope_edge *edges; /* of all faces one after the other: each edge of a solid twice. A line: one; a point: one
                             of length 0 */
    size_t edge_count;
} polytope;

polytope polytope_build(const qvec *points, size_t count);
void polytope_free(polytope *p);

#endif
