/* broad: boxes in; pairs that began and pairs that ended out, in canonical order.
 *
 * A proxy is the box of one shape under the caller's id. Its stored box is fat: widened by a margin, reaching ahead of
 * its motion, in floats rounded outward. As long as the tight box stays inside, a put is a comparison and nothing else;
 * an update costs what left its fat box (or has become so small that the fat one is more than twice too large), not
 * what there is. Fixed proxies do not pair with each other. A pair of proxies stays from the update in which their fat
 * boxes meet until the one in which they part. Boxes without end are kept in a list beside. Not thread-safe; queries
 * may run in several threads between updates. Never drops a pair. */
#ifndef COLLIDED_BROAD_BROAD_H
#define COLLIDED_BROAD_BROAD_H

#include "geom/bounds.h"

typedef struct broad broad;

typedef struct broad_move {
    uint32_t proxy; /* the caller's id, dense and small */
    bool fixed;     /* does not pair with what is fixed, too */
    bool passive;   /* the filter refuses all its pairs: nobody searches around it. From the put on in which that is so
                       no more, which needs a refilter */
    aabb box;       /* tight, world frame, widened already by whatever range subscriptions need */
    double margin;  /* m, by which to fatten on all sides when it is given a new fat box; >= 0 */
    vec3 motion;    /* m, how far it is expected to move until the next put: the new fat box reaches ahead */
} broad_move;

typedef struct broad_pair {
    uint32_t a, b; /* a < b */
} broad_pair;

/* Owned by the broad phase, valid until its next update; each sorted by (a, b). `ended` is to be applied first: a proxy
 * that was removed and put again between two updates is a new thing, whose pairs end and, if they meet, begin. No other
 * pair is in both. The order in which proxies were put does not matter. */
typedef struct broad_changes {
    const broad_pair *began, *ended;
    size_t began_count, ended_count;
} broad_changes;

/* Pairs that it refuses never begin. Called from broad_update with a < b, any number of times; what it says may change
 * for a pair only together with a broad_refilter of one of the two. */
typedef bool broad_filter(void *context, uint32_t a, uint32_t b);

/* How what meets is found. Pairs and changes are the same whichever is chosen, and what queries visit, but for its
 * order. */
typedef enum broad_kind {
    BROAD_AUTO,   /* what measured best for so many proxies (choose.c); changes in broad_update */
    BROAD_TREE,   /* two trees: moving and fixed */
    BROAD_SWEEP3, /* sweep and prune on three axes */
    BROAD_SWEEP1, /* sweep and prune on the axis of the largest variance */
} broad_kind;

const char *broad_kind_name(broad_kind kind); /* "auto", "tree", "sweep3", "sweep1" */

broad *broad_create(broad_kind kind, broad_filter *filter, void *context);
void broad_destroy(broad *b);

/* Queue changes; broad_update carries them out. A proxy put twice keeps the last. A removed proxy's pairs end. Removing
 * or refiltering a proxy that is not there does nothing. A box must have lo <= hi, and may be infinite. */
bool broad_put(broad *b, const broad_move *move); /* true: the fat box holds; nothing was queued */
void broad_remove(broad *b, uint32_t proxy);
void broad_refilter(broad *b, uint32_t proxy); /* its filter changed: ask again about all its pairs */

void broad_update(broad *b, broad_changes *changes);

/* How far a tight box may go before it leaves the fat one, m along each axis and against it. False: it is not inside,
 * or there is none, or not in the index. As the next update will have it. */
typedef struct broad_region {
    double down[3], up[3];
    aabb fat;
    double least[3]; /* m: while the tight box is as wide, the fat one is not too fat for it; ... */
    bool slim;       /* ... and so it is: only when it leaves it will it get another */
} broad_region;
bool broad_region_of(const broad *b, uint32_t proxy, aabb tight, double margin, broad_region *out);
/* As of the last update: put elsewhere, it has the same fat box, and so the same pairs. */
broad_move broad_fat_box(const broad *b, uint32_t proxy);

/* ---- in slices ----
 *
 * 20,000 boxes in one place are 200 million pairs. With a limit an update whose pairs would take more work (counted, so
 * that it is the same everywhere and for each kind of index) finds none: it only puts the boxes where they are, and its
 * proxies are unsearched. From then on all that is put is, until each one has been searched by broad_search. Of two
 * proxies that are not unsearched it is known whether they are a pair; a pair of one that is may be missing, or one
 * whose boxes have parted. */

/* `units` of about a nanosecond, UINT64_MAX: no limit; no search begins a pair when there are `most_pairs`. */
void broad_set_limit(broad *b, uint64_t units, size_t most_pairs);
bool broad_is_unsearched(const broad *b, uint32_t proxy);
size_t broad_unsearched_count(const broad *b);
bool broad_was_put_off(const broad *b); /* by the last update */
uint32_t broad_pairs_of(const broad *b, uint32_t proxy);
/* Between updates: ends the pairs of an unsearched proxy that have parted, and begins those that are missing, by rising
 * ids, as far as `units` go (some of them at least); *spent: what it took. Those with an unsearched proxy that
 * `is_left` are left to its search. True: it is searched. `changes` as of broad_update, until the next call. */
