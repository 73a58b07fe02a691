/* feature: the face, side line or edge of a shape's core that faces a direction. What contact manifolds are made of.
 *
 * Pure; any thread. Discs stand for themselves as regular octagons with their corners on the rim (one on +x), and faces
 * of more than FEATURE_CORNERS_MAX corners by so many of their corners, evenly chosen: both lie within the shape. */
#ifndef COLLIDED_GEOM_FEATURE_H
#define COLLIDED_GEOM_FEATURE_H

#include "shape.h"

enum { FEATURE_CORNERS_MAX = 32 };

typedef struct feature {
    uint32_t count; /* 0: a curved spot (or unbounded); 2: a segment; 3 and more: a polygon, counter-clockwise from
                       outside */
    bool unbounded; /* a half-space's plane, through the origin */
    vec3 normal;    /* of a polygon or plane: unit, outward */
    vec3 corner[FEATURE_CORNERS_MAX];        /* in the shape's frame, on the core */
    uint32_t corner_id[FEATURE_CORNERS_MAX]; /* of the shape's vertices, whatever the direction */
    uint32_t face_id;
} feature;

/* The face or side line whose normal is nearest to `direction` (unit). */
void feature_facing(const shape *s, vec3 direction, feature *out);

/* The segment of the shape that is highest in `direction` and perpendicular to it to within `sine`. False if none is.
 */
bool feature_edge(const shape *s, vec3 direction, double sine, feature *out);

#endif
