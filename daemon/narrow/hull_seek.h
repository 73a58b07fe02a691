/* hull_seek: where two hulls that are apart are nearest, or where they overlap, by the barest of searches.
 *
 * Gilbert, Johnson, Keerthi 1988, as gjk.h, but for what gjk.h proves: here are no bounds, no witnesses and no care for
 * rounding. What is proposed is worth nothing until near_features_span has proven it; and if that does, it is the
 * answer of any search, to the bit (near_features.h). Of four corners it is asked of each facet whether it has the
 * origin on its inner side (polytope_depth.h). Pure; any thread. */
#ifndef COLLIDED_NARROW_HULL_SEEK_H
#define COLLIDED_NARROW_HULL_SEEK_H

#include "unit_pair.h"

typedef enum hull_seek_end {
    HULL_SEEK_PROPOSES, /* *out are the features */
    HULL_SEEK_APART,    /* no more than that (all but for rounding) */
    HULL_SEEK_INSIDE,   /* *holds: four corners of B - A with the origin between them */
    HULL_SEEK_UNKNOWN
} hull_seek_end;

typedef struct hull_corners { /* by the vertices that they are made of (box_corner) */
    uint16_t a[4], b[4];
} hull_corners;

enum { HULL_SEEK_ON = 1 << 20 }; /* a patience without end */

/* For two hulls of up to HULL_SCAN_MAX vertices, or a box and such a hull. `patience`: the number of axes after which
 * it is given up unless along one of them they are apart. Unless it `proposes`, it ends as soon as they are. */
hull_seek_end hull_seek(const unit_pair *p, int patience, bool proposes, narrow_features *out, hull_corners *holds);

#endif
