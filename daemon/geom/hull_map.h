/* hull_map: the Gauss map of a small hull in columns, for a look at all its faces at once: their normals are points of
 * the unit sphere, its edges the arcs between them.
 *
 * Only hulls have one whose map says all there is to know of where they end: all faces are triangles, and the stored
 * normals are those of the exact triangles but for HULL_MAP_ANGLE. (A plane that holds three points to within e has
 * their normal but for the angle e / w, w the least height of their triangle.) So a facet of the polytope has a normal
 * in the map, an edge an arc, and both are where they are to within that angle and the rounding of single precision.
 * Stands behind the hull's vertices, in the same memory; immutable. */
#ifndef COLLIDED_GEOM_HULL_MAP_H
#define COLLIDED_GEOM_HULL_MAP_H

#include "hull.h"

enum {
    HULL_MAP_VERTICES_MAX = 32,
    HULL_MAP_FACES_MAX = 64, /* Euler: 2 * 32 - 4 triangles; padded */
    HULL_MAP_ARCS_MAX = 96,  /* 3 * 32 - 6 edges; padded */
    HULL_MAP_LANES = 8
};

#define HULL_MAP_ANGLE 0x1p-34
#define HULL_MAP_LEAST_COSINE (-0.99) /* between the normals beside an edge */

/* Faces and arcs in the order of the hull's faces and edges, padded to a multiple of HULL_MAP_LANES by repeating the
 * last one. An arc is a word: the faces whose normals it ends at, the vertices of its edge, and twice the cosine of its
 * length in 255ths, rounded up. */
struct hull_map {
    int padded_faces, padded_arcs;
    double unit; /* power of two: offset * unit is the face's */
    float *normal_x, *normal_y, *normal_z, *offset;
    int32_t *arc;
};

enum {
    HULL_ARC_FACE_BITS = 6,
    HULL_ARC_VERTEX_BITS = 5,
    HULL_ARC_F1 = HULL_ARC_FACE_BITS, /* where in the word each begins; the first face at 0 */
    HULL_ARC_V0 = HULL_ARC_F1 + HULL_ARC_FACE_BITS,
    HULL_ARC_V1 = HULL_ARC_V0 + HULL_ARC_VERTEX_BITS,
    HULL_ARC_COSINE = HULL_ARC_V1 + HULL_ARC_VERTEX_BITS, /* to the end, signed */
    HULL_ARC_ONE = 255
};

/* Bytes for the map of a hull of so many vertices; 0 when it cannot have one. */
size_t hull_map_room(uint32_t vertex_count);

/* In `room`, aligned to 8 bytes. NULL when the hull is too large, flat, has faces of more corners, or is too sharp. */
hull_map *hull_map_build(const hull *h, void *room);

#endif
