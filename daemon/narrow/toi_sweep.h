/* toi_sweep: from when on two parts of shapes can meet, by directions alone: no distance is asked. Pure; any thread.
 *
 * The span is cut into pieces so short that no gap along a direction that stands still dips much below its chord
 * (toi.h). The places at their ends are made once for all parts. Of two parts, a gap along a direction at both ends of a
 * piece tells until when it is open; from there another direction is tried, until none opens the way any further. */
#ifndef COLLIDED_NARROW_TOI_SWEEP_H
#define COLLIDED_NARROW_TOI_SWEEP_H

#include "course.h"
#include "toi_parts.h"

enum { SWEEP_PIECES_MAX = 32 };

typedef struct sweep_place { /* the frames of both shapes, in the course's frame */
    transform a, b;
    double floor; /* m: the least gap that counts as apart then, with the dip and the rounding in it */
} sweep_place;

typedef struct sweep {
    int pieces;
    double piece; /* s */
    sweep_place at[SWEEP_PIECES_MAX + 1];
} sweep;

/* False: they turn so far that it is of no use. */
bool sweep_init(sweep *s, const toi_mover *a, const toi_mover *b, const toi_request *request);

/* Given that they do not meet before `from`: a time before which they do not, either. INFINITY: not before `until`. */
double sweep_entry(const sweep *s, const toi_part *a, const toi_part *b, double from, double until);

#endif
