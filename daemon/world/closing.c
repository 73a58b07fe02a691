/* closing: what was reported to a subscription ends when it closes, or when its terms change. Tick thread.
 *
 * That may be a million contacts. So all of it is cut off at once, as a list of its own (what is on it is old), and
 * ended in slices: the newest first, those of a tick in the order of their ids. Nothing begins twice meanwhile: an old
 * watch ends before anything is reported of its pair under new terms (watch_find). A subscription is closed, and gets
 * its snapshot, when nothing of it is old. Counted, so that it follows from the commands and the slices. */
#include "events.h"
#include "subscription.h"

#include <stdlib.h>

enum { AN_END = 1000 /* units, with the telling */, PART = 4 /* of a slice, at most */, SOME_AT_LEAST = 64 };

void closing_begin(world *w, uint32_t id)
{
    subscription *i = &w->subscriptions.at[id];
    w->olds += i->watches - i->olds;
    i->olds = i->watches;
    i->old_serial = w->serial;
    i->held.count = 0; /* nothing is due any more */
    i->snapping = false;
    if (i->first_watch == WORLD_NONE) return;
    if (i->first_old == WORLD_NONE) {
        i->first_old = i->first_watch;
    } else {
        w->watches.at[i->last_old].subscription_next = i->first_watch;
        w->watches.at[i->first_watch].subscription_prev = i->last_old;
    }
    i->last_old = i->last_watch;
    i->first_watch = i->last_watch = WORLD_NONE;
}

uint8_t closing_cause(const world *w, uint32_t id)
{
    const subscription *i = &w->subscriptions.at[id];
    return i->closing ? i->closing_cause : (uint8_t)CAUSE_SUBSCRIPTION;
}

typedef struct reported {
    int64_t id;
    uint32_t watch;
} reported;

static int compare_reported(const void *a, const void *b)
{
    int64_t x = ((const reported *)a)->id, y = ((const reported *)b)->id;
    return (x > y) - (x < y);
}

static void end_some(world *w, uint32_t id, size_t most)
{
    const subscription *i = &w->subscriptions.at[id];
    ARRAY(reported) order = {0};
    uint8_t cause = closing_cause(w, id);
    array_reserve(&order, most < i->olds ? most : i->olds);
    for (uint32_t v = i->first_old; v != WORLD_NONE && order.count < most; v = w->watches.at[v].subscription_next)
        array_push(&order, ((reported){watch_id(&w->watches.at[v]), v}));
    if (order.count) qsort(order.at, order.count, sizeof *order.at, compare_reported);
    for (size_t k = 0; k < order.count; k++) watch_end(w, order.at[k].watch, cause);
    array_free(&order);
}

static size_t most_ends(const world *w)
{
    uint64_t most = w->slice / PART / AN_END;
    return w->slice == UINT64_MAX ? SIZE_MAX : most < SOME_AT_LEAST ? SOME_AT_LEAST : (size_t)most;
}

/* All, or of each an equal share: who closes little does not wait for who closes much. */
void closing_go_on(world *w)
{
    size_t most = most_ends(w), count = 0;
    if (!w->olds) return;
    for (size_t k = 0; k < w->changed_subscriptions.count; k++)
        count += w->subscriptions.at[w->changed_subscriptions.at[k]].olds > 0;
    bool cut = w->olds > most;
    w->sliced |= cut;
    for (size_t k = 0; k < w->changed_subscriptions.count; k++) {
        uint32_t id = w->changed_subscriptions.at[k];
        if (w->subscriptions.at[id].olds) end_some(w, id, cut ? most / count + 1 : most);
    }
}
