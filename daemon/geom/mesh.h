/* mesh: triangles made ready for queries: welded vertices, a hierarchy of boxes, and whether there is an inside.
 *
 * Built once, immutable afterwards, shared by any number of shapes and threads. Coordinates are the input's own, bit
 * for bit. A mesh is a solid when each of its edges is walked as often in one direction as in the other: then each
 * point off the surface has a winding number, and those where it is not 0 are the inside. Any other mesh is a surface.
 */
#ifndef COLLIDED_GEOM_MESH_H
#define COLLIDED_GEOM_MESH_H

#include "hull.h"

enum {
    MESH_TRIANGLES_MAX = 1 << 22, /* so that the hierarchy is at most MESH_DEPTH_MAX nodes deep: see mesh_tree.c */
    MESH_DEPTH_MAX = 12,
    MESH_WIDTH = 4,         /* children of a node: as many floats as a vector register of any processor has */
    MESH_LEAF_MAX = 4,      /* triangles */
    MESH_PATCH_POINTS = 24, /* that stand for a patch, at most */
    MESH_PIECES_MAX = 48
};

typedef struct mesh_triangle {
    uint32_t v[3];
    uint32_t edge[3]; /* of the mesh: k from v[k] to v[k + 1], numbered in the order of their vertices */
    uint32_t source;  /* which triangle of the input it was */
    uint32_t form;    /* mesh_form */
} mesh_triangle;

/* What a triangle covers. One without an area is kept where it is more than a part of the edges of others, or closes a
 * solid; folded ones repeat their last corner. Only the first two are of the surface around a solid. */
typedef enum mesh_form {
    MESH_AREA,
    MESH_SEAM,   /* its corners lie on a line, but for rounding: it closes what the others leave open */
    MESH_NEEDLE, /* the same, but it closes nothing: it is the longest of its sides */
    MESH_FOLDED  /* two of its corners are one, and it is a segment; or all three, and it is a point */
} mesh_form;

/* Up to four patches of the surface, coordinate by coordinate, in units of mesh.unit: each in a box along the axes,
 * rounded outward, and in a turned box, which lies along its mean normal: patches are flat. Empty places come last. */
typedef struct mesh_node {
    float centre[3][MESH_WIDTH];
    float normal[3][MESH_WIDTH], half[MESH_WIDTH]; /* a side of the turned box: unit to 2^-22, and half its extent */
    float side[2][3][MESH_WIDTH];                  /* from the centre to the middles of two other faces */
    uint32_t first[MESH_WIDTH];                    /* of a leaf: its first triangle; otherwise the index of a node */
    uint8_t count[MESH_WIDTH];                     /* of a leaf: triangles; 0: not a leaf */
    uint8_t used;                                  /* children, 1 to MESH_WIDTH */
    float size[MESH_WIDTH];                        /* sum of the sides of the box along the axes: which to open first */
    uint32_t first_point;                          /* in mesh.patch_points: those that stand for the patches; no ... */
    uint8_t points;                                /* ... vertex of patch k is outside of the hull of its own by ... */
    float excess[MESH_WIDTH];                      /* ... more than excess[k] */
    float lo[3][MESH_WIDTH], hi[3][MESH_WIDTH];    /* last: not all walks look at them */
} mesh_node;

/* One of each patch of a node, coordinate by coordinate, in units of mesh.unit. A patch may have one twice. All of them
 * take 30 to 55 bytes a triangle, and finding them 3 us a triangle: mesh_patch.c. */
typedef struct mesh_patch_point {
    float at[3][MESH_WIDTH];
} mesh_patch_point;

/* What hangs together by common vertices. Where no surface meets a solid's, all of a component is inside of it, or
 * nothing: so one point of each decides. */
typedef struct mesh_component {
    uint32_t triangle;  /* its first one, in the order of the leaves */
    float lo[3], hi[3]; /* a box around it along the axes, rounded outward, in units of mesh.unit */
} mesh_component;

