/* episodes: what a run told its subscribers, as spans of ticks: a contact from its begin to its end, a nearness from
 * near to far, what was predicted until it was averted, an impact in its tick.
 *
 * Two runs are compared by what a subscriber could rely on. An episode of one finds its like in the other if that told
 * the same fact of the same two shapes, on the same subscription, in a tick of the episode or at most EPISODES_SHIFT
 * ticks before or behind it: a wider interval begins earlier and ends later, and may join two episodes into one. What
 * finds no like in a looser run is missed by it; what a looser run tells without a like in the exact one is false. */
#ifndef COLLIDED_TRADE_EPISODES_H
#define COLLIDED_TRADE_EPISODES_H

#include "base/array.h"
#include "base/pair_map.h"
#include "wire/wire.h"
#include "world/world.h"

enum { EPISODES_SHIFT = 2 };

typedef struct episode {
    uint64_t key;        /* of subscription, fact and shapes */
    int64_t first, last; /* ticks; last is INT64_MAX while it lasts */
    size_t pair;         /* meter_pair of its shapes */
} episode;

typedef struct episodes {
    ARRAY(episode) at;
    pair_map open;         /* contact id -> index of `at` */
    uint64_t events;       /* told */
    double bytes;          /* of all batches, in LCM's encoding */
    uint64_t *pair_events; /* by meter_pair; METER_PAIRS + 1 of each, the last for what has no pair */
    double *pair_bytes;    /* a batch's bytes are divided equally among its events */
} episodes;

void episodes_init(episodes *e);
void episodes_free(episodes *e);
void episodes_take(episodes *e, const world *w, const wire_event_batch *m, size_t bytes);
/* By key, then by tick; before episodes_missing. */
void episodes_sort(episodes *e);
/* Those of `all` without a like in `among`, by meter_pair: added to counts[METER_PAIRS + 1]. */
void episodes_missing(const episodes *all, const episodes *among, uint64_t *counts);

#endif
