/* broad: boxes in; pairs that began and pairs that ended out, in canonical order.
 *
 * A proxy is the box of one shape under the caller's id. Its stored box is fat; a proxy is looked at only when its
 * tight box leaves the fat one. Two trees: moving and static (static proxies do not pair with each other). A pair of
 * proxies stays from the tick their fat boxes meet until they part. Half-infinite boxes are kept in a list beside the
 * trees. Not thread-safe; queries may run in several threads between updates. Never drops a pair. */
#ifndef COLLIDED_BROAD_BROAD_H
#define COLLIDED_BROAD_BROAD_H

#include "geom/bounds.h"

typedef struct broad broad;

typedef struct broad_move {
    uint32_t proxy;  /* the caller's id, dense and small */
    bool fixed;      /* goes to the static tree */
    aabb box;        /* tight, world frame, widened already by whatever range interests need */
    double margin;   /* m, by which to fatten when it is (re)inserted; >= 0 */
} broad_move;

typedef struct broad_pair {
    uint32_t a, b; /* a < b */
} broad_pair;

typedef struct broad_changes { /* owned by the broad phase, valid until its next update; each sorted by (a, b) */
    const broad_pair *began, *ended;
    size_t began_count, ended_count;
} broad_changes;

/* Pairs that it refuses never begin. Called from broad_update, any number of times. */
typedef bool broad_filter(void *context, uint32_t a, uint32_t b);

broad *broad_create(broad_filter *filter, void *context);
void broad_destroy(broad *b);

/* Queue changes; broad_update carries them out. A proxy put twice keeps the last. A removed proxy's pairs end. */
void broad_put(broad *b, const broad_move *move);
void broad_remove(broad *b, uint32_t proxy);
void broad_refilter(broad *b, uint32_t proxy); /* its filter or range changed: look at all its pairs again */

void broad_update(broad *b, broad_changes *changes);

size_t broad_proxy_count(const broad *b);
size_t broad_pair_count(const broad *b);
void broad_each_pair_of(const broad *b, uint32_t proxy, void (*visit)(void *context, uint32_t other), void *context);

/* Each proxy whose fat box meets `box` / whose fat box the segment from..from+length*direction meets; in no
 * particular order. Returning false stops. */
typedef bool broad_visit(void *context, uint32_t proxy);
void broad_query_box(const broad *b, aabb box, broad_visit *visit, void *context);
void broad_query_ray(const broad *b, vec3 from, vec3 direction, double length, broad_visit *visit, void *context);

/* For tests: the first broken invariant, or NULL. */
const char *broad_validate(const broad *b);

#endif