/* A convex part of a solid. */
typedef struct mesh_piece {
    hull *hull;
    double slack; /* m: moved inward by no more than this, as a whole convex body, it is inside of the solid, proven */
} mesh_piece;

/* What was done to the input, and why a mesh is no solid: counts, 0 = nothing of the kind. */
typedef struct mesh_findings {
    uint32_t welded;       /* vertices that equal an earlier one, or that no triangle uses: left out */
    uint32_t zero_area;    /* triangles without area: left out, because others cover all of them */
    uint32_t needles;      /* triangles without area: kept as segments or points */
    uint32_t repeated;     /* triangles that equal an earlier one: left out */
    uint32_t turned;       /* triangles whose orientation was turned to agree with their neighbours */
    bool inside_out;       /* all were turned, because their normals pointed inward */
    uint32_t open_edges;   /* edges of one triangle only */
    uint32_t shared_edges; /* edges of more than two triangles */
    uint32_t torn_edges;   /* edges whose two triangles are oriented against each other, beyond repair */
} mesh_findings;

typedef struct mesh {
    uint32_t vertex_count, triangle_count, node_count;
    uint32_t depth; /* nodes from the root to the deepest, both counted */
    vec3 *vertices;
    mesh_triangle *triangles; /* in the order of the leaves */
    vec3 *corners;            /* three a triangle, in that order: a walk finds those of a leaf side by side */
    mesh_node *nodes;         /* the root first */
    mesh_patch_point *patch_points;
    uint32_t patch_point_count;
    uint32_t component_count;   /* at least 1 */
    mesh_component *components; /* in the order of their first triangles */
    double unit;                /* a power of two, m: the boxes' unit, so that floats hold any mesh */
    bool solid;
    mesh_findings found;
    hull *hull;         /* convex hull of all vertices; flat when the mesh is */
    double max_abs;     /* max |coordinate| */
    mesh_piece *pieces; /* of a solid: they overlap, and their union may be less than the solid: mesh_pieces.c */
    uint32_t piece_count;
    bool filled;            /* each triangle is on the surface of a piece: they are the solid, or about it */
    bool convex;            /* a solid that its hull is, but for the slack of pieces[0], which has that hull */
    uint32_t rows, columns; /* of the height field that it was made of (height_field.h); 0: of none */
} mesh;

typedef enum mesh_status {
    MESH_OK,
    MESH_NO_TRIANGLES, /* none, or none that has an area */
    MESH_TOO_MANY,     /* more than MESH_TRIANGLES_MAX triangles */
    MESH_BAD_INDEX,    /* a triangle names a vertex that does not exist */
    MESH_NOT_FINITE,   /* NaN, infinity, or beyond SHAPE_SIZE_MAX */
    MESH_WIDE_HULL     /* its convex hull has more than HULL_VERTICES_MAX corners, or could not be built */
} mesh_status;

/* `points`: count triples x, y, z; `corners`: three indices a triangle, counter-clockwise seen from outside. On MESH_OK
 * *out is owned by the caller, who frees it by mesh_destroy. The same input gives the same mesh. */
mesh_status mesh_build(const double *points, size_t count, const int32_t *corners, size_t triangle_count, mesh **out);
void mesh_destroy(mesh *m);
const char *mesh_status_text(mesh_status status);

/* What mesh.found says, as one line for people: "a solid", "a surface, because 3 edges are open; 2 triangles without
 * area were left out". Returns what snprintf would. */
int mesh_describe(const mesh *m, char *text, size_t size);

static inline vec3 mesh_corner(const mesh *m, uint32_t triangle, int corner)
{
    return m->vertices[m->triangles[triangle].v[corner]];
}

/* Is a point that is not on the surface inside of a solid? Decided exactly: the winding number by a ray along +z. Pure;
 * any thread. */
bool mesh_inside(const mesh *m, vec3 point);

/* Whole-structure check for tests: each triangle in exactly one leaf, boxes around all below them, depth, components.
 * The first fault found, or NULL. */
const char *mesh_validate(const mesh *m);

#endif
