/* events_due: what is told without being news of this tick: updates that a rate held back, snapshots; and the
 * batches of a tick. Tick thread. */
#include "events.h"

#include <stdlib.h>
#include <string.h>

static void refresh_ages(const world *w, const watch *v, world_event *e)
{
    const pair *p = &w->pairs.at[v->pair];
    const body *a = &w->bodies.at[w->solids.at[p->a].body], *b = &w->bodies.at[w->solids.at[p->b].body];
    bool turned = strcmp(e->name_a, a->name) != 0;
    e->age_a_ns = body_age_ns(w, turned ? b : a);
    e->age_b_ns = body_age_ns(w, turned ? a : b);
}

static void release_held(world *w, uint32_t interest_id)
{
    interest *i = &w->interests.at[interest_id];
    for (size_t k = 0; k < i->held.count; k++) {
        watch *v = &w->watches.at[i->held.at[k]];
        if (!watch_is_held_back(w, i->held.at[k], interest_id)) continue;
        bool dirty = v->dirty, foretold = v->foretold_dirty;
        v->dirty = v->foretold_dirty = false;
        if (v->unknown) continue;
        if (foretold) {
            refresh_ages(w, v, &v->foretold);
            events_emit(w, interest_id, &v->foretold, EVENT_FORETOLD, CAUSE_MOTION, v->foretold_id);
        }
        if (!dirty || !(v->touch_id || v->near_id)) continue; /* what was held back has ended */
        refresh_ages(w, v, &v->last);
        if (v->touch_id)
            events_emit(w, interest_id, &v->last, EVENT_UPDATE, CAUSE_MOTION, v->touch_id);
        else
            events_emit(w, interest_id, &v->last, EVENT_NEAR, CAUSE_MOTION, v->near_id);
    }
    i->held.count = 0;
}

void events_held_back(world *w)
{
    interest_sort_lively(w);
    for (size_t k = 0; k < w->lively.count; k++) {
        uint32_t id = (uint32_t)w->lively.at[k];
        interest *i = &w->interests.at[id];
        if (!i->used || !i->period_ns || !events_may_update(w, i)) continue;
        release_held(w, id);
        if (i->events.count) i->next_update_ns = w->now_ns + i->period_ns;
    }
}

static int compare_events(const void *a, const void *b)
{
    const world_event *x = a, *y = b;
    return (x->contact > y->contact) - (x->contact < y->contact);
}

/* Everything that is, as if it began now, in a batch of its own behind the events of this tick: who was in step needs
 * those, who was not needs only this. */
static void snapshot(world *w, uint32_t id)
{
    interest *i = &w->interests.at[id];
    size_t kept = i->snapshot_first = i->events.count;
    for (uint32_t v = i->first_watch; v != WORLD_NONE; v = w->watches.at[v].interest_next) {
        const watch *at = &w->watches.at[v];
        world_event now =
            *watch_last(at); /* a copy: what later events tell may not depend on who asked for a snapshot */
        refresh_ages(w, at, &now);
        if (at->touch_id) events_emit(w, id, &now, EVENT_BEGIN, CAUSE_SNAPSHOT, at->touch_id);
        if (at->near_id) events_emit(w, id, &now, EVENT_NEAR, CAUSE_SNAPSHOT, at->near_id);
        if (!at->foretold_id) continue;
        now = at->foretold;
        refresh_ages(w, at, &now);
        events_emit(w, id, &now, EVENT_FORETOLD, CAUSE_SNAPSHOT, at->foretold_id);
    }
    i = &w->interests.at[id];
    if (i->events.count > kept)
        qsort(i->events.at + kept, i->events.count - kept, sizeof *i->events.at, compare_events);
    for (uint32_t v = i->first_watch; v != WORLD_NONE; v = w->watches.at[v].interest_next) {
        const watch *at = &w->watches.at[v];
        if (at->unknown) events_emit(w, id, watch_last(at), EVENT_UNKNOWN, CAUSE_SNAPSHOT, watch_id(at));
    }
    if (!w->figures.stale_bodies) return;
    for (uint32_t b = 0; b < w->bodies.count; b++) {
        const body *at = &w->bodies.at[b];
        if (at->used && !at->ghost && at->stale && interest_has(w, id, at))
            events_emit_body(w, b, id, EVENT_UNKNOWN, CAUSE_SNAPSHOT);
    }
}

/* The whole state is not known before all bodies have been looked at for it, and what is told of it stands beside
 * nothing that was told under other terms. */
static bool gets_snapshot(const interest *i)
{
    return i->used && i->snapshot && !i->closing && i->settling == SETTLED && !i->olds;
}

void events_snapshots(world *w)
{
    for (size_t k = 0; k < w->lively.count; k++) {
        uint32_t id = (uint32_t)w->lively.at[k];
        if (gets_snapshot(&w->interests.at[id])) snapshot(w, id);
    }
}

/* Nobody can say yet whose pairs these are; or bodies are held back by what had their names. */
static size_t undone_in_common(const world *w)
{
    return w->figures.pairs_left_out + (w->match.unmatched.count > 0 || w->leaving.count > 0);
}

void events_collect(world *w, world_batches *out)
{
    size_t common = undone_in_common(w);
    w->batches.count = 0;
    for (uint32_t id = 0; common != w->told_in_common && id < w->interests.count; id++) interest_wake(w, id);
    w->told_in_common = common;
    interest_sort_lively(w);
    for (size_t k = 0; k < w->lively.count; k++) {
        uint32_t id = (uint32_t)w->lively.at[k];
        interest *i = &w->interests.at[id];
        i->undone += common + interest_unseen(w, i) + (slices_concern(w, id) ? w->figures.pending_pairs : 0);
        i->undone += i->olds && !i->closing;
        bool more_or_less = i->undone != i->told, closes = i->closing && !i->olds; /* left undone than was told last */
        if (!i->used || !(i->events.count || i->snapshot || closes || more_or_less)) continue;
        bool told = gets_snapshot(i);
        size_t news = told ? i->snapshot_first : i->events.count;
        i->told = i->undone;
        if (news || closes || more_or_less)
            array_push(&w->batches, ((world_batch){.interest = id,
                                        .closing = closes,
                                        .undone = i->undone,
                                        .events = i->events.at,
                                        .count = news}));
        if (told)
            array_push(&w->batches, ((world_batch){.interest = id,
                                        .snapshot = true,
                                        .undone = i->undone,
                                        .events = i->events.at ? i->events.at + news : NULL,
                                        .count = i->events.count - news}));
        if (told || closes) i->snapshot = false;
    }
    *out = (world_batches){.at = w->batches.at, .count = w->batches.count, .hash = w->hash};
}
