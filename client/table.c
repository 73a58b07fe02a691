/* table: open addressing with backward-shift deletion, so that no tombstones pile up however many ids come and go. */
#include "table.h"

#include "allocate.h"

#include <stdlib.h>

/* Fibonacci hashing: consecutive keys, which ids and sequences are, spread over the slots. */
static size_t home(const table *t, int64_t key)
{
    uint64_t h = (uint64_t)key * UINT64_C(0x9e3779b97f4a7c15);
    return (size_t)(h >> 32) & (t->capacity - 1);
}

static size_t find(const table *t, int64_t key)
{
    size_t i = home(t, key);
    while (t->slots[i].value && t->slots[i].key != key) i = (i + 1) & (t->capacity - 1);
    return i;
}

void *table_get(const table *t, int64_t key)
{
    return t->capacity ? t->slots[find(t, key)].value : NULL;
}

void table_fetch(const table *t, int64_t key)
{
    if (t->capacity) __builtin_prefetch(&t->slots[home(t, key)]);
}

static void grow(table *t)
{
    table bigger = {.capacity = t->capacity ? 2 * t->capacity : 16};
    bigger.slots = allocate(bigger.capacity, sizeof *bigger.slots);
    for (size_t i = 0; i < t->capacity; i++)
        if (t->slots[i].value) bigger.slots[find(&bigger, t->slots[i].key)] = t->slots[i];
    bigger.count = t->count;
    free(t->slots);
    *t = bigger;
}

void table_put(table *t, int64_t key, void *value)
{
    if (2 * (t->count + 1) > t->capacity) grow(t);
    size_t i = find(t, key);
    if (!t->slots[i].value) t->count++;
    t->slots[i] = (table_slot){key, value};
}

void table_drop(table *t, int64_t key)
{
    if (!t->capacity) return;
    size_t hole = find(t, key), mask = t->capacity - 1;
    if (!t->slots[hole].value) return;
    t->count--;
    /* Move back whatever could no longer be found with an empty slot before it. */
    for (size_t i = (hole + 1) & mask; t->slots[i].value; i = (i + 1) & mask) {
        size_t distance_to_home = (i - home(t, t->slots[i].key)) & mask;
        if (distance_to_home >= ((i - hole) & mask)) {
            t->slots[hole] = t->slots[i];
            hole = i;
        }
    }
    t->slots[hole].value = NULL;
}

void table_free(table *t)
{
    free(t->slots);
    *t = (table){0};
}
