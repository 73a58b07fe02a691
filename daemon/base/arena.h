/* arena: memory that lives until the next reset, handed out by moving a pointer. One thread at a time.
 * Blocks are kept over a reset, so that a steady use allocates nothing. */
#ifndef COLLIDED_BASE_ARENA_H
#define COLLIDED_BASE_ARENA_H

#include <stddef.h>

typedef struct arena arena;

arena *arena_create(size_t block_bytes);
void arena_destroy(arena *a);
void *arena_alloc(arena *a, size_t bytes); /* aligned to 16, not cleared, never NULL */
char *arena_strdup(arena *a, const char *text);
void arena_reset(arena *a);
size_t arena_used(const arena *a); /* bytes handed out since the last reset */

#endif
