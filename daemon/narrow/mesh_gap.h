/* mesh_gap: the distance of two surfaces, one or both a mesh, and whether one lies inside of the other. Pure; any
 * thread. */
#ifndef COLLIDED_NARROW_MESH_GAP_H
#define COLLIDED_NARROW_MESH_GAP_H

#include "mesh_walk.h"

/* ---- mesh part ---- */

/* The distance of the two parts that a walk visits. */

/* As gjk_distance, from what belongs to the parts alone (w->lead, w->from, w->edges): so the answer about two parts
 * does not depend on which others were looked at before. */
void mesh_part_distance(const mesh_walk *w, const narrow_goal *goal, span *out);

/* ---- mesh held ---- */

/* Which component of one mesh is inside of another, a solid. */

#define MESH_NOT_HELD UINT32_MAX
#define MESH_HELD_UNKNOWN (UINT32_MAX - 1) /* the effort of the query ended */

/* No surface is within rounding of the other. The first component of B (`of_a`: of A) in the order of its mesh that is
 * inside of the other, whatever the walk is aimed at and within; it is moved to where it is, and forgets its axis.
 * Or one of the two above. */
uint32_t mesh_held_component(mesh_walk *w, bool of_a);

/* A point of a component, in A's frame and units of the pair. */
vec3 mesh_component_point(const mesh_walk *w, bool of_a, uint32_t component);

/* How far a component reaches along a direction of A's frame, from its one end to the other: no less than it does. */
double mesh_component_width(const mesh_walk *w, bool of_a, uint32_t component, vec3 direction);

/* ---- mesh gap ---- */

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
