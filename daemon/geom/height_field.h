/* height_field: ground by heights over a regular grid, made a mesh: everything between the surface and a flat base.
 *
 * Its frame: x along the columns, y along the rows, z up, metres. The grid is centred: column c stands at
 * x = (c - (columns - 1) / 2) dx, row r at y = (r - (rows - 1) / 2) dy, and z is the height as it is given, bit for
 * bit. Each cell is two triangles, cut by its diagonal from (column, row) to (column + 1, row + 1). The base lies
 * `base` below the lowest height; walls close the sides. So the mesh is a solid, closed by construction, and all that
 * holds of meshes (distances, depths, manifolds without a mark of inner edges) holds of it. Its convex hull is that of
 * its points, but for large ground with many bends, of which hull->excess tells what is left out. */
#ifndef COLLIDED_GEOM_HEIGHT_FIELD_H
#define COLLIDED_GEOM_HEIGHT_FIELD_H

#include "mesh.h"

#define HEIGHT_FIELD_SPACING_MIN 1e-150 /* squares of it must not vanish */

typedef struct height_field {
    uint32_t rows, columns; /* at least 2 each */
    double dx, dy;          /* between columns, and between rows */
    double base;            /* thickness below the lowest height, above 0 */
    const double *heights;  /* rows x columns, row by row, the one with the least y first; borrowed */
} height_field;

typedef enum height_field_status {
    HEIGHT_FIELD_OK,
    HEIGHT_FIELD_NO_CELL,     /* fewer than 2 rows or columns */
    HEIGHT_FIELD_TOO_MANY,    /* its mesh would have more than MESH_TRIANGLES_MAX triangles */
    HEIGHT_FIELD_BAD_SPACING, /* below HEIGHT_FIELD_SPACING_MIN, or so wide that the grid ends beyond SHAPE_SIZE_MAX */
    HEIGHT_FIELD_BAD_HEIGHT,  /* NaN (there are no holes), infinite, or beyond SHAPE_SIZE_MAX */
    HEIGHT_FIELD_BAD_BASE,    /* not above 0, not finite, or lost in the rounding of the lowest height */
    HEIGHT_FIELD_NO_MESH      /* its convex hull could not be built */
} height_field_status;

/* Triangles of the mesh: two a cell, and for each step along the rim two of the wall and one of the base. At most 2^32
 * rows and columns. */
uint64_t height_field_triangles(uint64_t rows, uint64_t columns);

/* On HEIGHT_FIELD_OK *out is owned by the caller, who frees it by mesh_destroy; its `rows` and `columns` tell what it
 * was made of. Triangle 2 (row (columns - 1) + column) of the input is the cell's half with the lesser y, the next one
 * the other half. The same input gives the same mesh. */
height_field_status height_field_build(const height_field *field, mesh **out);
const char *height_field_status_text(height_field_status status);

#endif
