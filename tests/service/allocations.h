/* allocations: counts what this program's own code takes from the heap (the linker's --wrap; not what libc itself takes
 * inside). Any thread; a thread that is not of subscription leaves itself out. */
#ifndef COLLIDED_TESTS_SERVICE_ALLOCATIONS_H
#define COLLIDED_TESTS_SERVICE_ALLOCATIONS_H

#include <stdbool.h>
#include <stddef.h>

size_t allocations(void);               /* so far, by all threads that are not left out */
void allocations_leave_out(bool leave); /* this thread */

#endif
