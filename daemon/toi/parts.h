/* toi_parts: a shape as a hierarchy of boxes over convex parts, each a convex shape that moves with the body: the
 * triangles of a mesh, the children of a compound. Pure; any thread. */
#ifndef COLLIDED_TOI_PARTS_H
#define COLLIDED_TOI_PARTS_H

#include "geom/mesh.h"
#include "geom/shape.h"

enum { PART_CHILDREN_MAX = MESH_WIDTH };

#define TOI_WHOLE_NODE UINT32_MAX

typedef enum toi_part_form { TOI_PART_SHAPE, TOI_PART_BOX, TOI_PART_TRIANGLE } toi_part_form;

typedef struct toi_part {
    const shape *whole;
    shape shape; /* a box around all below it, or the part itself; with the rounding of the whole */
    pose local;  /* of `shape` in the frame of the whole */
    bool is_leaf;
    uint32_t node, child; /* where its children are; of a mesh: one child of a node, or TOI_WHOLE_NODE */
    double size;          /* m: its reach */
    toi_part_form form;   /* what sweep.c sees, in the frame of the whole: `shape`, or ... */
    vec3 centre, side[3]; /* ... a box, which may be turned; of others their extents, but of triangles no sides */
    vec3 normal;          /* of a flat one: of any length */
    double margin;        /* m: of the rounding, and of what hulls were made of */
    hull flat;            /* of a triangle, which shape.hull points to */
    double x[8], y[8], z[8];
} toi_part;

/* All of a shape. One that is convex is its own only part. */
void toi_part_root(const shape *whole, toi_part *out);

/* How many it has; they are written to out[PART_CHILDREN_MAX]. Never called for leaves. */
int toi_part_children(const toi_part *p, toi_part *out);

/* Must it be walked? A half-space sees nothing but convex hulls. */
bool toi_parts_apply(const shape *a, const shape *b);

#endif
