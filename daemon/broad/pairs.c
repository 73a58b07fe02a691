/* pairs: records in an array with a free list, a map to find them by key, and doubly linked lists through them. One
 * thread. The map and the lists always hold the same pairs. */
#include "pairs.h"

#include <assert.h>
#include <stdlib.h>

enum { MOST_RECORDS = UINT32_MAX / 2 }; /* so that a link fits 32 bits and is never PAIRS_NO_LINK */

void pairs_init(pairs *p)
{
    *p = (pairs){.free_record = PAIRS_NO_LINK};
    pair_map_init(&p->by_key);
}

void pairs_free(pairs *p)
{
    pair_map_free(&p->by_key);
    array_free(&p->records);
    array_free(&p->first);
    pairs_init(p);
}

bool pairs_have(const pairs *p, uint32_t a, uint32_t b)
{
    return pair_map_get(&p->by_key, pair_key(a, b)) != PAIR_MAP_NONE;
}

static uint32_t take_record(pairs *p)
{
    if (p->free_record == PAIRS_NO_LINK) {
        assert(p->records.count < MOST_RECORDS);
        array_push(&p->records, (pair_record){0});
        return (uint32_t)p->records.count - 1;
    }
    uint32_t index = p->free_record;
    p->free_record = p->records.at[index].next[0];
    return index;
}

static void hang_in(pairs *p, uint32_t index, unsigned side)
{
    pair_record *r = &p->records.at[index];
    uint32_t proxy = r->proxy[side], link = index << 1 | side;
    array_reserve(&p->first, (size_t)proxy + 1);
    while (p->first.count <= proxy) p->first.at[p->first.count++] = PAIRS_NO_LINK;
    uint32_t next = p->first.at[proxy];
    r->next[side] = next;
    r->prev[side] = PAIRS_NO_LINK;
    if (next != PAIRS_NO_LINK) p->records.at[next >> 1].prev[next & 1] = link;
    p->first.at[proxy] = link;
}

static void take_out(pairs *p, uint32_t index, unsigned side)
{
    const pair_record *r = &p->records.at[index];
    uint32_t next = r->next[side], prev = r->prev[side];
    if (next != PAIRS_NO_LINK) p->records.at[next >> 1].prev[next & 1] = prev;
    if (prev != PAIRS_NO_LINK)
        p->records.at[prev >> 1].next[prev & 1] = next;
    else
        p->first.at[r->proxy[side]] = next;
}

void pairs_begin(pairs *p, uint32_t a, uint32_t b)
{
    uint32_t index = take_record(p);
    bool is_new = pair_map_put(&p->by_key, pair_key(a, b), index);
    assert(is_new);
    (void)is_new;
    p->records.at[index].proxy[0] = a;
    p->records.at[index].proxy[1] = b;
    hang_in(p, index, 0);
    hang_in(p, index, 1);
}

void pairs_end(pairs *p, uint32_t link)
{
    uint32_t index = link >> 1;
    take_out(p, index, 0);
    take_out(p, index, 1);
    pair_record *r = &p->records.at[index];
    pair_map_remove(&p->by_key, pair_key(r->proxy[0], r->proxy[1]));
    r->next[0] = p->free_record;
    p->free_record = index;
}

/* The links of a proxy, counted; SIZE_MAX if the list is broken. */
static size_t count_links(const pairs *p, uint32_t proxy)
{
    size_t count = 0;
    uint32_t prev = PAIRS_NO_LINK;
    for (uint32_t link = pairs_first(p, proxy); link != PAIRS_NO_LINK; link = pairs_next(p, link)) {
        const pair_record *r = &p->records.at[link >> 1];
        if (r->proxy[link & 1] != proxy || r->prev[link & 1] != prev) return SIZE_MAX;
        if (pair_map_get(&p->by_key, pair_key(r->proxy[0], r->proxy[1])) != link >> 1) return SIZE_MAX;
        if (++count > p->records.count) return SIZE_MAX;
        prev = link;
    }
    return count;
}

const char *pairs_validate(const pairs *p)
{
    size_t links = 0;
    for (uint32_t proxy = 0; proxy < p->first.count; proxy++) {
        size_t count = count_links(p, proxy);
        if (count == SIZE_MAX) return "the pair list of a proxy is broken";
        links += count;
    }
    if (links != 2 * pairs_count(p)) return "pairs of the map are missing from the lists";
    size_t freed = 0;
    for (uint32_t i = p->free_record; i != PAIRS_NO_LINK && freed <= p->records.count; i = p->records.at[i].next[0])
        freed++;
    if (freed + pairs_count(p) != p->records.count) return "pair records were lost";
    return NULL;
}
