/* mesh: the points of a mesh file (STL, OBJ, COLLADA, PLY and whatever else assimp reads), for its convex hull, or its
 * triangles. All meshes of the file, under the transforms of its nodes, then scaled. One thread a pool. */
#ifndef COLLIDED_LOADERS_MESH_H
#define COLLIDED_LOADERS_MESH_H

#include "pool.h"
#include "report.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    MESH_VERTICES_MAX = 1 << 22,
    MESH_POINTS_MAX = 65535,   /* different points: as many as the daemon takes in a hull */
    MESH_NUMBERS_MAX = 1 << 24 /* of points and indices, in a mesh that is not made a hull: WIRE_GEOMETRY_MAX */
};

typedef struct mesh_points {
    const double *at; /* x, y, z each; no two alike; sorted, so that the same points always give the same geometry */
    size_t count;
} mesh_points;

typedef struct mesh_triangles { /* in the order of the file; polygons of more corners are cut into triangles */
    const double *points;
    size_t point_count;
    const int32_t *corners; /* three a triangle */
    size_t count;
} mesh_triangles;

/* Both read only that one file: parts that it refers to are not looked for. */
bool mesh_load(pool *p, const char *path, const double scale[3], mesh_points *out, load_report *r);
bool mesh_load_triangles(pool *p, const char *path, const double scale[3], mesh_triangles *out, load_report *r);

#endif
