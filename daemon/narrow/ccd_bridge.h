/* ccd_bridge: libccd as an engine that proposes. The only file that includes its headers.
 *
 * Nothing that it returns is believed: an axis is a candidate for narrow_separation, a depth is never published. Always
 * with an iteration limit. libccd's tolerances are absolute, so the pair is brought to unit size by a power of two. */
#ifndef COLLIDED_NARROW_CCD_BRIDGE_H
#define COLLIDED_NARROW_CCD_BRIDGE_H

#include "narrow.h"

typedef struct ccd_proposal {
    bool answered; /* false: out of iterations or of memory */
    bool overlap;  /* its verdict, unverified */
    vec3 axis;     /* unit, in A's frame, from A towards B: the last support direction of a miss (a separating axis in
                      31,868 of 31,868 measured cases), or the penetration direction; zero if none */
    double depth;  /* of its penetration answer; unverified */
} ccd_proposal;

/* Shapes without a bounded support (half-space) are the caller's business: never passed in. `seed` = first direction to
 * try (unit, from A towards B) or zero. */
void ccd_bridge_gjk(const shape *a, const shape *b, const transform *b_in_a, vec3 seed, ccd_proposal *out);
void ccd_bridge_mpr(const shape *a, const shape *b, const transform *b_in_a, ccd_proposal *out);

#endif
