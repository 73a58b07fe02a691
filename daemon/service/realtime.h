/* realtime: what the operator may ask of the kernel for a steady answer: memory that is never paged out, a priority
 * above all ordinary programs, and processors of its own. Main thread, before any other starts: threads inherit all of
 * it, the gateway its priority and processors. */
#ifndef COLLIDED_SERVICE_REALTIME_H
#define COLLIDED_SERVICE_REALTIME_H

#include "config.h"

#include <sched.h>

/* EX_OK, or the status with one line in `why` that says what was refused and what to do. Asked for nothing, it does
 * nothing. */
int realtime_apply(const config *c, char *why, size_t why_size);

/* The processors of a list like "2,4-7"; false with a line in `why`: it is none, or names one that no set holds. */
bool realtime_processors(const char *list, cpu_set_t *set, char *why, size_t why_size);

#endif
