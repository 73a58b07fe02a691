/* pair_map: linear probing over a power of two of slots. One thread at a time. Between two calls no empty slot lies
 * between a key's home slot and the slot that it is in, which is all that a look-up relies on; a removal restores it by
 * shifting later keys back, so nothing is left behind that a long life could gather (Knuth, vol. 3, 6.4, algorithm R).
 */
#include "pair_map.h"

#include "array.h"

#include <assert.h>
#include <stdlib.h>

enum { FIRST_CAPACITY = 64 };

/* The finaliser of MurmurHash3: ids are dense and neighbours, slots must not be. */
static size_t home_of(const pair_map *m, uint64_t key)
{
    key ^= key >> 33;
    key *= UINT64_C(0xff51afd7ed558ccd);
    key ^= key >> 33;
    key *= UINT64_C(0xc4ceb9fe1a85ec53);
    key ^= key >> 33;
    return (size_t)key & (m->capacity - 1);
}

/* The slot that holds the key, or the empty one where it belongs. There is always an empty one. */
static size_t find_slot(const pair_map *m, uint64_t key)
{
    assert(m->count < m->capacity);
    size_t slot = home_of(m, key);
    while (m->keys[slot] != 0 && m->keys[slot] != key) slot = (slot + 1) & (m->capacity - 1);
    return slot;
}

void pair_map_init(pair_map *m)
{
    *m = (pair_map){0};
}

void pair_map_free(pair_map *m)
{
    free(m->keys);
    free(m->values);
    *m = (pair_map){0};
}

static void rehash(pair_map *m, size_t capacity)
{
    pair_map old = *m;
    m->capacity = capacity;
    m->keys = base_zalloc(capacity, sizeof *m->keys);
    m->values = base_alloc(capacity, sizeof *m->values);
    for (size_t i = 0; i < old.capacity; i++) {
        if (old.keys[i] == 0) continue;
        size_t slot = find_slot(m, old.keys[i]);
        m->keys[slot] = old.keys[i];
        m->values[slot] = old.values[i];
    }
    free(old.keys);
    free(old.values);
}

uint32_t pair_map_get(const pair_map *m, uint64_t key)
{
    assert(key != 0);
    if (m->count == 0) return PAIR_MAP_NONE;
    size_t slot = find_slot(m, key);
    return m->keys[slot] == key ? m->values[slot] : (uint32_t)PAIR_MAP_NONE;
}

bool pair_map_put(pair_map *m, uint64_t key, uint32_t value)
{
    assert(key != 0);
    if (m->count + 1 > m->capacity / 4 * 3) rehash(m, m->capacity ? m->capacity * 2 : FIRST_CAPACITY);
    size_t slot = find_slot(m, key);
    bool is_new = m->keys[slot] == 0;
    m->keys[slot] = key;
    m->values[slot] = value;
    m->count += is_new;
    return is_new;
}

/* Close the hole: a later key of the same run moves in if its home is not after the hole. */
static void close_hole(pair_map *m, size_t hole)
{
    size_t mask = m->capacity - 1;
    for (size_t next = (hole + 1) & mask; m->keys[next] != 0; next = (next + 1) & mask) {
        size_t home = home_of(m, m->keys[next]);
        if (((next - home) & mask) < ((next - hole) & mask)) continue;
        m->keys[hole] = m->keys[next];
        m->values[hole] = m->values[next];
        hole = next;
    }
    m->keys[hole] = 0;
}

uint32_t pair_map_remove(pair_map *m, uint64_t key)
{
    assert(key != 0);
    if (m->count == 0) return PAIR_MAP_NONE;
    size_t slot = find_slot(m, key);
    if (m->keys[slot] != key) return PAIR_MAP_NONE;
    uint32_t value = m->values[slot];
    close_hole(m, slot);
    m->count--;
    return value;
}

void pair_map_trim(pair_map *m)
{
    size_t enough = FIRST_CAPACITY;
    while (enough / 4 < m->count) enough *= 2;
    if (m->capacity / 4 < enough || m->capacity * (sizeof *m->keys + sizeof *m->values) < ARRAY_SPARE_BYTES) return;
    rehash(m, enough);
}
