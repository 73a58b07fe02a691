/* wire_memory: blocks that are kept over a reset, so that a steady stream of messages allocates nothing. One thread. */
#include "wire_lcm.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

enum { FIRST_BLOCK = 1 << 16, ALIGNMENT = 16 };

typedef struct block {
    struct block *next;
    size_t size, used;
    _Alignas(ALIGNMENT) unsigned char bytes[];
} block;

struct wire_memory {
    block *first, *current;
};

static block *new_block(size_t size)
{
    block *b = malloc(sizeof *b + size);
    if (!b) {
        fprintf(stderr, "out of memory: %zu bytes for a message\n", size);
        abort();
    }
    *b = (block){.size = size};
    return b;
}

wire_memory *wire_memory_create(void)
{
    block *b = new_block(FIRST_BLOCK);
    wire_memory *m = malloc(sizeof *m);
    if (!m) abort();
    m->first = m->current = b;
    return m;
}

void wire_memory_destroy(wire_memory *m)
{
    if (!m) return;
    for (block *b = m->first, *next; b; b = next) {
        next = b->next;
        free(b);
    }
    free(m);
}

void wire_memory_reset(wire_memory *m)
{
    for (block *b = m->first; b; b = b->next) b->used = 0;
    m->current = m->first;
}

void *wire_memory_take(wire_memory *m, size_t bytes)
{
    size_t need = (bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    while (m->current->size - m->current->used < need) {
        if (!m->current->next) m->current->next = new_block(need > 2 * m->current->size ? need : 2 * m->current->size);
        m->current = m->current->next;
    }
    void *at = m->current->bytes + m->current->used;
    m->current->used += need;
    assert(need >= bytes && m->current->used <= m->current->size);
    return at;
}
