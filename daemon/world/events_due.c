/* events_due: what is told without being news of this tick: updates that a rate held back; and the batches of a
 * tick. Tick thread. */
#include "events.h"
#include "interest.h"

#include <stdlib.h>
#include <string.h>

void events_refresh_ages(const world *w, const watch *v, world_event *e)
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
            events_refresh_ages(w, v, &v->foretold);
            events_emit(w, interest_id, &v->foretold, EVENT_FORETOLD, CAUSE_MOTION, v->foretold_id);
        }
        if (!dirty || !(v->touch_id || v->near_id)) continue; /* what was held back has ended */
        events_refresh_ages(w, v, &v->last);
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
        size_t news = i->events.count;
        if (!i->used || !(news || i->snapshot || i->images_told || closes || more_or_less)) continue;
        i->told = i->undone;
        if (news || closes || more_or_less)
            array_push(&w->batches,
                ((world_batch){
                    .interest = id, .closing = closes, .undone = i->undone, .events = i->events.at, .count = news}));
        if (i->images_told && !closes)
            array_push(&w->batches, ((world_batch){.interest = id,
                                        .snapshot = true,
                                        .goes_on = !i->images_begin,
                                        .more = i->snapping,
                                        .undone = i->undone,
                                        .events = i->images.at,
                                        .count = i->images.count}));
        if (closes) i->snapshot = false;
    }
    *out = (world_batches){.at = w->batches.at, .count = w->batches.count, .hash = w->hash};
}
