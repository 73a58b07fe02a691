/* never_meet: links that cannot meet, whatever the joints' values within their limits: with proof.
 *
 * The values of the joints between two links form a box. At the middle of a box an axis proves how far apart the links
 * are (fit_gap.h). A joint that moves by h moves no point of one side against the other by more than h times the
 * farthest point's distance from its axis (by h, if it slides), taken over the whole box, on whichever side that is
 * less. While the gap exceeds the sum of these, no values in the box let the links meet; otherwise the box is halved.
 * It is also halved, as long as boxes are plentiful, where the gap that is left is less than half of that in the
 * middle. Rounding: poses err by less than 2^-40 of the chain's length; 2^-36 of it is taken off each gap. */
#ifndef COLLIDED_LOADERS_FIT_NEVER_MEET_H
#define COLLIDED_LOADERS_FIT_NEVER_MEET_H

#include "loaders/robot.h"

typedef enum never_verdict {
    NEVER_PROVEN,
    NEVER_MEET,      /* what holds them meets to within rounding (2^-36 of the chain), at values that were found */
    NEVER_NEAR,      /* they come nearer than can be told from meeting */
    NEVER_UNDECIDED, /* out of boxes */
    NEVER_UNKNOWN    /* no range, or no convex shape: not looked at */
} never_verdict;

typedef struct never_answer {
    never_verdict verdict;
    double clearance_m; /* NEVER_PROVEN: they are never nearer than this */
    size_t boxes;       /* looked at */
    char at[1024]; /* NEVER_MEET: the joints' values, as --joints takes them; those that are not named do not matter;
                    * ends in ",..." where there is no room for all */
} never_answer;

enum { NEVER_BOXES_DEFAULT = 200000 };

/* Links a and b of u, held by convex shapes in their frames: hulls, spheres, capsules and boxes, rounded or not. */
void never_meet_find(const urdf *u, int a, const load_shape *of_a, size_t a_count, int b, const load_shape *of_b,
    size_t b_count, size_t boxes_max, never_answer *out);

const char *never_verdict_word(never_verdict verdict);

#endif
