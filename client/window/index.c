/* index: see index.h. */
#include "index.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct entry {
    uint64_t key;
    int64_t place; /* FREE, or a place */
} entry;

enum { FREE = -1, FIRST = 64 };

struct mirror_index {
    entry *at;
    size_t capacity, count; /* capacity: a power of two */
};

static void *checked(void *at)
{
    if (at) return at;
    fprintf(stderr, "collided-web: no memory left\n");
    abort();
}

void *web_allocate(size_t count, size_t size)
{
    return checked(calloc(count ? count : 1, size));
}

void *web_reserve(void *at, size_t *capacity, size_t count, size_t size)
{
    if (count <= *capacity && at) return at;
    size_t more = *capacity * 2 > count ? *capacity * 2 : count;
    if (more < 16) more = 16;
    at = checked(reallocarray(at, more, size));
    *capacity = more;
    return at;
}

static entry *table_of(size_t capacity)
{
    entry *at = web_allocate(capacity, sizeof *at);
    for (size_t i = 0; i < capacity; i++) at[i].place = FREE;
    return at;
}

mirror_index *index_create(void)
{
    mirror_index *x = web_allocate(1, sizeof *x);
    x->capacity = FIRST;
    x->at = table_of(x->capacity);
    return x;
}

void index_destroy(mirror_index *x)
{
    if (x) free(x->at);
    free(x);
}

void index_clear(mirror_index *x)
{
    for (size_t i = 0; i < x->capacity; i++) x->at[i].place = FREE;
    x->count = 0;
}

uint64_t index_mix(uint64_t h, uint64_t word)
{
    h = (h ^ word) * UINT64_C(0x9E3779B97F4A7C15);
    return h ^ h >> 29;
}

uint64_t index_mix_text(uint64_t h, const char *text)
{
    for (; *text; text++) h = (h ^ (unsigned char)*text) * UINT64_C(1099511628211);
    return index_mix(h, 1);
}

static size_t home_of(const mirror_index *x, uint64_t key)
{
    return (size_t)(index_mix(0, key) >> 7) & (x->capacity - 1);
}

static size_t slot_of(const mirror_index *x, uint64_t key)
{
    size_t i = home_of(x, key);
    while (x->at[i].place != FREE && x->at[i].key != key) i = (i + 1) & (x->capacity - 1);
    return i;
}

static void grow(mirror_index *x)
{
    mirror_index old = *x;
    x->capacity *= 2;
    x->at = table_of(x->capacity);
    for (size_t i = 0; i < old.capacity; i++)
        if (old.at[i].place != FREE) x->at[slot_of(x, old.at[i].key)] = old.at[i];
    free(old.at);
}

void index_put(mirror_index *x, uint64_t key, int64_t place)
{
    if (2 * (x->count + 1) > x->capacity) grow(x);
    entry *e = &x->at[slot_of(x, key)];
    x->count += e->place == FREE;
    *e = (entry){key, place};
}

int64_t index_get(const mirror_index *x, uint64_t key)
{
    return x->at[slot_of(x, key)].place;
}

/* What follows in the same run moves up, so that no run has a gap. */
void index_drop(mirror_index *x, uint64_t key)
{
    size_t hole = slot_of(x, key), mask = x->capacity - 1;
    if (x->at[hole].place == FREE) return;
    x->count--;
    for (size_t i = (hole + 1) & mask; x->at[i].place != FREE; i = (i + 1) & mask) {
        size_t home = home_of(x, x->at[i].key);
        if (((i - home) & mask) < ((i - hole) & mask)) continue;
        x->at[hole] = x->at[i];
        hole = i;
    }
    x->at[hole].place = FREE;
}
