/* clock: nanoseconds. Stamps of poses are wall-clock (they cross processes and hosts); intervals are monotonic. */
#ifndef COLLIDED_BASE_CLOCK_H
#define COLLIDED_BASE_CLOCK_H

#include <stdint.h>

int64_t clock_wall_ns(void);      /* CLOCK_REALTIME */
int64_t clock_monotonic_ns(void); /* CLOCK_MONOTONIC */
int64_t clock_thread_ns(void);    /* what this thread has had of a processor; slower to read than the others */

#endif
