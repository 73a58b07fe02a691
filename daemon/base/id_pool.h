/* id_pool: small dense ids, the least free one first, so that the same commands give the same ids (determinism). */
#ifndef COLLIDED_BASE_ID_POOL_H
#define COLLIDED_BASE_ID_POOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct id_pool {
    uint64_t *words; /* bit set = taken */
    size_t word_count;
    size_t first_word; /* no free id in a word before this one */
    uint32_t taken;
    uint32_t end; /* one past the greatest id ever taken */
} id_pool;

void id_pool_init(id_pool *p);
void id_pool_free(id_pool *p);
uint32_t id_pool_take(id_pool *p);
void id_pool_give(id_pool *p, uint32_t id); /* programmer's error if it was not taken */
bool id_pool_has(const id_pool *p, uint32_t id);
uint32_t id_pool_end(const id_pool *p); /* one past the greatest that is taken now */

#endif
