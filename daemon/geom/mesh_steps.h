/* mesh_steps: the steps of mesh_build that have files of their own. Used by geom/mesh*.c only. Any thread. */
#ifndef COLLIDED_GEOM_MESH_STEPS_H
#define COLLIDED_GEOM_MESH_STEPS_H

#include "mesh.h"

/* Points that a convex hull is made of, where all of them would be too many: no other is outside of it by more than
 * `excess`. */
typedef struct mesh_outline {
    const uint32_t *vertices; /* indices of points */
    uint32_t count;
    double excess;
} mesh_outline;

/* mesh_build with an outline of its hull, or NULL. With one, no two points may be equal and each must have a triangle,
 * so that vertices are numbered as points are. */
mesh_status mesh_build_within(const double *points, size_t count, const int32_t *corners, size_t triangle_count,
    const mesh_outline *outline, mesh **out);

/* Looks at the edges of the triangles that are no needles, and of needles that close what those leave open: turns
 * triangles that disagree with their neighbours where that mends it, and says whether what comes out has an inside.
 * Fills found.turned, inside_out, *_edges, and solid; numbers the edges of all. Triangles stand in the order of their
 * forms. */
void mesh_orient(mesh *m);

/* Do three points lie on one line, exactly? Coordinates below 1. */
bool mesh_points_in_line(vec3 p, vec3 q, vec3 r);

/* Puts the triangles into the order of the leaves and makes the nodes. */
void mesh_tree_build(mesh *m);

/* After that: finds the points that stand for the patches. */
void mesh_patches_build(mesh *m);

/* After the tree: finds what hangs together. */
void mesh_components_build(mesh *m);

/* After that: finds convex pieces of a solid. */
void mesh_pieces_build(mesh *m);
void mesh_pieces_destroy(mesh *m);

/* The least float that is not below x. */
static inline float float_above(double x)
{
    float f = (float)x;
    return (double)f < x ? nextafterf(f, INFINITY) : f;
}

#endif
