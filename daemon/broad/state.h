/* state: what the files of the broad phase share; nobody else includes it. */
#ifndef COLLIDED_BROAD_STATE_H
#define COLLIDED_BROAD_STATE_H

#include "base/array.h"
#include "base/pair_map.h"
#include "broad.h"
#include "fbox.h"
#include "index.h"
#include "pairs.h"
#include "sweep.h"
#include "tree.h"

#define NOTHING_PENDING UINT32_MAX

typedef enum place { NOWHERE, INDEXED, UNBOUNDED } place;

typedef struct proxy {
    fbox fat;
    uint32_t pending; /* index into `pending`, or NOTHING_PENDING */
    uint8_t place;
    bool fixed;
    uint8_t moves; /* of its leaf, in place, since it was put where it is best (trees.c) */
} proxy;
_Static_assert(sizeof(proxy) == 32, "two proxies fill a cache line");

/* What was asked for one proxy since the last update: first removed, then put. */
typedef struct change {
    uint32_t proxy;
    bool removed, put, refilter;
    bool asks;  /* its meetings are searched around it; else the index finds them by itself */
    bool fixed; /* of what was put */
    bool was;   /* the proxy stood before, with... */
    bool was_fixed;
    fbox fat; /* of what was put */
    fbox old; /* ...this box */
} change;

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

    ARRAY(change) pending;
    key_array order;           /* position << 32 | index into `pending` */
    ARRAY(uint32_t) unsettled; /* indices into `pending`: whose pairs have to be looked at */
    key_array met;             /* pairs that the index found by itself; perhaps refused by the filter */
    key_array began, ended, scratch;
};

/* choose.c: the index to begin with; and for BROAD_AUTO, before a batch is carried out, the one that suits it. */
const broad_index *broad_first_index(broad_kind kind);
void broad_choose_index(broad *b);

/* Ends the pairs of the proxies in `unsettled` that parted, begins those that met. */
void broad_settle(broad *b);
void broad_end_all_pairs(broad *b, uint32_t id);

static inline bool may_pair(const fbox *p, bool p_fixed, const fbox *q, bool q_fixed)
{
    return !(p_fixed && q_fixed) && fbox_overlap(p, q);
}

#endif
