/* allocate: allocation that cannot fail. A client that has no memory left cannot keep its promise to announce its
 * bodies again, so the process ends with a line that says so. Any thread. */
#ifndef COLLIDED_CLIENT_ALLOCATE_H
#define COLLIDED_CLIENT_ALLOCATE_H

#include <stddef.h>

void *allocate(size_t count, size_t size);
void *allocate_aligned(size_t alignment, size_t count, size_t size); /* not zeroed */
void *reallocate(void *old, size_t count, size_t size);              /* `count` * `size` must not wrap: checked */
char *duplicate(const char *text);                                   /* as strdup */

/* Makes room for `count` elements in the array *at of *capacity elements, at least doubling. */
void *reserve(void *at, size_t *capacity, size_t count, size_t size);

#endif
