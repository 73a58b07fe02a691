/* pair_map: from a 64-bit key (not 0) to a 32-bit value, by open addressing with backward-shift deletion: no
 * tombstones, so that it does not slow down over a long life. Iteration order is nobody's business: none is offered.
 * Nobody who does not see into this process can choose keys that clash. */
#ifndef COLLIDED_BASE_PAIR_MAP_H
#define COLLIDED_BASE_PAIR_MAP_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { PAIR_MAP_NONE = UINT32_MAX };

typedef struct pair_map_table {
    uint64_t *keys; /* 0 = empty */
    uint32_t *values;
    size_t capacity; /* a power of two, at most 3/4 full */
    uint64_t secret; /* which slot is whose: keys are chosen by clients, too */
} pair_map_table;

typedef struct pair_map {
    pair_map_table table, before, /* the smaller one, which is not empty yet; its keys are NULL if there is none */
        next;       /* the larger one that will be needed soon, empty; its keys are NULL if there is none */
    size_t unmoved; /* slots of `before`, from the first on */
    size_t count;
} pair_map;

/* The key of an unordered pair of ids; never 0 for different ids. */
static inline uint64_t pair_key(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

void pair_map_init(pair_map *m);
void pair_map_free(pair_map *m);
uint32_t pair_map_get(const pair_map *m, uint64_t key);       /* PAIR_MAP_NONE if absent */
bool pair_map_put(pair_map *m, uint64_t key, uint32_t value); /* true if the key is new; replaces otherwise */
uint32_t pair_map_remove(pair_map *m, uint64_t key);          /* the value it had, or PAIR_MAP_NONE */
/* Each key, in whatever order. */
void pair_map_each(const pair_map *m, void (*visit)(void *context, uint64_t key, uint32_t value), void *context);
void pair_map_trim(pair_map *m); /* gives memory back, if it is large and nearly empty */

#endif