typedef bool broad_leave(void *context, uint32_t other);
bool broad_search(broad *b, uint32_t proxy, uint64_t units, broad_leave *is_left, void *context, broad_changes *changes,
    uint64_t *spent);
bool broad_was_refiltered(const broad *b, uint32_t proxy); /* of one that is unsearched */
/* Of a proxy whose removal is queued: its pairs do not end with the next update, but by broad_end_leaving; nothing else
 * is left of it then, and its id is not free before. */
void broad_let_leave(broad *b, uint32_t proxy);
bool broad_is_leaving(const broad *b, uint32_t proxy);
/* Between updates: ends its pairs, by rising ids, as far as `units` go (some of them at least). True: it is gone. */
bool broad_end_leaving(broad *b, uint32_t proxy, uint64_t units, broad_changes *changes, uint64_t *spent);
/* Units that it takes to ask the filter about two, where that is more than usual; NULL: nowhere, to begin with. Sums of
 * it count for the limits above, and a search may stop behind each that was asked. */
typedef uint64_t broad_price(void *context, uint32_t a, uint32_t b);
void broad_set_price(broad *b, broad_price *price);
/* How far the search of an unsearched proxy has come with those that have a price, and that it goes on from there. */
uint64_t broad_asked_until(const broad *b, uint32_t proxy);
void broad_take_asked(broad *b, uint32_t proxy, uint64_t until);
/* For a state that was saved in the middle: an update with a limit of 0 puts all off; then these two are a pair (each
 * of the two is there, which is checked: false; and they are none yet, which is not), and this one is searched. */
bool broad_take_pair(broad *b, uint32_t x, uint32_t y);
void broad_take_searched(broad *b, uint32_t proxy, bool searched, bool refiltered);
void broad_take_leaving(broad *b, uint32_t proxy); /* it is there, and leaves */

/* As of the last update. The index that stands: never BROAD_AUTO. And in words, with the reason, at most 95 characters:
 * "tree (auto: 700 proxies; sweep3 for 128 and fewer)". */
broad_kind broad_index_kind(const broad *b);
void broad_report_index(const broad *b, char text[96]);
size_t broad_proxy_count(const broad *b);
/* Gives memory back that only a larger world needs, unless something is queued; what the last update told is gone. */
void broad_trim(broad *b);
size_t broad_pair_count(const broad *b);
/* The order is nobody's business, but the same after the same changes. */
void broad_each_pair_of(const broad *b, uint32_t proxy, void (*visit)(void *context, uint32_t other), void *context);
/* The same with a number of the caller's, which the pair keeps as long as it is one: BROAD_NO_NUMBER to begin with. */
#define BROAD_NO_NUMBER UINT32_MAX
void broad_each_number_of(
    broad *b, uint32_t proxy, void (*visit)(void *context, uint32_t other, uint32_t *number), void *context);

/* The records that broad_each_number_of will go through are fetched into the caches. It changes nothing. */
void broad_fetch_numbers_of(const broad *b, uint32_t proxy);

/* Each proxy whose fat box meets `box`, in an order that is nobody's business, but the same after the same changes.
 * Returning false stops. */
typedef bool broad_visit(void *context, uint32_t proxy);
void broad_query_box(const broad *b, aabb box, broad_visit *visit, void *context);

/* Each proxy whose fat box meets `box` somewhere on its way along length*direction (|direction| about 1), for rays and
 * shape casts, and some that it misses by a rounding (2^-20 of the way to it). The trees begin with what is near, so
 * that a hit makes the rest of the way short: the visit returns how far to look from now on, as a length of the way: as
 * before, or up to its hit; to stop, a negative number. Who has been visited when all is told depends on the index, so
 * what is made of the visits must not: the least of what they tell, with a rule for ties, and the way not made shorter
 * than it. */
typedef double broad_ray_visit(void *context, uint32_t proxy);
void broad_query_cast(const broad *b, aabb box, vec3 direction, double length, broad_ray_visit *visit, void *context);

/* Each proxy whose fat box is at most `reach` (m) from `box`, nearest fat box first. The visit is told that distance,
 * a lower bound for what is inside, and returns how far to look from now on: for the k nearest, the distance of the
 * k-th best so far; for all within a distance, always that; to stop, a negative number. */
typedef double broad_near_visit(void *context, uint32_t proxy, double distance);
void broad_query_nearest(const broad *b, aabb box, double reach, broad_near_visit *visit, void *context);

/* For tests: the first broken invariant, or NULL. */
const char *broad_validate(const broad *b);

#endif
