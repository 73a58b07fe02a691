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

/* How far a face's own corner may lie below its plane, relative to the hull's extent: facets that qhull cannot tell
 * apart become one face, and it promises nothing worse. */
#define HULL_PLANE_RATIO 1e-9
/* And what products of subnormal coordinates may be off by: three on either side. */
#define HULL_SUBNORMAL 0x1p-1071

typedef struct hull_face {
    vec3 normal;           /* unit, outward */
    double offset;         /* max over all vertices of dot(normal, v): no vertex is outside */
    uint32_t first, count; /* its loop in face_vertices, counter-clockwise seen from outside; coplanar facets merged */
} hull_face;

typedef struct hull_edge {
    uint32_t v0, v1; /* v0 < v1 */
    uint32_t f0, f1; /* the faces on its two sides */
} hull_edge;

/* A box over some vertices, for the search of hull_support. In an array in the order parent, left part, right part. */
typedef struct hull_node {
    vec3 lo, hi;
    uint32_t first, count; /* a leaf's vertices in node_vertices; count 0 otherwise */
    uint32_t least;        /* the least vertex index inside */
    uint32_t skip;         /* the node after all of this one's */
} hull_node;

typedef struct hull_map hull_map;

typedef struct hull {
    uint32_t vertex_count, padded_count; /* padded to a multiple of 8 by repeating the last vertex */
    double *x, *y, *z;                   /* in one piece, behind the structure of a hull that was built */
    uint32_t face_count, edge_count;     /* 0 when flat */
    hull_face *faces;
    uint32_t *face_vertices;
    hull_edge *edges;
    uint32_t *neighbour_first; /* vertex_count + 1 entries into neighbours */
    uint32_t *neighbours;
    uint32_t node_count; /* 0 in a small hull, which is scanned */
    hull_node *nodes;
    uint32_t *node_vertices;
    hull_map *map;  /* hull_map.h; NULL: it has none */
    double reach;   /* max |v|, rounded up, `excess` included */
    double excess;  /* every input point is within this of the vertices' convex hull, found exactly (hull_excess.h); 0
                       when none is outside. All lower bounds are less by it, so that they hold for the input */
    double max_abs; /* max |coordinate| */
    int dimension;  /* 3; 2, 1 or 0 when flat, a line or a point (only with HULL_ALLOW_FLAT) */
} hull;

typedef enum hull_status {
    HULL_OK,
    HULL_EMPTY,      /* no points */
    HULL_TOO_MANY,   /* more than HULL_VERTICES_MAX points */
    HULL_NOT_FINITE, /* NaN, infinity, or beyond SHAPE_SIZE_MAX */
    HULL_FLAT,       /* all points in a plane: it has no inside */
    HULL_FAILED      /* qhull gave up */
} hull_status;

enum { HULL_ALLOW_FLAT = 1 }; /* flat input becomes a hull without faces: distances work, there is no depth */

/* `points`: count triples x, y, z. On HULL_OK *out is owned by the caller, who frees it by hull_destroy. The vertices
 * are in the order of the input; any order of the same points gives the same polytope. Left out are points that are
 * inside, that equal an earlier one, or that are outside by no more than rounding: 1e-13 of the extent, or
 * HULL_PLANE_RATIO where the input is coplanar only to some noise (of more than 2,000 points, 1e-6 where edges are
 * bent by less than joggling): hull.excess says by how much at most. In n log n for more than 2,000 points. A flat
 * hull keeps every distinct point. Flat means thinner than 2^-40 of its length. */
hull_status hull_build(const double *points, size_t count, unsigned flags, hull **out);
void hull_destroy(hull *h);
const char *hull_status_text(hull_status status);

/* Begins to fetch what a query will read of a small hull, if it is not in the processor's cache: vertices and map stand
 * behind the structure. */
enum { HULL_FETCHED = 24 }; /* cache lines: up to some 20 vertices */
static inline void hull_fetch(const hull *h)
{
    for (int i = 0; i < HULL_FETCHED; i++) __builtin_prefetch((const char *)h + (ptrdiff_t)64 * i);
}

static inline vec3 hull_vertex(const hull *h, uint32_t i)
{
    return vec(h->x[i], h->y[i], h->z[i]);
}

/* Whole-structure check for tests: Euler's formula, loops, planes, neighbours. The first fault found, or NULL. */
const char *hull_validate(const hull *h);

#endif
