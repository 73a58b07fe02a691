/* mesh_row: one triangle, or all of a convex core, beside the four triangles of a leaf, which are looked at side by
 * side. For mesh_place.c. All in A's frame and units of the pair. Pure; any thread; the same bits on any processor. */
#ifndef COLLIDED_NARROW_TREE_MESH_ROW_H
#define COLLIDED_NARROW_TREE_MESH_ROW_H

#include "geom/mesh.h"

/* A triangle, or all of a convex A. */
typedef struct mesh_spot {
    vec3 corner[3]; /* of a triangle */
    vec3 lo, hi;    /* a box around it */
    vec3 normal;    /* of a triangle: of any length */
} mesh_spot;

/* The triangles of a leaf, coordinate by coordinate; of a leaf with fewer the last one again. */
typedef struct mesh_four {
    _Alignas(32) double corner[3][3][MESH_LEAF_MAX]; /* which corner, which coordinate */
    double lo[3][MESH_LEAF_MAX], hi[3][MESH_LEAF_MAX], normal[3][MESH_LEAF_MAX];
} mesh_four;

/* Up to four pairs of triangles of two leaves: byte k says which of A, which of B; what follows them is any of them. */
typedef struct mesh_picks {
    uint32_t a, b, count;
} mesh_picks;

static inline uint32_t mesh_pick(uint32_t picks, uint32_t k)
{
    return picks >> 8 * k & 0xff;
}

typedef struct mesh_row {
    double away2[MESH_LEAF_MAX]; /* square of what they are apart at least, by boxes or along `lead`, before rounding */
    double lead[3][MESH_LEAF_MAX]; /* the direction that separates them most, of those looked at: of any length */
    /* Of two triangles: the points that are nearest to each other on edges at the corners that are. */
    double from[3][MESH_LEAF_MAX], edges[3][MESH_LEAF_MAX]; /* the point on A's; from there to the point on B's */
} mesh_row;

/* `corners`: three a triangle, in the mesh's frame and the input's units; `b_in_a` NULL: of A. */
void mesh_four_set(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a);

/* Bit 4 i + k: triangle i of A and k of B are not proven to be farther apart than `within`: by their levels (the
 * greatest of each of A's along some axis, the least of B's), and along the line between the middles of the leaves.
 * Bits of what only repeats the last of a leaf mean nothing. */
unsigned mesh_fours_near(const mesh_four *a, const mesh_four *b, const double levels_a[MESH_LEAF_MAX],
    const double levels_b[MESH_LEAF_MAX], double within);

/* Bit k: pair k is not proven to be farther apart than the root of `within2`: along the lines between the nearest
 * corners and between the nearest points of two edges, and both normals. What is said of a pair depends on its two
 * triangles alone. Those bits have their places in `row`. */
unsigned mesh_row_near(const mesh_four *a, const mesh_four *b, const mesh_picks *picks, double within2, mesh_row *row);

/* The bits of `near` of which the triangle is not proven to be farther from a convex A than the root of `within2`: by
 * the boxes around them alone; no direction is written. */
unsigned mesh_row_near_core(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *row);

/* The same for an A that is the box around it: then along the line from it to the nearest corner, the normal, and all
 * directions across two edges. */
unsigned mesh_row_near_box(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *row);

/* The least heights of the four along an axis. */
void mesh_four_levels(const mesh_four *f, vec3 axis, double levels[MESH_LEAF_MAX]);

/* One of the four. */
void mesh_four_spot(const mesh_four *f, uint32_t i, mesh_spot *s);

/* All that is done with lanes. mesh_row_wide has registers of 32 bytes, where the processor has them (lanes_wide; else
 * NULL): a least or greatest takes one instruction there, which gcc emits only for intrinsics. The same bits. Only
 * mesh_row.c asks it. */
typedef struct mesh_row_kernel {
    void (*four_set)(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a);
    unsigned (*fours_near)(const mesh_four *a, const mesh_four *b, const double levels_a[MESH_LEAF_MAX],
        const double levels_b[MESH_LEAF_MAX], double within);
    unsigned (*row_near)(const mesh_four *a, const mesh_four *b, const mesh_picks *p, double within2, mesh_row *out);
    unsigned (*core_near)(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out);
    unsigned (*box_near)(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out);
    void (*four_levels)(const mesh_four *f, vec3 axis, double levels[MESH_LEAF_MAX]);
} mesh_row_kernel;
extern const mesh_row_kernel *const mesh_row_wide;

#endif
