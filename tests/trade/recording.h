/* recording: a session written into a file as the daemon would, tick by tick, without any daemon: bodies of every
 * simple shape, and some that sweep past them. */
#ifndef COLLIDED_TESTS_TRADE_RECORDING_H
#define COLLIDED_TESTS_TRADE_RECORDING_H

#include <stdbool.h>

typedef struct recording {
    int ticks;
    bool subscription; /* somebody wants to know */
    double range;      /* m: how far */
    double height;     /* m: of the way of the moving bodies above the others' */
    int again; /* so often a body is announced again on the way, in a tick of its own; in each tick, if negative */
} recording;

/* Fails the test if the file cannot be written. */
void record_session(const char *path, const recording *r);

#endif
