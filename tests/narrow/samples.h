/* samples: random pairs of every two convex types with the unit in the last place of their size, and how they are
 * asked. Shared by the tests of this folder. */
#ifndef STABILITY_SAMPLES_H
#define STABILITY_SAMPLES_H

#include "cases.h"

typedef struct sample {
    shape a, b;
    pose pa, pb;
    double size; /* m: reaches (of what is finite) and the distance of the origins */
    double ulp;  /* of the size */
} sample;

/* May two answers about the same have these middles? Up to the slack, always; up to half of both widths, in two
 * comparisons of ten thousand (55 of 365,130 were counted, up to three of a pair): there a search among curved shapes
 * ended early, and its interval says so. Counts the latter. */
bool sample_agrees(const narrow_result *x, const narrow_result *y, double slack);

/* What may differ between two answers about what is the same but for rounding: 4 ulp of gaps and of the depths of
 * polytopes and half-spaces, 16 ulp of the depths of curved shapes (narrow.h promises as much on each side). */
double sample_slack(const sample *s, const narrow_result *r);

unsigned samples_each(void); /* pairs of two types; fewer with COLLIDED_BRIEF, more with COLLIDED_NIGHTLY */
sample sample_of(int type_a, int type_b, unsigned i);
void sample_measure(sample *s); /* sets size and ulp again, after a change */
const char *sample_name(const sample *s);

narrow_result sample_ask(const sample *s); /* as narrow as it goes */
double middle(const narrow_result *r);

#endif
