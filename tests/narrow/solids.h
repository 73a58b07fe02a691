/* solids: meshes for tests, as plain arrays: each closed and oriented outward unless its name says otherwise. */
#ifndef MESH_SOLIDS_H
#define MESH_SOLIDS_H

#include "geom/mesh.h"
#include "geom/shape.h"

enum { SOUP_MAX = 40000 };

typedef struct soup {
    double *points; /* triples */
    size_t point_count;
    int32_t *corners; /* three a triangle */
    size_t triangle_count;
} soup;

soup soup_icosphere(double radius, int subdivisions);
soup soup_box(double hx, double hy, double hz, int cuts); /* half extents; each face in cuts x cuts squares */
soup soup_torus(double ring, double tube, int around, int across);
/* A trough along y: outer half extents (1, 1, 1), walls and floor 0.25 thick, open at +z. */
soup soup_trough(void);
soup soup_plane(double half, int cuts); /* z = 0, facing up; open */
soup soup_from(const double *points, size_t count, const int32_t *corners, size_t triangle_count);
void soup_free(soup *s);

/* To make others of: room for SOUP_MAX points and triangles; the corners of a face counter-clockwise from outside. */
soup soup_new(void);
int32_t soup_point(soup *s, vec3 p);
void soup_triangle(soup *s, int32_t a, int32_t b, int32_t c);
void soup_quad(soup *s, int32_t a, int32_t b, int32_t c, int32_t d);

void soup_turn(soup *s, size_t triangle); /* its orientation */
void soup_drop(soup *s, size_t triangle);
void soup_add(soup *s, const soup *other, vec3 at);

mesh *soup_mesh(const soup *s); /* fails the test if it cannot be built */
shape mesh_shape(const mesh *m, double radius);

/* A repeatable generator. */
typedef struct dice {
    uint64_t state;
} dice;
double dice_between(dice *d, double lo, double hi);
vec3 dice_vec(dice *d, double lo, double hi); /* each coordinate */
quat dice_quat(dice *d);

#endif
