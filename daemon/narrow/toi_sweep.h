/* toi_sweep: from when on two parts of shapes can meet, by directions alone: no distance is asked. Pure; any thread.
 *
 * The span is cut into pieces so short that no gap along a direction that stands still dips much below its chord
 * (toi.h). Of two parts, a gap along a direction at both ends of a piece tells until when it is open; from there
 * another direction is tried, until none opens the way any further; then the piece is cut, and what is left of it cut
 * again. The places at the ends of pieces are made when they are first needed, and kept for other parts. */
#ifndef COLLIDED_NARROW_TOI_SWEEP_H
#define COLLIDED_NARROW_TOI_SWEEP_H

#include "course.h"
#include "toi_parts.h"

enum {
    SWEEP_PIECES_MAX = 64,
    SWEEP_CUT = 4,      /* a piece into so many, ... */
    SWEEP_LONGEST = 16, /* ... twice */
    SWEEP_PLACES = 128  /* that are kept; a power of two */
};

typedef struct sweep_place { /* the frames of both shapes, in the course's frame */
    transform a, b;
    double floor; /* m: the least gap that counts as apart then, with the rounding in it */
    uint32_t index;
} sweep_place;

typedef struct sweep {
    course course;
    const toi_request *request;
    uint32_t ends, longest; /* the least pieces, and how many make up a whole one */
    double least;           /* s */
    double size;            /* m */
    sweep_place at[SWEEP_PLACES];
} sweep;

/* False: they turn so far that it is of no use. */
bool sweep_init(sweep *s, const toi_mover *a, const toi_mover *b, const toi_request *request);

/* Given that they do not meet before `from`: a time before which they do not, either. INFINITY: not before `until`.
 * *hint: a direction to try first, and then the one that went farthest; zero = none. */
double sweep_entry(sweep *s, const toi_part *a, const toi_part *b, double from, double until, vec3 *hint);

#endif
