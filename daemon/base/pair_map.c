/* pair_map: linear probing over a power of two of slots. One thread at a time. Between two calls no empty slot lies
 * between a key's home slot and the slot that it is in, which is all that a look-up relies on; a removal restores it by
 * shifting later keys back, so nothing is left behind that a long life could gather (Knuth, vol. 3, 6.4, algorithm R).
 *
 * A large map that grows does not move all its keys at once, which would take a tick of tens of milliseconds: the
 * smaller table stays beside the larger one, a key is in one of the two, and each change moves some more. The larger
 * one is made before it is needed, so that another thread has touched its memory by then (ahead.h): the first keys lie
 * anywhere in it, which would be all of its pages within a tick. */
#include "pair_map.h"

#include "ahead.h"
#include "array.h"
#include "secret.h"

#include <assert.h>
#include <stdlib.h>

enum {
    FIRST_CAPACITY = 64,
    LARGE = 1 << 14, /* slots: what has fewer is moved at once */
    MOVES = 8        /* slots of the smaller table that a change empties: it is empty long before the next growth */
};

/* The finaliser of MurmurHash3: ids are dense and neighbours, slots must not be. It can be turned round, so what goes
 * in is not the key alone: else who chooses keys could have all of them in one slot. */
static size_t home_of(const pair_map_table *t, uint64_t key)
{
    key ^= t->secret;
    key ^= key >> 33;
    key *= UINT64_C(0xff51afd7ed558ccd);
    key ^= key >> 33;
    key *= UINT64_C(0xc4ceb9fe1a85ec53);
    key ^= key >> 33;
    return (size_t)key & (t->capacity - 1);
}

/* The slot that holds the key, or the empty one where it belongs. There is always an empty one. */
static size_t find_slot(const pair_map_table *t, uint64_t key)
{
    size_t slot = home_of(t, key);
    while (t->keys[slot] != 0 && t->keys[slot] != key) slot = (slot + 1) & (t->capacity - 1);
    return slot;
}

static pair_map_table make_table(size_t capacity)
{
    return (pair_map_table){
        base_zalloc(capacity, sizeof(uint64_t)), base_alloc(capacity, sizeof(uint32_t)), capacity, secret()};
}

static void free_table(pair_map_table *t)
{
    free(t->keys);
    free(t->values);
    *t = (pair_map_table){0};
}

void pair_map_init(pair_map *m)
{
    *m = (pair_map){0};
}

void pair_map_free(pair_map *m)
{
    free_table(&m->table);
    free_table(&m->before);
    free_table(&m->next);
    *m = (pair_map){0};
}

static void put_new(pair_map_table *t, uint64_t key, uint32_t value)
{
    size_t slot = find_slot(t, key);
    t->keys[slot] = key;
    t->values[slot] = value;
}

/* Close the hole: a later key of the same run moves in if its home is not after the hole. */
static void close_hole(pair_map_table *t, size_t hole)
{
    size_t mask = t->capacity - 1;
    for (size_t next = (hole + 1) & mask; t->keys[next] != 0; next = (next + 1) & mask) {
        size_t home = home_of(t, t->keys[next]);
        if (((next - home) & mask) < ((next - hole) & mask)) continue;
        t->keys[hole] = t->keys[next];
        t->values[hole] = t->values[next];
        hole = next;
    }
    t->keys[hole] = 0;
}

/* From the last slot to the first. Where a run of keys goes around the end, its later ones move back into a slot that
 * has been emptied: it is looked at until it stays empty. */
static void move_some(pair_map *m, size_t slots)
{
    pair_map_table *from = &m->before;
    for (; from->keys && slots; slots--) {
        size_t slot = m->unmoved - 1;
        while (from->keys[slot]) {
            put_new(&m->table, from->keys[slot], from->values[slot]);
            close_hole(from, slot);
        }
        if (--m->unmoved == 0) free_table(from);
    }
}

static void rehash(pair_map *m, size_t capacity)
{
    move_some(m, SIZE_MAX);
    m->before = m->table;
    if (m->next.capacity != capacity) free_table(&m->next);
    m->table = m->next.keys ? m->next : make_table(capacity);
    m->next = (pair_map_table){0};
    m->unmoved = m->before.capacity;
    move_some(m, m->before.capacity < LARGE ? SIZE_MAX : 0);
}

/* When it is half full; it grows at three quarters. */
static void make_next(pair_map *m)
{
    size_t capacity = m->table.capacity;
    if (capacity < LARGE || m->next.keys || m->count < capacity / 2) return;
    m->next = make_table(2 * capacity);
    ahead_touch(m->next.keys, m->next.capacity * sizeof *m->next.keys);
    ahead_touch(m->next.values, m->next.capacity * sizeof *m->next.values);
}

static void begin_change(pair_map *m)
{
    if (m->before.keys) move_some(m, MOVES);
}

uint32_t pair_map_get(const pair_map *m, uint64_t key)
{
    assert(key != 0);
    if (m->count == 0) return PAIR_MAP_NONE;
    size_t slot = find_slot(&m->table, key);
    if (m->table.keys[slot] == key) return m->table.values[slot];
    if (!m->before.keys) return PAIR_MAP_NONE;
    slot = find_slot(&m->before, key);
    return m->before.keys[slot] == key ? m->before.values[slot] : (uint32_t)PAIR_MAP_NONE;
}

static uint32_t take_from(pair_map_table *t, uint64_t key)
{
    size_t slot = find_slot(t, key);
    if (t->keys[slot] != key) return PAIR_MAP_NONE;
    uint32_t value = t->values[slot];
    close_hole(t, slot);
    return value;
}

bool pair_map_put(pair_map *m, uint64_t key, uint32_t value)
{
    assert(key != 0);
    begin_change(m);
    if (m->count + 1 > m->table.capacity / 4 * 3) rehash(m, m->table.capacity ? m->table.capacity * 2 : FIRST_CAPACITY);
    bool was_before = m->before.keys && take_from(&m->before, key) != PAIR_MAP_NONE;
    size_t slot = find_slot(&m->table, key);
    bool is_new = m->table.keys[slot] == 0 && !was_before;
    m->table.keys[slot] = key;
    m->table.values[slot] = value;
    m->count += is_new;
    make_next(m);
    return is_new;
}

uint32_t pair_map_remove(pair_map *m, uint64_t key)
{
    assert(key != 0);
    if (m->count == 0) return PAIR_MAP_NONE;
    begin_change(m);
    uint32_t value = take_from(&m->table, key);
    if (value == PAIR_MAP_NONE && m->before.keys) value = take_from(&m->before, key);
    m->count -= value != PAIR_MAP_NONE;
    return value;
}

void pair_map_each(const pair_map *m, void (*visit)(void *context, uint64_t key, uint32_t value), void *context)
{
    const pair_map_table *const both[2] = {&m->table, &m->before};
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < both[k]->capacity; i++)
            if (both[k]->keys[i]) visit(context, both[k]->keys[i], both[k]->values[i]);
}

void pair_map_trim(pair_map *m)
{
    free_table(&m->next);
    size_t enough = FIRST_CAPACITY, capacity = m->table.capacity;
    while (enough / 4 < m->count) enough *= 2;
    if (capacity / 4 < enough || capacity * (sizeof(uint64_t) + sizeof(uint32_t)) < ARRAY_SPARE_BYTES) return;
    rehash(m, enough);
    move_some(m, SIZE_MAX);
}
