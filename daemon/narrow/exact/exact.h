/* exact: computes the bounds of a pair again in double-double, if doubles leave them wider than asked. Pure; any
 * thread.
 *
 * The truth is that of the shapes at the poses given, with each quaternion as given but divided by its norm. `lo` comes
 * to be the separation along the very axis that is returned, to the last bit, so it is as good as that axis can be
 * written in doubles; `hi` comes from the nearest points, or from the complete set of axes. */
#ifndef COLLIDED_NARROW_EXACT_EXACT_H
#define COLLIDED_NARROW_EXACT_EXACT_H

#include "geom/shape.h"
#include "narrow/math/dd.h"
#include "narrow/pair/unit_pair.h"

typedef struct exact_pair { /* in units of the unit_pair, in a frame of the caller's with its origin at A's */
    const unit_pair *p;
    quat qa, qb;
    dd_mat ra, rb; /* of a ball the identity; of two capsules the last columns alone */
    dd3 t;
    dd radius; /* of a plus of b */
} exact_pair;

/* Anything against a half-space; spheres against capsules, boxes, cylinders and cones; capsules, boxes and hulls among
 * each other (of hulls that overlap, `hi` stays what the search proved). Of curved pairs the search, not rounding,
 * limits both bounds. */
bool exact_applies(const unit_pair *p);

/* Prepares the pair. `a` and `b` are the shapes that `p` was made of, with poses in one frame. */
exact_pair exact_pair_of(const unit_pair *p, const shape *a, pose pose_a, const shape *b, pose pose_b);

/* Narrows r->lo and r->hi (in metres; axis and points in the frame of the exact pair) and says so in r->refined. */
void exact_narrow(const exact_pair *e, narrow_result *r);

/* Moves the two points together by the rounding of their coordinates, so that their distance proves r->hi. */
void exact_draw_together(const unit_pair *p, narrow_result *r);

#endif
