/* height_field_outline: which points of a height field its convex hull is made of. Used by geom/height_field_build.c
 * only. Any thread. */
#ifndef COLLIDED_GEOM_HEIGHT_FIELD_OUTLINE_H
#define COLLIDED_GEOM_HEIGHT_FIELD_OUTLINE_H

#include "height_field.h"
#include "mesh_steps.h"

enum { OUTLINE_MAX = 1 << 12 }; /* points: the hull of a curved strip of so many takes seconds */

/* Indices of points as height_field_build numbers them: the surface row by row, then `rim` points at the base, the
 * first below (0, 0), counter-clockwise. The caller frees `vertices`. A field of at most OUTLINE_MAX points is taken as
 * it is; of a larger one with more bends than that the excess says what was left out. */
mesh_outline height_field_outline(const height_field *field, uint32_t rim);

#endif
