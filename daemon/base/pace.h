/* pace: turns a budget of time into units of work, and keeps to it. The caller says what time it is; nothing is read
 * here. It learns what a unit takes, and how long the rest of a round takes after the work: the rest quickly when it
 * grows and slowly when it shrinks, so that a round seldom ends late. One thread. */
#ifndef COLLIDED_BASE_PACE_H
#define COLLIDED_BASE_PACE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct pace {
    int64_t limit_ns; /* of a round */
    double unit_ns;   /* learnt */
    double rest_ns;   /* learnt: from the end of the work to the end of the round */
    int64_t began_ns, last_ns;
    uint64_t last_done;
    bool granted; /* something, in this round */
} pace;

void pace_init(pace *p, int64_t limit_ns);
void pace_begin(pace *p, int64_t now_ns);
/* With `done` units done in this round: how many may be done in all. `done` itself: no more. */
uint64_t pace_grant(pace *p, int64_t now_ns, uint64_t done);
void pace_end(pace *p, int64_t now_ns, uint64_t done);

#endif
