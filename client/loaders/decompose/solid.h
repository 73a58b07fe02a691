/* solid: a triangle mesh made ready for questions about the volume that it encloses: points united, triangles
 * without area left out where others cover them, a tree of boxes over them. The solid is the triangles and every point
 * that they wind around.
 *
 * Made in a pool and lives there; immutable afterwards. Lengths in the mesh's own unit (m), in its own frame. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_SOLID_H
#define COLLIDED_LOADERS_DECOMPOSE_SOLID_H

#include "loaders/mesh.h"

typedef struct solid_triangle {
    double at[3][3];
    double normal[3]; /* unit, outward; zero where rounding leaves none */
    bool backed;      /* the solid is behind it */
    bool bent;        /* it is not, or at one of its corners the solid may be not convex */
} solid_triangle;

typedef struct solid_node {
    double lo[3], hi[3];
    uint32_t first, count; /* a leaf's triangles; count 0 otherwise */
    uint32_t right;        /* the left part follows its parent */
} solid_node;

typedef struct solid_edge { /* at which the solid is not convex */
    double lo[3], hi[3];    /* the box over it */
} solid_edge;

typedef struct solid {
    solid_triangle *triangles; /* in the order of the tree's leaves */
    size_t count;
    solid_node *nodes;
    solid_edge *reflex;
    size_t reflex_count;
    double lo[3], hi[3], diagonal;
    double most;               /* greatest |coordinate| */
    struct overhang *overhang; /* where nearest points can be: overhang.h; NULL = not known */
    size_t united, dropped;    /* corners that repeated another's place; triangles that others cover: see keep_folded */
    bool closed;               /* each edge is walked as often one way as the other */
} solid;

#endif
