/* fields: height fields for tests, and the same ground as triangles that are made another way. */
#ifndef MESH_FIELDS_H
#define MESH_FIELDS_H

#include "geom/height_field.h"
#include "solids.h"

enum { FIELD_MAX = 64 * 64 };

typedef struct field {
    height_field it;
    double heights[FIELD_MAX];
} field;

/* Heights between `lo` and `hi`, at random; spacing and base too. */
void field_random(field *f, dice *d, uint32_t rows, uint32_t columns, double lo, double hi);
/* a + b x + c y at the points of the grid. */
void field_plane(field *f, uint32_t rows, uint32_t columns, double spacing, double a, double b, double c);

mesh *field_mesh(const field *f); /* fails the test if it cannot be built */

/* Surface, walls and base, counter-clockwise seen from outside; each triangle has corners of its own, and the base is
 * two triangles. */
soup field_soup(const field *f);

/* The height of the surface above (x, y), which must be within the grid. */
double field_height(const field *f, double x, double y);

#endif
