/* trim: memory that the world has grown into and does not need any more. Its arrays never shrink by themselves, so that
 * a steady tick allocates nothing: this is for when memory is short. Nothing that is reported depends on it. Tick
 * thread.
 */
#include "state.h"

void world_set_pairs_most(world *w, size_t most)
{
    w->pairs_most = most;
}

/* Lists may hold ids of pairs and watches that have ended: the places stay, as zeros, which is one that is not used. */
#define GIVE_UNUSED_BACK(list, pool)                                                                                   \
    do {                                                                                                               \
        size_t used = id_pool_end(pool);                                                                               \
        if ((list)->at) base_give_pages_back((list)->at + used, ((list)->capacity - used) * sizeof *(list)->at);       \
    } while (0)

static void trim_subscription(subscription *i)
{
    i->events.count = 0; /* as the next tick begins with */
    array_trim(&i->events);
    i->images.count = 0;
    array_trim(&i->images);
    array_trim(&i->held);
}

void world_trim(world *w)
{
    GIVE_UNUSED_BACK(&w->pairs, &w->pair_ids);
    GIVE_UNUSED_BACK(&w->watches, &w->watch_ids);
    GIVE_UNUSED_BACK(&w->last_contacts, &w->watch_ids);
    GIVE_UNUSED_BACK(&w->last_points, &w->watch_ids);
    GIVE_UNUSED_BACK(&w->last_predicted, &w->watch_ids);
    for (size_t i = 0; i < w->subscriptions.count; i++) trim_subscription(&w->subscriptions.at[i]);
    w->active.count = w->active_pairs.count = w->outcomes.count = w->open.count = w->needs.count = 0;
    w->results.count = w->sweeps.count = w->sweep_order.count = w->sweep_keys.count = w->search_again.count =
        w->sort_scratch.count = 0;
    array_trim(&w->active);
    array_trim(&w->active_pairs);
    array_trim(&w->outcomes);
    array_trim(&w->told);
    array_trim(&w->open);
    array_trim(&w->needs);
    array_trim(&w->results);
    array_trim(&w->sweeps);
    array_trim(&w->sweep_order);
    array_trim(&w->sweep_keys);
    array_trim(&w->search_again);
    array_trim(&w->sort_scratch);
    w->queue.count = 0;
    array_trim(&w->queue);
    array_trim(&w->unfinished);
    array_trim(&w->lingering);
    array_trim(&w->dirty);
    array_trim(&w->awake);
    array_trim(&w->glided);
    array_trim(&w->past_bodies);
    pair_map_trim(&w->pair_of);
    broad_trim(w->broad);
}
