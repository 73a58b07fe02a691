/* hull_seek: where two hulls that are apart are nearest, by the barest of searches.
 *
 * Gilbert, Johnson, Keerthi 1988, as gjk.h, but for what gjk.h proves: here are no bounds, no witnesses and no care for
 * rounding. What is proposed is worth nothing until near_features_span has proven it; and if that does, it is the
 * answer of any search, to the bit (near_features.h). Pure; any thread. */
#ifndef COLLIDED_NARROW_HULL_SEEK_H
#define COLLIDED_NARROW_HULL_SEEK_H

#include "unit_pair.h"

typedef enum hull_seek_end {
    HULL_SEEK_PROPOSES, /* *out are the features */
    HULL_SEEK_APART,    /* no more than that (all but for rounding) */
    HULL_SEEK_UNKNOWN   /* or they overlap */
} hull_seek_end;

/* For two hulls of up to HULL_SCAN_MAX vertices. `patience`: the number of axes after which it is given up unless along
 * one of them they are apart. */
hull_seek_end hull_seek(const unit_pair *p, int patience, narrow_features *out);

#endif
