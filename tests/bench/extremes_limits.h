/* extremes_limits: what the daemon refuses, and with which words: the ends of the range that the project states. */
#ifndef COLLIDED_TESTS_BENCH_EXTREMES_LIMITS_H
#define COLLIDED_TESTS_BENCH_EXTREMES_LIMITS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct extremes_limit {
    const char *name;
    double value;
    bool beyond;    /* outside of the range: it must be refused */
    bool refused;   /* it is, ... */
    char text[256]; /* ... and these are the words; they name the limit */
    bool named;
} extremes_limit;

/* A limit at its last allowed value and one step beyond, and so on; how many there are is returned. */
size_t extremes_limits(extremes_limit *out, size_t room);

#endif
