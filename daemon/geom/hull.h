/* hull: a convex polytope made ready for queries: vertices as arrays (for SIMD), faces, edges, neighbours.
 *
 * Built once by qhull (libqhull_r, Barber et al., "The Quickhull algorithm", 1996), immutable afterwards, shared by any
 * number of shapes and threads. Coordinates are the input's own, bit for bit; interior points are left out. */
#ifndef COLLIDED_GEOM_HULL_H
#define COLLIDED_GEOM_HULL_H

#include "vec.h"

#include <stddef.h>
#include <stdint.h>

enum { HULL_VERTICES_MAX = 65535 };

typedef struct hull_face {
    vec3 normal;            /* unit, outward */
    double offset;          /* max over all vertices of dot(normal, v): no vertex is outside */
    uint32_t first, count;  /* its loop in face_vertices, counter-clockwise seen from outside; coplanar facets merged */
} hull_face;

typedef struct hull_edge {
    uint32_t v0, v1;  /* v0 < v1 */
    uint32_t f0, f1;  /* the faces on its two sides */
} hull_edge;

typedef struct hull {
    uint32_t vertex_count, padded_count; /* padded to a multiple of 8 by repeating the last vertex */
    double *x, *y, *z;
    uint32_t face_count, edge_count; /* 0 when flat */
    hull_face *faces;
    uint32_t *face_vertices;
    hull_edge *edges;
    uint32_t *neighbour_first; /* vertex_count + 1 entries into neighbours */
    uint32_t *neighbours;
    double reach;     /* max |v|, rounded up */
    double max_abs;   /* max |coordinate| */
    int dimension;    /* 3; 2, 1 or 0 when flat, a line or a point (only with HULL_ALLOW_FLAT) */
} hull;

typedef enum hull_status {
    HULL_OK,
    HULL_EMPTY,        /* no points */
    HULL_TOO_MANY,     /* more than HULL_VERTICES_MAX points */
    HULL_NOT_FINITE,   /* NaN, infinity, or beyond SHAPE_SIZE_MAX */
    HULL_FLAT,         /* all points in a plane: it has no inside */
    HULL_FAILED        /* qhull gave up */
} hull_status;

enum { HULL_ALLOW_FLAT = 1 }; /* flat input becomes a hull without faces: distances work, there is no depth */

/* `points`: count triples x, y, z. On HULL_OK *out is owned by the caller, who frees it by hull_destroy. */
hull_status hull_build(const double *points, size_t count, unsigned flags, hull **out);
void hull_destroy(hull *h);
const char *hull_status_text(hull_status status);

static inline vec3 hull_vertex(const hull *h, uint32_t i) { return vec(h->x[i], h->y[i], h->z[i]); }

/* Whole-structure check for tests: Euler's formula, loops, planes, neighbours. The first fault found, or NULL. */
const char *hull_validate(const hull *h);

#endif
