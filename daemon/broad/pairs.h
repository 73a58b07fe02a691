/* pairs: the persistent pairs, reached by proxy.
 *
 * Each pair hangs in two lists, one for each of its proxies, so that a proxy's pairs are found and ended without
 * looking at any other. A link is (pair << 1 | side): the place of one proxy in one pair. There is no way to ask
 * whether two proxies are a pair: the broad phase knows it from their boxes (settle.c). Not thread-safe. */
#ifndef COLLIDED_BROAD_PAIRS_H
#define COLLIDED_BROAD_PAIRS_H

#include "base/array.h"

#include <stdint.h>

#define PAIRS_NO_LINK UINT32_MAX

typedef struct pair_record {
    uint32_t proxy[2];
    uint32_t next[2], prev[2]; /* links; next[0] chains the freed records */
    uint32_t number;           /* the caller's: see broad_each_number_of */
} pair_record;

typedef struct pair_list { /* of one proxy */
    uint32_t first;        /* link */
    uint32_t count;
} pair_list;

typedef struct pairs {
    ARRAY(pair_record) records;
    ARRAY(pair_list) lists; /* by proxy */
    uint32_t free_record;
    size_t count;
} pairs;

void pairs_init(pairs *p);
void pairs_free(pairs *p);

void pairs_begin(pairs *p, uint32_t a, uint32_t b); /* which must not be a pair already */
void pairs_end(pairs *p, uint32_t link);
void pairs_trim(pairs *p); /* gives the memory of freed records back, if they are most of them */

/* The links of a proxy, newest first. Take the next one before ending a pair. */
static inline uint32_t pairs_first(const pairs *p, uint32_t proxy)
{
    return proxy < p->lists.count ? p->lists.at[proxy].first : PAIRS_NO_LINK;
}
static inline uint32_t pairs_of(const pairs *p, uint32_t proxy)
{
    return proxy < p->lists.count ? p->lists.at[proxy].count : 0;
}
static inline uint32_t pairs_next(const pairs *p, uint32_t link)
{
    return p->records.at[link >> 1].next[link & 1];
}
static inline uint32_t pairs_other(const pairs *p, uint32_t link)
{
    return p->records.at[link >> 1].proxy[~link & 1];
}

/* For tests: the first broken invariant, or NULL. */
const char *pairs_validate(const pairs *p);

#endif
