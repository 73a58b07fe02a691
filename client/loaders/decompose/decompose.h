/* decompose: a concave mesh as a few convex hulls, with proof of how well they fit.
 *
 * The union of the hulls, each rounded by `radius` (rounding errors: 2^-40 of the greatest coordinate), contains the
 * solid that the mesh encloses; no point of a hull is farther from the solid than that hull's deviation. The solid is
 * cut by planes along the axes, best first, and the parts are united again where it costs nothing: the scheme of Mamou
 * and Ghorbel, "A simple and efficient approach for 3D mesh approximate convex decomposition", 2009 (V-HACD), and of
 * Wei et al., "Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree Search", 2022,
 * which measures concavity as distance; the bound of the distance is our own (deviate.c).
 *
 * The same mesh and options give the same hulls: nothing depends on a clock. Lengths in the mesh's unit (m). */
#ifndef COLLIDED_LOADERS_DECOMPOSE_H
#define COLLIDED_LOADERS_DECOMPOSE_H

#include "loaders/mesh.h"

enum {
    DECOMPOSE_PIECES_DEFAULT = 16,
    DECOMPOSE_PIECES_MAX = 128,
    DECOMPOSE_TRIANGLES_MAX = 200000 /* beyond it: simplify the mesh first */
};

/* Without a target: hulls that fit better than this part of the box's diagonal are not cut any further. */
#define DECOMPOSE_FINE_RATIO 0x1p-9

typedef struct decompose_options {
    size_t pieces_max;  /* 1 to DECOMPOSE_PIECES_MAX; 0 = the default */
    double deviation_m; /* stop when no hull's is larger; 0 = DECOMPOSE_FINE_RATIO of the diagonal */
    const char *name;   /* of the mesh, for messages */
} decompose_options;

typedef struct decompose_hull {
    mesh_points points;
    double deviation_m; /* a bound with proof, at most 1 % above a distance that occurs, or above 1/512 of the
                           diagonal, unless the search took too long; then it is larger, never wrong */
} decompose_hull;

typedef struct decomposition {
    decompose_hull *hulls;
    size_t count;
    double radius;      /* rounding of every hull */
    double deviation_m; /* the largest of the hulls' */
    bool closed;        /* false: the mesh has no inside. It is one hull then, and its deviation is the distance from
                           the triangles */
    size_t united, dropped; /* repaired: corners at the place of another; triangles without area, that others
                               cover */
} decomposition;

/* False, with the reason in the report, if the mesh is flat or larger than DECOMPOSE_TRIANGLES_MAX. An open mesh is
 * warned of. `out` is in the pool. One thread a pool. */
bool decompose_mesh(
    pool *p, const mesh_triangles *mesh, const decompose_options *options, decomposition *out, load_report *r);

#endif
