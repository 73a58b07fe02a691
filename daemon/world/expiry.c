/* expiry: which bodies have become unknown, and which are known again. Tick thread.
 *
 * Deadlines stand in a binary heap, by time. A pose moves its body's deadline without touching the heap: an entry that
 * comes up too early is put back at the time that holds now. So a tick looks at the bodies that moved and at entries
 * that came up, never at all bodies, and an entry comes up at most once a deadline. Entries that are void
 * (their body is gone, or has an earlier one) stay until they come up, or until there are more of them than of bodies.
 */
#include "base/sort.h"
#include "state.h"

#include <stdlib.h>

/* ---- the heap: the earliest entry first ---- */

static void put_entry(world *w, expiry e)
{
    array_push(&w->expiries, e);
    expiry *at = w->expiries.at;
    size_t i = w->expiries.count - 1;
    for (; i > 0 && at[(i - 1) / 2].time_ns > e.time_ns; i = (i - 1) / 2) at[i] = at[(i - 1) / 2];
    at[i] = e;
}

static expiry take_entry(world *w)
{
    expiry *at = w->expiries.at, first = at[0], last = at[--w->expiries.count];
    size_t count = w->expiries.count, i = 0;
    for (size_t child = 1; child < count; child = 2 * i + 1) {
        if (child + 1 < count && at[child + 1].time_ns < at[child].time_ns) child++;
        if (at[child].time_ns >= last.time_ns) break;
        at[i] = at[child];
        i = child;
    }
    if (count) at[i] = last;
    return first;
}

/* ---- bodies ---- */

/* Of a body that is gone, or of an old deadline. */
static bool is_void(const world *w, const expiry *e)
{
    const body *b = &w->bodies.at[e->body];
    return !b->used || b->ghost || b->serial != e->serial;
}

/* A body has one entry that is not void. */
static void drop_void_entries(world *w)
{
    size_t count = w->expiries.count;
    w->expiries.count = 0;
    for (size_t i = 0; i < count; i++) {
        expiry e = w->expiries.at[i];
        if (!is_void(w, &e)) put_entry(w, e); /* which writes no further than here */
    }
}

static void queue(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (b->expiry_queued || b->expiry_ns == INT64_MAX) return;
    if (w->expiries.count >= 2 * w->bodies.count + SPARE_EXPIRIES) drop_void_entries(w);
    b->expiry_queued = true;
    b->queued_ns = b->expiry_ns;
    put_entry(w, (expiry){b->expiry_ns, id, b->serial});
}

void expiry_set(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    int64_t since = b->stamp_ns && b->stamp_ns < w->now_ns ? b->stamp_ns : w->now_ns; /* clocks of hosts may differ */
    if (!b->deadline_ns || __builtin_add_overflow(since, b->deadline_ns, &b->expiry_ns)) b->expiry_ns = INT64_MAX;
    if (b->expiry_queued && b->expiry_ns < b->queued_ns) { /* the old entry would come too late */
        b->serial = ++w->body_serial;
        b->expiry_queued = false;
    }
    queue(w, id);
}

/* Of many that become stale at once those that are left become so in the next tick, which is due. */
static bool has_reported_enough(world *w)
{
    enum { PART = 4 /* of a slice, at most */ };
    bool enough = w->slice != UINT64_MAX && w->stale_units > w->slice / PART;
    w->sliced |= enough;
    return enough;
}

static void make_stale(world *w, uint32_t id)
{
    w->stale_units += REPORT_UNKNOWN * (uint64_t)(1 + w->bodies.at[id].pair_count);
    w->bodies.at[id].stale = true;
    w->figures.stale_bodies++;
    array_push(&w->stale_now, id);
}

static void make_fresh_what_moved(world *w)
{
    if (!w->figures.stale_bodies) return; /* and no body has to be looked up */
    for (size_t i = 0; i < w->awake.count; i++) {
        body *b = &w->bodies.at[w->awake.at[i]];
        if (!b->used || b->ghost || !b->stale || b->held || b->expiry_ns <= w->now_ns) continue;
        b->stale = false;
        w->figures.stale_bodies--;
        array_push(&w->fresh_now, w->awake.at[i]);
    }
}

static void make_stale_what_is_held(world *w)
{
    size_t i = 0;
    for (; i < w->held_now.count && !has_reported_enough(w); i++) {
        const body *b = &w->bodies.at[w->held_now.at[i]];
        if (b->used && !b->ghost && b->held && !b->stale) make_stale(w, w->held_now.at[i]);
    }
    w->held_now.count -= i;
    if (w->held_now.count) memmove(w->held_now.at, w->held_now.at + i, w->held_now.count * sizeof *w->held_now.at);
}

static void make_stale_what_is_due(world *w)
{
    while (w->expiries.count && w->expiries.at[0].time_ns <= w->now_ns && !has_reported_enough(w)) {
        expiry e = take_entry(w);
        body *b = &w->bodies.at[e.body];
        if (is_void(w, &e)) continue;
        b->expiry_queued = false;
        if (b->stale) continue; /* held; its next pose queues it again */
        if (b->expiry_ns <= w->now_ns)
            make_stale(w, e.body);
        else
            queue(w, e.body);
    }
}

void expiry_find(world *w)
{
    w->stale_now.count = w->fresh_now.count = 0;
    w->stale_units = REPORT_UNKNOWN * (uint64_t)w->unknown_due.count;
    make_fresh_what_moved(w);
    make_stale_what_is_held(w);
    make_stale_what_is_due(w);
    if (w->stale_now.count) qsort(w->stale_now.at, w->stale_now.count, sizeof *w->stale_now.at, sort_compare_u32);
}

int64_t expiry_next_ns(const world *w)
{
    if (w->held_now.count || w->unknown_due.count) return INT64_MIN;
    return w->expiries.count ? w->expiries.at[0].time_ns : INT64_MAX;
}
