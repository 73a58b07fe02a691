/* index: where the bounded proxies are kept, so that the meetings of a batch are found without looking at all pairs.
 * One of several tables of functions over the same broad phase (trees.c, sweep3.c, sweep1.c), which share everything
 * else: fat boxes, pairs, filters, the unbounded list. What an index finds is checked against the boxes of the batch
 * as a whole, so all of them bring the same changes. Tick thread; the queries as broad.h says. */
#ifndef COLLIDED_BROAD_INDEX_H
#define COLLIDED_BROAD_INDEX_H

#include "broad.h"
#include "change.h"
#include "fbox.h"
#include "near.h"
#include "tree.h"

typedef struct broad_index {
    broad_kind kind;

    /* A batch. First what changed, one call a proxy: put, move and remove are called before the proxy's record
     * (state.h) tells the new state. Move may clear change.asks, if the index tells the meetings of this proxy
     * without being asked around it. */
    void (*put)(broad *b, const change *c);
    void (*move)(broad *b, change *c);
    void (*remove)(broad *b, uint32_t proxy);
    /* Then the whole: all records tell the new state. Pushes to b->met each two proxies, neither of which asks, whose
     * boxes meet and did not before. */
    void (*settle)(broad *b);
    /* Each proxy of the index whose box meets that of this one, which may be in the index or unbounded; perhaps itself
     * and, if it is fixed, fixed ones. Between settle and the next batch. */
    void (*around)(const broad *b, uint32_t proxy, broad_visit *visit, void *context);

    /* A number below 2^30, unique among the fixed and among the moving ones: what is near in memory is near in it. */
    uint32_t (*position)(const broad *b, uint32_t proxy);

    /* As broad.h, of the proxies in the index. False when a visit stopped it. */
    bool (*query_box)(const broad *b, const fbox *query, broad_visit *visit, void *context);
    void (*query_ray)(const broad *b, tree_slabs *slabs, broad_ray_visit *visit, void *context);
    void (*query_nearest)(const broad *b, near_search *search); /* pushes where to begin */

    const char *(*validate)(const broad *b, size_t *count); /* and how many proxies it holds */
    void (*give_buffers_back)(broad *b);
    void (*free)(broad *b);
} broad_index;

extern const broad_index broad_trees, broad_sweep3, broad_sweep1;

#endif
