/* state: what the files of the broad phase share; nobody else includes it. */
#ifndef COLLIDED_BROAD_STATE_H
#define COLLIDED_BROAD_STATE_H

#include "base/array.h"
#include "base/pair_map.h"
#include "broad.h"
#include "change.h"
#include "fbox.h"
#include "index.h"
#include "pairs.h"
#include "sweep_list.h"
#include "tree.h"

#define NOTHING_PENDING UINT32_MAX

typedef enum place { NOWHERE, INDEXED, UNBOUNDED } place;

typedef struct proxy {
    fbox fat;
    uint32_t pending; /* index into `pending`, or NOTHING_PENDING */
    uint8_t place;
    bool fixed;
    bool passive : 1;    /* no pair with it is wanted: it is not searched around */
    bool unsearched : 1; /* put off: its pairs are not those of its box, or of its filter, ... */
    bool refiltered : 1; /* ... which has changed since */
    bool leaving : 1;    /* it is gone, but for its pairs: see broad_let_leave */
    uint8_t moves;       /* of its leaf, in place, since it was put where it is best (trees.c) */
} proxy;
_Static_assert(sizeof(proxy) == 32, "two proxies fill a cache line");

typedef ARRAY(uint64_t) key_array;

struct broad {
    broad_filter *filter;
    void *filter_context;

    ARRAY(proxy) proxies; /* by the caller's id */
    size_t proxy_count;   /* those that are somewhere */
    broad_kind kind;      /* as asked for */
    const broad_index *index;
    tree moving, fixed;                /* trees.c */
    sweep sweep;                       /* sweep3.c, sweep1.c */
    ARRAY(uint32_t) unbounded, listed; /* proxies beside the index; by proxy, its place among them */
    ARRAY(uint32_t) marks;             /* by proxy: the last refilter that found it a partner */
    uint32_t mark;
    pairs pairs;

    uint64_t updates;      /* so far */
    uint64_t limit;        /* units that an update may take; what takes more is put off, see broad_search */
    size_t most_pairs;     /* beyond which no search begins any */
    size_t unsearched;     /* proxies */
    broad_price *price;    /* see broad_set_price */
    ARRAY(uint64_t) asked; /* by proxy: see slices.c; only where there was a price */
    size_t leaving;        /* proxies */
    bool all_ask;          /* in this batch: each proxy is searched around, and what is found there counts */
    bool put_off;          /* in the last update something was */
    uint64_t spent;        /* units of this batch, or of this search */

    ARRAY(change) pending;
    key_array order;           /* position << 32 | index into `pending` */
    ARRAY(uint32_t) unsettled; /* indices into `pending`: whose pairs have to be looked at */
    key_array met;             /* pairs that the index found by itself; perhaps refused by the filter */
    key_array began, ended, scratch;
};

/* choose.c: the index to begin with; and for BROAD_AUTO, before a batch is carried out, the one that suits it. */
const broad_index *broad_first_index(broad_kind kind);
void broad_choose_index(broad *b);

/* What the search for pairs takes, in units of about a nanosecond: counts, so that it is the same everywhere. What
 * begins and ends is counted with what the world does about it. */
enum {
    UNITS_A_CANDIDATE = 25,
    UNITS_BY_ID = 8,
    UNITS_A_PAIR_KEPT = 15,
    UNITS_ASKED = 60,
    UNITS_BEGUN = 1000,
    UNITS_ENDED = 600
};

/* Ends the pairs of the proxies in `unsettled` that parted, begins those that met: or puts it off, for all of them,
 * where it would take more than the limit, or something has been put off already. */
void broad_settle(broad *b);
bool broad_accepts(const broad *b, uint32_t x, uint32_t y);
uint64_t broad_price_of(const broad *b, uint32_t x, uint32_t y); /* of asking that */
void broad_mark_partners(broad *b, uint32_t id);                 /* in `marks` */
/* Before a batch: may what is found around its proxies come near the limit? */
bool broad_must_ask(const broad *b);
void broad_forget_put_off(broad *b, uint32_t id);
/* Sorted, in place: until the keys change. */
const broad_pair *broad_hand_out(broad *b, key_array *keys);
void broad_end_all_pairs(broad *b, uint32_t id);
void broad_set_leaving(broad *b, uint32_t id, bool leaving);

static inline bool may_pair(const fbox *p, bool p_fixed, const fbox *q, bool q_fixed)
{
    return !(p_fixed && q_fixed) && fbox_overlap(p, q);
}

#endif
