/* triangles: geometries as triangles, for viewers that draw nothing else: of a mesh as its client sent them, of a hull
 * those around its points (qhull), of a height field two a cell. Kept under the mirror's numbers. One thread. */
#ifndef COLLIDED_WINDOW_TRIANGLES_H
#define COLLIDED_WINDOW_TRIANGLES_H

#include "collided.h"

#include <stdint.h>

typedef struct triangles {
    bool known;        /* as far as it can be: a hull of points in a plane has none */
    double *points;    /* three each, m */
    uint32_t *indices; /* three a triangle, counter-clockwise seen from outside */
    size_t point_count, index_count;
} triangles;

typedef struct triangles_kept { /* zeros = none */
    triangles *at;
    size_t count, capacity;
} triangles_kept;

void triangles_make(triangles *t, const collided_geometry_numbers *numbers); /* t: zeros */
void triangles_free(triangles *t);

void triangles_put(triangles_kept *k, uint32_t number, const collided_geometry_numbers *numbers);
const triangles *triangles_get(const triangles_kept *k, uint32_t number); /* NULL: not known yet */
void triangles_free_all(triangles_kept *k);

#endif
