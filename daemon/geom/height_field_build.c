/* Height fields as meshes: the surface, the walls below its rim and a base cut into a fan about its middle, so that
 * each edge has two triangles that walk it in opposite directions. Any thread. */
#include "height_field.h"

#include "base/array.h"
#include "height_field_outline.h"
#include "shape.h"

#include <stdlib.h>

const char *height_field_status_text(height_field_status status)
{
    switch (status) {
    case HEIGHT_FIELD_OK:
        return "ok";
    case HEIGHT_FIELD_NO_CELL:
        return "a height field has at least 2 rows and 2 columns";
    case HEIGHT_FIELD_TOO_MANY:
        return "the height field has too many triangles: 2 a cell, and 3 for each step along its rim";
    case HEIGHT_FIELD_BAD_SPACING:
        return "the spacing of a height field must be above 0, and its ends within the limit of sizes";
    case HEIGHT_FIELD_BAD_HEIGHT:
        return "a height is not finite or beyond the limit: a height field has no holes";
    case HEIGHT_FIELD_BAD_BASE:
        return "the base of a height field must be above 0, and not so little that it is lost below its heights";
    case HEIGHT_FIELD_NO_MESH:
        return "the convex hull of the height field could not be built";
    }
    return "unknown";
}

static uint64_t rim_of(uint64_t rows, uint64_t columns)
{
    return 2 * (rows - 1) + 2 * (columns - 1);
}

uint64_t height_field_triangles(uint64_t rows, uint64_t columns)
{
    return 2 * (rows - 1) * (columns - 1) + 3 * rim_of(rows, columns);
}

static double lowest_of(const height_field *f)
{
    double lowest = INFINITY;
    size_t count = (size_t)f->rows * f->columns;
    for (size_t i = 0; i < count; i++) lowest = f->heights[i] < lowest ? f->heights[i] : lowest;
    return lowest;
}

static bool heights_are_sound(const height_field *f)
{
    size_t count = (size_t)f->rows * f->columns;
    for (size_t i = 0; i < count; i++)
        if (!(fabs(f->heights[i]) <= SHAPE_SIZE_MAX)) return false;
    return true;
}

/* Where line i of `count` stands; one rounding, and -x for the line at the other end. */
static double place(uint32_t i, uint32_t count, double spacing)
{
    return ((double)i - (double)(count - 1) / 2) * spacing;
}

static bool spacing_is_sound(double spacing, uint32_t lines)
{
    return spacing >= HEIGHT_FIELD_SPACING_MIN && place(lines - 1, lines, spacing) <= SHAPE_SIZE_MAX;
}

static height_field_status check(const height_field *f)
{
    if (f->rows < 2 || f->columns < 2) return HEIGHT_FIELD_NO_CELL;
    if (height_field_triangles(f->rows, f->columns) > MESH_TRIANGLES_MAX) return HEIGHT_FIELD_TOO_MANY;
    if (!spacing_is_sound(f->dx, f->columns) || !spacing_is_sound(f->dy, f->rows)) return HEIGHT_FIELD_BAD_SPACING;
    if (!heights_are_sound(f)) return HEIGHT_FIELD_BAD_HEIGHT;
    double lowest = lowest_of(f);
    bool thick = f->base > 0 && lowest - f->base < lowest && lowest - f->base >= -SHAPE_SIZE_MAX;
    return thick ? HEIGHT_FIELD_OK : HEIGHT_FIELD_BAD_BASE;
}

/* ---- points: the surface row by row, then the rim at the base, then the middle of the base ---- */

/* Which point of the surface is above point k of the rim, which goes round counter-clockwise seen from above, from
 * (column 0, row 0) on. */
static uint32_t above_rim(const height_field *f, uint32_t k)
{
    uint32_t right = f->columns - 1, top = f->rows - 1, column, row;
    if (k < right)
        column = k, row = 0;
    else if (k < right + top)
        column = right, row = k - right;
    else if (k < 2 * right + top)
        column = 2 * right + top - k, row = top;
    else
        column = 0, row = 2 * right + 2 * top - k;
    return row * f->columns + column;
}

static double *points_of(const height_field *f, uint32_t rim, size_t *count)
{
    uint32_t surface = f->rows * f->columns;
    double *points = base_alloc(3 * ((size_t)surface + rim + 1), sizeof *points), *to = points;
    double bottom = lowest_of(f) - f->base;
    for (uint32_t i = 0; i < surface; i++) {
        *to++ = place(i % f->columns, f->columns, f->dx);
        *to++ = place(i / f->columns, f->rows, f->dy);
        *to++ = f->heights[i];
    }
    for (uint32_t k = 0; k < rim; k++) {
        const double *above = points + 3 * (size_t)above_rim(f, k);
        *to++ = above[0];
        *to++ = above[1];
        *to++ = bottom;
    }
    *to++ = 0;
    *to++ = 0;
    *to++ = bottom;
    *count = (size_t)surface + rim + 1;
    return points;
}

/* ---- triangles, counter-clockwise seen from outside ---- */

static int32_t *put(int32_t *to, uint32_t a, uint32_t b, uint32_t c)
{
    *to++ = (int32_t)a;
    *to++ = (int32_t)b;
    *to++ = (int32_t)c;
    return to;
}

static int32_t *put_surface(const height_field *f, int32_t *to)
{
    for (uint32_t row = 0; row + 1 < f->rows; row++) {
        for (uint32_t column = 0; column + 1 < f->columns; column++) {
            uint32_t at = row * f->columns + column, across = at + f->columns + 1;
            to = put(to, at, at + 1, across);
            to = put(to, at, across, at + f->columns);
        }
    }
    return to;
}

static int32_t *corners_of(const height_field *f, uint32_t rim)
{
    int32_t *corners = base_alloc(3 * (size_t)height_field_triangles(f->rows, f->columns), sizeof *corners);
    int32_t *to = put_surface(f, corners);
    uint32_t first = f->rows * f->columns, middle = first + rim;
    for (uint32_t k = 0; k < rim; k++) {
        uint32_t next = (k + 1) % rim;
        to = put(to, first + k, first + next, above_rim(f, next));
        to = put(to, first + k, above_rim(f, next), above_rim(f, k));
        to = put(to, middle, first + next, first + k);
    }
    return corners;
}

height_field_status height_field_build(const height_field *f, mesh **out)
{
    *out = NULL;
    height_field_status status = check(f);
    if (status != HEIGHT_FIELD_OK) return status;
    uint32_t rim = (uint32_t)rim_of(f->rows, f->columns);
    size_t count;
    double *points = points_of(f, rim, &count);
    int32_t *corners = corners_of(f, rim);
    mesh_outline outline = height_field_outline(f, rim);
    mesh_status built =
        mesh_build_within(points, count, corners, (size_t)height_field_triangles(f->rows, f->columns), &outline, out);
    free((void *)outline.vertices);
    free(points);
    free(corners);
    if (built != MESH_OK) return HEIGHT_FIELD_NO_MESH;
    (*out)->rows = f->rows;
    (*out)->columns = f->columns;
    return HEIGHT_FIELD_OK;
}
