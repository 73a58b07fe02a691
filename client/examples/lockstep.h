/* lockstep: a simulator's side of the daemon. It publishes where the bodies are and how they move, with the number of
 * the step, and waits until the daemon has told all that follows from that step: what will meet, and when, and where
 * bodies touch already. One round trip; nothing depends on how long it takes. One thread. */
#ifndef COLLIDED_EXAMPLES_LOCKSTEP_H
#define COLLIDED_EXAMPLES_LOCKSTEP_H

#include "example.h"
#include "impact_heap.h"

enum { LOCKSTEP_BODIES = 32, LOCKSTEP_TOUCHES = 1024 };

typedef struct lockstep_terms {
    double horizon_s;   /* impacts are predicted for so long */
    double tolerance_m; /* of the distance at which bodies are when an impact is reported */
    double margin_m;    /* where they are nearer than this, touches tell; 0: where they are in each other */
} lockstep_terms;

typedef struct lockstep {
    const example *options;
    collided *client;
    rigid bodies[LOCKSTEP_BODIES]; /* first those that move */
    collided_body handles[LOCKSTEP_BODIES];
    size_t count, moving;
    int64_t step, answered[2]; /* by the streams of impacts and of touches */
    long round_trips;
    int64_t begin_ns;                /* of example_now_ns, when all bodies were there */
    double deepest_m;                /* how deep one body was in another, of all that was reported */
    impact_heap heap;                /* answer: what is predicted, nearest first */
    touch touches[LOCKSTEP_TOUCHES]; /* answer: where bodies touch, in the order of their numbers */
    size_t touch_count;
    bool lost; /* more was told than there is room for, or a name that is not ours */
} lockstep;

/* Connects, and creates the fixed or moving body `rigid` and its shape; all moving ones first. */
bool lockstep_connect(lockstep *l, const example *e);
void lockstep_body(lockstep *l, rigid body, collided_shape shape, double acceleration_m_s2);
bool lockstep_begin(lockstep *l, const lockstep_terms *terms); /* when all bodies are there */

/* Publishes all moving bodies, with these velocities instead of their own where `linear` is not NULL, and fills the
 * answer. False, and a message, if none came. */
bool lockstep_ask(lockstep *l, const vector *linear);

#endif
