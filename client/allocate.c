/* allocate: calloc and realloc that end the process with a reason instead of returning NULL. */
#include "allocate.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void *must(void *p, size_t count, size_t size)
{
    if (p) return p;
    (void)fprintf(stderr, "collided: out of memory for %zu times %zu bytes\n", count, size);
    abort();
}

void *allocate(size_t count, size_t size)
{
    return must(calloc(count ? count : 1, size), count, size);
}

void *allocate_aligned(size_t alignment, size_t count, size_t size)
{
    size_t bytes;
    bool wraps = __builtin_mul_overflow(count, size, &bytes) || bytes > SIZE_MAX - alignment;
    return must(wraps ? NULL : aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment), count, size);
}

void *reallocate(void *old, size_t count, size_t size)
{
    return must(reallocarray(old, count ? count : 1, size), count, size);
}

void *reserve(void *at, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity) return at;
    size_t room = *capacity ? *capacity : 16;
    while (room < count) room = room > SIZE_MAX / 2 ? count : 2 * room;
    *capacity = room;
    return reallocate(at, room, size);
}

char *duplicate(const char *text)
{
    return must(strdup(text), strlen(text) + 1, 1);
}
