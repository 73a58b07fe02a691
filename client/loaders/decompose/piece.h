/* piece: what of a solid lies in a box, as a convex hull; and two such pieces as one.
 *
 * Why the hull holds it: an extreme point of the convex hull of solid and box is either on the surface, and then an
 * extreme point of a triangle cut by the box, or inside of the solid, and then a corner of the box. All of these are in
 * the hull. Rounding: each cut moves a corner by at most 16 u of the greatest coordinate; the boxes' planes are moved
 * outward by `slack` = 2^-40 of it, so that what is moved is not lost at the next cut, and the hull is rounded by
 * that radius. It suffices for 500 cuts. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_PIECE_H
#define COLLIDED_LOADERS_DECOMPOSE_PIECE_H

#include "solid.h"

typedef struct piece_plane {
    double normal[3], offset; /* unit, outward: normal . x <= offset for all points */
} piece_plane;

typedef struct piece {
    pool memory;
    double lo[3], hi[3]; /* box of the cell; of a united piece: around its points */
    double *corners;     /* of the polygons, triples; empty in a united piece */
    size_t corner_count;
    uint32_t *ends; /* of each polygon in the corners */
    size_t polygon_count;
    double *points; /* of the hull: triples, sorted, different */
    size_t point_count;
    piece_plane *planes;
    size_t plane_count;
    double volume;      /* of the hull */
    double deviation;   /* upper bound of the farthest point of the hull from the solid; set by deviate.h */
    double farthest[3]; /* a point of the hull that is about so far */
} piece;

static inline double piece_slack(const solid *s)
{
    return 0x1p-40 * s->most;
}

/* False if its hull has no inside. Whatever they return, they are freed by piece_free. */
bool piece_of_all(const solid *s, piece *out);
bool piece_cut(const solid *s, const piece *from, int axis, double at, bool above, piece *out);
bool piece_unite(const piece *a, const piece *b, piece *out);
void piece_free(piece *p);

#endif
