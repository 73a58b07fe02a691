/* cell_picture: what the client (cell_picture.c) learned of the cell, as the drawing (cell_picture_draw.c) takes it.
 * Plain values in SI units and the world's frame; the drawing changes nothing of them. One thread. */
#ifndef COLLIDED_EXAMPLES_CELL_PICTURE_H
#define COLLIDED_EXAMPLES_CELL_PICTURE_H

#include "collided.h"

#include <stdio.h>

typedef enum picture_kind { PICTURE_TABLE, PICTURE_ARM, PICTURE_VEHICLE, PICTURE_PART, PICTURE_KINDS } picture_kind;

enum { PICTURE_SOLIDS = 96, PICTURE_LABELS = 16, PICTURE_CONTACTS = 16, PICTURE_NAME_BYTES = 64 };

typedef struct picture_solid { /* one convex shape */
    collided_shape shape;      /* its pose: in the world */
    const double *hull;        /* points of a hull */
    size_t hull_count;
    picture_kind kind;
} picture_solid;

typedef struct picture_label {
    char name[PICTURE_NAME_BYTES];
    double at[3];
} picture_label;

typedef struct picture_gap { /* the nearest pair of arm and vehicle after one tick */
    double at_s;
    int64_t tick;
    char a[PICTURE_NAME_BYTES], b[PICTURE_NAME_BYTES];
    double lo, hi, point_a[3], point_b[3];
} picture_gap;

typedef enum picture_mark_kind { PICTURE_BEGIN, PICTURE_END, PICTURE_STOP, PICTURE_GO } picture_mark_kind;
typedef struct picture_mark {
    double at_s;
    picture_mark_kind kind;
    double lo; /* m, between arm and vehicle: of STOP and GO */
} picture_mark;

typedef struct picture {
    picture_solid solids[PICTURE_SOLIDS];
    picture_label labels[PICTURE_LABELS];
    double contacts[PICTURE_CONTACTS][3];
    size_t solid_count, label_count, contact_count;
    picture_gap shown; /* the moment of the scene */
    picture_gap *gaps; /* over the whole time, in its order */
    picture_mark *marks;
    size_t gap_count, mark_count;
    double seconds, protective_m;
} picture;

/* Writes the picture as SVG. */
void picture_draw(const picture *p, FILE *out);

#endif
