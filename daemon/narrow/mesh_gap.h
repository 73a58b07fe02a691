/* mesh_gap: the distance of two surfaces, one or both a mesh, and whether one lies inside of the other. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_MESH_GAP_H
#define COLLIDED_NARROW_MESH_GAP_H

#include "mesh_walk.h"

typedef enum mesh_relation {
    MESH_APART,    /* the cores have no point in common */
    MESH_CROSSING, /* a surface passes through the other core, or is so near that rounding decides, or nearer than
                      narrow_goal.near: then lo is -INFINITY */
    MESH_HOLDS_A, /* A's core, or a component of a mesh A, is inside of B, which is a solid; no surface meets another */
    MESH_HOLDS_B  /* the other way round */
} mesh_relation;

typedef struct mesh_gap {
    span nearest; /* of the surfaces: lo <= distance <= hi, the axis from A to B, the nearest points. Where one of
                     several components is held: of a point of it, and the surface about it */
    uint32_t triangle_a, triangle_b; /* the nearest of the surfaces */
    mesh_relation relation;
    uint32_t component; /* of a mesh, that is held: the first in its order */
    bool cut;           /* the effort of the query ended before it was certain which pair of parts is the nearest */
} mesh_gap;

/* The parts that were the nearest at another time; any would do. */
typedef struct mesh_seed {
    uint32_t triangle_a, triangle_b;
} mesh_seed;

/* Where the walk stands. Every triangle counts: what was not looked at was proven to be no nearer. A seed (or NULL)
 * changes the time, and not a bit of the answer. */
void mesh_gap_find(mesh_walk *w, const narrow_goal *goal, const mesh_seed *seed, mesh_gap *out);

#endif
