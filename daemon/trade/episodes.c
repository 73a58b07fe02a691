/* episodes: see episodes.h. One thread. */
#include "episodes.h"

#include "base/hash.h"
#include "meter.h"

#include <stdlib.h>
#include <string.h>

void episodes_init(episodes *e)
{
    *e = (episodes){.bytes = 0};
    pair_map_init(&e->open);
    e->pair_events = base_zalloc(METER_PAIRS + 1, sizeof *e->pair_events);
    e->pair_bytes = base_zalloc(METER_PAIRS + 1, sizeof *e->pair_bytes);
}

void episodes_free(episodes *e)
{
    array_free(&e->at);
    pair_map_free(&e->open);
    free(e->pair_events);
    free(e->pair_bytes);
}

/* ---- taking what was reported ---- */

static bool begins(uint8_t kind)
{
    return kind == EVENT_BEGIN || kind == EVENT_NEAR || kind == EVENT_IMPACT || kind == EVENT_PREDICTED;
}

static bool ends(uint8_t kind)
{
    return kind == EVENT_END || kind == EVENT_FAR || kind == EVENT_IMPACT || kind == EVENT_AVERTED;
}

/* In a snapshot contacts stand as updates. */
static uint8_t fact_of(uint8_t kind)
{
    return kind == EVENT_UPDATE ? EVENT_BEGIN : kind;
}

static uint64_t key_of(const wire_event_batch *m, size_t i, uint8_t fact)
{
    uint64_t h = HASH_START;
    h = hash_bytes(h, &m->client, sizeof m->client);
    h = hash_bytes(h, &m->subscription, sizeof m->subscription);
    h = hash_bytes(h, &fact, sizeof fact);
    h = hash_bytes(h, m->names_a.at[i], strlen(m->names_a.at[i]) + 1);
    h = hash_bytes(h, m->names_b.at[i], strlen(m->names_b.at[i]) + 1);
    h = hash_bytes(h, &m->shapes_a.at[i], sizeof *m->shapes_a.at);
    return hash_bytes(h, &m->shapes_b.at[i], sizeof *m->shapes_b.at);
}

static size_t begin(episodes *e, const world *w, const wire_event_batch *m, size_t i)
{
    size_t pair = meter_pair(world_shape_type(w, m->names_a.at[i], m->shapes_a.at[i]),
        world_shape_type(w, m->names_b.at[i], m->shapes_b.at[i]));
    array_push(&e->at, ((episode){key_of(m, i, fact_of(m->kinds.at[i])), m->tick, INT64_MAX, pair}));
    pair_map_put(&e->open, (uint64_t)m->contacts.at[i], (uint32_t)(e->at.count - 1));
    return pair;
}

/* Its pair of types. */
static size_t take(episodes *e, const world *w, const wire_event_batch *m, size_t i)
{
    uint64_t id = (uint64_t)m->contacts.at[i];
    if (!id) return METER_PAIRS; /* a whole body is unknown */
    uint8_t kind = m->kinds.at[i];
    uint32_t known = pair_map_get(&e->open, id);
    size_t pair = known != PAIR_MAP_NONE ? e->at.at[known].pair : METER_PAIRS;
    if (known == PAIR_MAP_NONE && (begins(kind) || (m->snapshot && kind == EVENT_UPDATE))) pair = begin(e, w, m, i);
    if (!ends(kind)) return pair;
    known = pair_map_remove(&e->open, id);
    if (known != PAIR_MAP_NONE) e->at.at[known].last = m->tick;
    return pair;
}

void episodes_take(episodes *e, const world *w, const wire_event_batch *m, size_t bytes)
{
    size_t count = m->kinds.count;
    e->events += count;
    e->bytes += (double)bytes;
    if (!count) e->pair_bytes[METER_PAIRS] += (double)bytes;
    for (size_t i = 0; i < count; i++) {
        size_t pair = take(e, w, m, i);
        e->pair_events[pair]++;
        e->pair_bytes[pair] += (double)bytes / (double)count;
    }
}

/* ---- comparing ---- */

static int by_key_and_tick(const void *a, const void *b)
{
    const episode *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return x->first < y->first ? -1 : x->first > y->first;
}

void episodes_sort(episodes *e)
{
    if (e->at.count) qsort(e->at.at, e->at.count, sizeof *e->at.at, by_key_and_tick);
}

/* Of one key no episode begins before the one before it has ended, so that both ends rise. */
static bool has_like(const episodes *among, const episode *x)
{
    size_t low = 0, high = among->at.count;
    while (low < high) { /* the first that is not over before it */
        size_t middle = low + (high - low) / 2;
        const episode *y = &among->at.at[middle];
        if (y->key < x->key || (y->key == x->key && y->last < x->first - EPISODES_SHIFT))
            low = middle + 1;
        else
            high = middle;
    }
    if (low == among->at.count || among->at.at[low].key != x->key) return false;
    return x->last == INT64_MAX || among->at.at[low].first <= x->last + EPISODES_SHIFT;
}

void episodes_missing(const episodes *all, const episodes *among, uint64_t *counts)
{
    for (size_t i = 0; i < all->at.count; i++)
        if (!has_like(among, &all->at.at[i])) counts[all->at.at[i].pair]++;
}
