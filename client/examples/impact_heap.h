/* impact_heap: what is going to happen, the earliest first; of two at the same time the one with the lower numbers, so
 * that the order depends on nothing else. A binary heap in an array of its owner's. One thread. */
#ifndef COLLIDED_EXAMPLES_IMPACT_HEAP_H
#define COLLIDED_EXAMPLES_IMPACT_HEAP_H

#include "dynamics.h"

#include <stdbool.h>

typedef struct impact {
    double lo_s;           /* from now on: not before this */
    double gap_lo, gap_hi; /* m: the distance then */
    double closing_m_s;
    touch at; /* where they meet; at.b < 0: nobody is met, A comes to rest */
} impact;

enum { IMPACTS_MAX = 4096 };

typedef struct impact_heap {
    size_t count, dropped; /* dropped: there was no room */
    impact at[IMPACTS_MAX];
} impact_heap;

void impact_push(impact_heap *heap, impact what);
bool impact_pop(impact_heap *heap, impact *out); /* false: there is none */

#endif
