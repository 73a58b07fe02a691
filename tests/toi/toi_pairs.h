/* toi_pairs: random moving pairs for the tests of times of impact, from a seed. */
#ifndef COLLIDED_TESTS_TOI_PAIRS_H
#define COLLIDED_TESTS_TOI_PAIRS_H

#include "cases.h"
#include "toi/toi.h"

typedef struct toi_manner {
    const char *name;
    double turn; /* rad, the most over the span */
    bool aimed;  /* at each other */
} toi_manner;

enum { TOI_STRAIGHT, TOI_TURNING, TOI_HALF_A_TURN, TOI_SPINNING, TOI_PASSING, TOI_MANNERS };
extern const toi_manner toi_manners[TOI_MANNERS];

typedef struct toi_pair {
    shape shapes[2]; /* in canonical order */
    toi_mover a, b;
    toi_request request;
    double size; /* m: of the shapes and of what they fly */
} toi_pair;

/* B flies past or through A, from one side to the other, in one second; both turn. The pair must not be copied: its
 * movers point to its shapes. False: two half-spaces, of which there is none. */
bool toi_pair_make(uint64_t seed, const toi_manner *how, shape_type a, shape_type b, toi_pair *out);

/* Any two types, by the seed. */
void toi_pair_any(uint64_t seed, const toi_manner *how, toi_pair *out);

toi_result toi_pair_find(const toi_pair *p);

#endif
