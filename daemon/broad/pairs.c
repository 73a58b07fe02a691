/* pairs: records in an array with a free list, and doubly linked lists through them. One thread. Each record that is
 * not free hangs in the lists of both of its proxies, and no two records have the same proxies. */
#include "pairs.h"

#include "broad.h"

#include <assert.h>
#include <stdlib.h>

enum { MOST_RECORDS = UINT32_MAX / 2 }; /* so that a link fits 32 bits and is never PAIRS_NO_LINK */

void pairs_init(pairs *p)
{
    *p = (pairs){.free_record = PAIRS_NO_LINK};
}

void pairs_free(pairs *p)
{
    array_free_in_place(&p->records);
    array_free_in_place(&p->lists);
    pairs_init(p);
}

static uint32_t take_record(pairs *p)
{
    if (p->free_record == PAIRS_NO_LINK) {
        assert(p->records.count < MOST_RECORDS);
        array_reserve_in_place(&p->records, p->records.count + 1);
        p->records.at[p->records.count++] = (pair_record){0};
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
    array_reserve_in_place(&p->lists, (size_t)proxy + 1);
    while (p->lists.count <= proxy) p->lists.at[p->lists.count++] = (pair_list){.first = PAIRS_NO_LINK};
    uint32_t next = p->lists.at[proxy].first;
    r->next[side] = next;
    r->prev[side] = PAIRS_NO_LINK;
    if (next != PAIRS_NO_LINK) p->records.at[next >> 1].prev[next & 1] = link;
    p->lists.at[proxy].first = link;
    p->lists.at[proxy].count++;
}

static void unlink_side(pairs *p, uint32_t index, unsigned side)
{
    const pair_record *r = &p->records.at[index];
    assert(r->proxy[side] < p->lists.count && p->lists.at[r->proxy[side]].count > 0);
    uint32_t next = r->next[side], prev = r->prev[side];
    assert(prev == PAIRS_NO_LINK || p->records.at[prev >> 1].next[prev & 1] == (index << 1 | side));
    if (next != PAIRS_NO_LINK) p->records.at[next >> 1].prev[next & 1] = prev;
    if (prev != PAIRS_NO_LINK)
        p->records.at[prev >> 1].next[prev & 1] = next;
    else
        p->lists.at[r->proxy[side]].first = next;
    p->lists.at[r->proxy[side]].count--;
}

void pairs_begin(pairs *p, uint32_t a, uint32_t b)
{
    assert(a != b);
    uint32_t index = take_record(p);
    p->count++;
    p->records.at[index].proxy[0] = a;
    p->records.at[index].proxy[1] = b;
    p->records.at[index].number = BROAD_NO_NUMBER;
    hang_in(p, index, 0);
    hang_in(p, index, 1);
}

void pairs_end(pairs *p, uint32_t link)
{
    uint32_t index = link >> 1;
    assert(index < p->records.count && p->count > 0);
    unlink_side(p, index, 0);
    unlink_side(p, index, 1);
    pair_record *r = &p->records.at[index];
    r->next[0] = p->free_record;
    p->free_record = index;
    p->count--;
}

static uint32_t relink(const uint32_t *moved, uint32_t link)
{
    return link == PAIRS_NO_LINK ? link : moved[link >> 1] << 1 | (link & 1);
}

/* The records move together; each list stays in its order. */
void pairs_trim(pairs *p)
{
    if (p->records.count * sizeof *p->records.at < ARRAY_SPARE_BYTES || p->count > p->records.count / 4) return;
    uint32_t *moved = base_alloc(p->records.count, sizeof *moved);
    pairs kept = {.lists = p->lists, .free_record = PAIRS_NO_LINK, .count = p->count};
    array_reserve_in_place(&kept.records, p->count);
    for (uint32_t proxy = 0; proxy < p->lists.count; proxy++) {
        for (uint32_t link = pairs_first(p, proxy); link != PAIRS_NO_LINK; link = pairs_next(p, link)) {
            if (link & 1) continue;
            moved[link >> 1] = (uint32_t)kept.records.count;
            kept.records.at[kept.records.count++] = p->records.at[link >> 1];
        }
    }
    for (size_t i = 0; i < kept.records.count; i++) {
        pair_record *r = &kept.records.at[i];
        for (int side = 0; side < 2; side++) {
            r->next[side] = relink(moved, r->next[side]);
            r->prev[side] = relink(moved, r->prev[side]);
        }
    }
    for (size_t i = 0; i < kept.lists.count; i++) kept.lists.at[i].first = relink(moved, kept.lists.at[i].first);
    array_free_in_place(&p->records);
    free(moved);
    *p = kept;
}

/* The links of a proxy, counted; SIZE_MAX if the list is broken. `met_by` tells the last proxy whose list each one was
 * seen in. */
static size_t count_links(const pairs *p, uint32_t proxy, uint32_t *met_by)
{
    size_t count = 0;
    uint32_t prev = PAIRS_NO_LINK;
    for (uint32_t link = pairs_first(p, proxy); link != PAIRS_NO_LINK; link = pairs_next(p, link)) {
        const pair_record *r = &p->records.at[link >> 1];
        uint32_t other = pairs_other(p, link);
        if (r->proxy[link & 1] != proxy || r->prev[link & 1] != prev) return SIZE_MAX;
        if (other >= p->lists.count || met_by[other] == proxy) return SIZE_MAX;
        met_by[other] = proxy;
        count++;
        prev = link;
    }
    return count == pairs_of(p, proxy) ? count : SIZE_MAX;
}

const char *pairs_validate(const pairs *p)
{
    size_t links = 0;
    uint32_t *met_by = base_alloc(p->lists.count, sizeof *met_by);
    for (size_t i = 0; i < p->lists.count; i++) met_by[i] = UINT32_MAX;
    for (uint32_t proxy = 0; proxy < p->lists.count && links != SIZE_MAX; proxy++) {
        size_t count = count_links(p, proxy, met_by);
        links = count == SIZE_MAX ? count : links + count;
    }
    free(met_by);
    if (links == SIZE_MAX) return "the pair list of a proxy is broken";
    if (links != 2 * p->count) return "the count of pairs differs from the lists";
    size_t freed = 0;
    for (uint32_t i = p->free_record; i != PAIRS_NO_LINK && freed <= p->records.count; i = p->records.at[i].next[0])
        freed++;
    if (freed + p->count != p->records.count) return "pair records were lost";
    return NULL;
}
