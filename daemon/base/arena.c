/* arena: memory that lives until the next reset. One thread at a time. Between two resets full blocks queue up behind
 * the current one; a reset that finds several replaces them by one that would have held them all, so that a use that
 * repeats settles on a single block and allocates nothing. */
#include "arena.h"

#include "array.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ARENA_ALIGN = 16 }; /* bytes; what malloc gives, and what SSE loads want */

typedef struct block {
    struct block *full; /* the blocks filled before this one */
    size_t capacity, used;
    _Alignas(ARENA_ALIGN) unsigned char bytes[];
} block;

struct arena {
    block *current;
    size_t used;
};

static block *block_create(size_t capacity, block *full)
{
    if (capacity > SIZE_MAX - sizeof(block))
        capacity = SIZE_MAX - sizeof(block); /* base_alloc says that it is too much */
    block *b = base_alloc(1, sizeof(block) + capacity);
    b->full = full;
    b->capacity = capacity;
    b->used = 0;
    return b;
}

static void blocks_destroy(block *b)
{
    while (b) {
        block *full = b->full;
        free(b);
        b = full;
    }
}

arena *arena_create(size_t block_bytes)
{
    arena *a = base_zalloc(1, sizeof *a);
    a->current = block_create(block_bytes, NULL);
    return a;
}

void arena_destroy(arena *a)
{
    if (!a) return;
    blocks_destroy(a->current);
    free(a);
}

void *arena_alloc(arena *a, size_t bytes)
{
    size_t room = bytes > SIZE_MAX - ARENA_ALIGN ? bytes : (bytes + ARENA_ALIGN - 1) / ARENA_ALIGN * ARENA_ALIGN;
    block *b = a->current;
    if (room > b->capacity - b->used) {
        b = block_create(room > b->capacity ? room : b->capacity, b);
        a->current = b;
    }
    void *p = b->bytes + b->used;
    b->used += room;
    a->used += room;
    return p;
}

char *arena_strdup(arena *a, const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(arena_alloc(a, size), text, size);
}

void arena_reset(arena *a)
{
    if (a->current->full) {
        size_t total = 0;
        for (const block *b = a->current; b; b = b->full) total += b->capacity;
        blocks_destroy(a->current);
        a->current = block_create(total, NULL);
    }
    a->current->used = 0;
    a->used = 0;
}

size_t arena_used(const arena *a)
{
    return a->used;
}
