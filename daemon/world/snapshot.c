/* snapshot: everything that was reported to a subscription and still holds, reported again, as of the tick in which it
 * begins. Tick thread.
 *
 * A large one is reported in portions, so many events a tick, while the world goes on. What is to change meanwhile and
 * has not been told is told before it changes, as it was (snapshot_before); what begins meanwhile is not in it. So the
 * portions together are the state that the events of that tick have led to, and those of later ticks lead on from. A
 * snapshot of one portion is a batch behind the events of its tick: who was in step needs those, who was not needs only
 * this.
 *
 * None of it counts for the hash: who asks for a snapshot, and when, is no command. So it takes nothing of the slice
 * that pairs are decided in. */
#include "events.h"
#include "subscription.h"

#include <stdlib.h>

enum { AN_IMAGE = 1000 /* units, with its encoding */, PART = 4 /* of a slice, at most */, SOME_AT_LEAST = 64 };

static void add_image(world *w, uint32_t id, world_event e, uint8_t kind, int64_t contact)
{
    e.kind = kind;
    e.cause = CAUSE_SNAPSHOT;
    e.contact = contact;
    if (kind == EVENT_UNKNOWN) {
        e.lo = -INFINITY;
        e.hi = INFINITY;
        e.achieved = WORLD_WIDE;
    }
    array_push(&w->subscriptions.at[id].images, e);
}

void snapshot_take(world *w, uint32_t watch_no)
{
    watch *v = &w->watches.at[watch_no];
    uint32_t id = v->subscription;
    v->snap = w->subscriptions.at[id].snap;
    world_event as_reported = watch_last(w, watch_no), last = as_reported;
    events_refresh_ages(w, v, &last);
    if (v->touch_id) add_image(w, id, last, EVENT_BEGIN, v->touch_id);
    if (v->near_id) add_image(w, id, last, EVENT_NEAR, v->near_id);
    if (v->predicted_id) {
        world_event predicted = w->last_predicted.at[watch_no];
        events_refresh_ages(w, v, &predicted);
        add_image(w, id, predicted, EVENT_PREDICTED, v->predicted_id);
    }
    if (v->unknown) add_image(w, id, as_reported, EVENT_UNKNOWN, watch_id(v));
}

/* By contacts; what is unknown is reported after all else. */
static int compare_images(const void *a, const void *b)
{
    const world_event *x = a, *y = b;
    bool x_late = x->kind == EVENT_UNKNOWN, y_late = y->kind == EVENT_UNKNOWN;
    if (x_late != y_late) return x_late - y_late;
    return (x->contact > y->contact) - (x->contact < y->contact);
}

static void add_stale_bodies(world *w, uint32_t id)
{
    for (uint32_t b = 0; w->figures.stale_bodies && b < w->bodies.count; b++) {
        const body *at = &w->bodies.at[b];
        if (at->used && !at->ghost && at->stale && subscription_has(w, id, at))
            add_image(w, id, events_of_body(w, b), EVENT_UNKNOWN, 0);
    }
}

/* The whole state is not known before all bodies have been looked at for it, and what is reported of it stands beside
 * nothing that was reported under other terms. */
static bool gets_snapshot(const subscription *i)
{
    return i->used && i->snapshot && !i->snapping && !i->closing && i->settling == SETTLED && !i->olds;
}

static void begin_snapshot(subscription *i)
{
    i->snapshot = false;
    i->snapping = i->images_begin = true;
    i->snap++;
    i->snap_next = i->first_watch;
}

static void go_on(world *w, uint32_t id, size_t most)
{
    subscription *i = &w->subscriptions.at[id];
    i->images_reported = true;
    while (i->snap_next != WORLD_NONE && i->images.count < most) {
        uint32_t watch_no = i->snap_next;
        i->snap_next = w->watches.at[watch_no].subscription_next;
        if (w->watches.at[watch_no].snap != i->snap) snapshot_take(w, watch_no);
    }
    i->snapping = i->snap_next != WORLD_NONE;
    if (i->images.count) qsort(i->images.at, i->images.count, sizeof *i->images.at, compare_images);
    if (i->images_begin) add_stale_bodies(w, id);
}

/* Each an equal share of what a tick may tell. */
void events_snapshots(world *w)
{
    size_t count = 0;
    for (size_t k = 0; k < w->lively.count; k++) {
        subscription *i = &w->subscriptions.at[w->lively.at[k]];
        if (gets_snapshot(i)) begin_snapshot(i);
        count += i->used && i->snapping;
    }
    uint64_t share = count ? w->slice / PART / AN_IMAGE / count : 0;
    size_t most = w->slice == UINT64_MAX ? SIZE_MAX : share < SOME_AT_LEAST ? SOME_AT_LEAST : (size_t)share;
    w->snapping = 0;
    for (size_t k = 0; count && k < w->lively.count; k++) {
        uint32_t id = (uint32_t)w->lively.at[k];
        if (!w->subscriptions.at[id].used || !w->subscriptions.at[id].snapping) continue;
        go_on(w, id, most);
        w->snapping += w->subscriptions.at[id].snapping;
    }
}
