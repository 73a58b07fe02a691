/* index: from 64-bit keys to places, open addressing with linear probing. One thread. */
#ifndef COLLIDED_WINDOW_INDEX_H
#define COLLIDED_WINDOW_INDEX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct mirror_index mirror_index;

mirror_index *index_create(void);
void index_destroy(mirror_index *x);
void index_clear(mirror_index *x);
void index_put(mirror_index *x, uint64_t key, int64_t place); /* instead of what was under that key */
int64_t index_get(const mirror_index *x, uint64_t key);       /* -1: nothing */
void index_drop(mirror_index *x, uint64_t key);
uint64_t index_mix(uint64_t h, uint64_t word); /* for keys of several words */
uint64_t index_mix_text(uint64_t h, const char *text);

/* Memory that is there, or the process ends. */
void *web_allocate(size_t count, size_t size); /* zeros */
void *web_reserve(void *at, size_t *capacity, size_t count, size_t size);

#endif
