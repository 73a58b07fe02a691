/* events_due: what is reported without being news of this tick: updates that a rate held back; and the batches of a
 * tick. Tick thread. */
#include "events.h"
#include "soft_state.h"
#include "subscription.h"

#include <stdlib.h>
#include <string.h>

void events_refresh_ages(const world *w, const watch *v, world_event *e)
{
    const pair *p = &w->pairs.at[v->pair];
    const body *a = &w->bodies.at[w->colliders.at[p->a].body], *b = &w->bodies.at[w->colliders.at[p->b].body];
    bool turned = strcmp(e->name_a, a->name) != 0;
    e->age_a_ns = body_age_ns(w, turned ? b : a);
    e->age_b_ns = body_age_ns(w, turned ? a : b);
}

static void release_held(world *w, uint32_t subscription_id)
{
    subscription *i = &w->subscriptions.at[subscription_id];
    for (size_t k = 0; k < i->held.count; k++) {
        watch *v = &w->watches.at[i->held.at[k]];
        if (!watch_is_held_back(w, i->held.at[k], subscription_id)) continue;
        bool dirty = v->dirty, predicted = v->predicted_dirty;
        v->dirty = v->predicted_dirty = false;
        if (v->unknown) continue;
        if (predicted) {
            world_event *last = &w->last_predicted.at[i->held.at[k]];
            events_refresh_ages(w, v, last);
            events_emit(w, subscription_id, last, EVENT_PREDICTED, CAUSE_MOTION, v->predicted_id);
        }
        if (!dirty || !(v->touch_id || v->near_id)) continue; /* what was held back has ended */
        world_event last = watch_contact(w, i->held.at[k]);
        events_refresh_ages(w, v, &last);
        watch_keep_contact(w, i->held.at[k], &last);
        if (v->touch_id)
            events_emit(w, subscription_id, &last, EVENT_UPDATE, CAUSE_MOTION, v->touch_id);
        else
            events_emit(w, subscription_id, &last, EVENT_NEAR, CAUSE_MOTION, v->near_id);
    }
    i->held.count = 0;
}

void events_held_back(world *w)
{
    subscription_sort_lively(w);
    for (size_t k = 0; k < w->lively.count; k++) {
        uint32_t id = (uint32_t)w->lively.at[k];
        subscription *i = &w->subscriptions.at[id];
        if (!i->used || !i->period_ns || !events_may_update(w, i)) continue;
        release_held(w, id);
        if (i->events.count) i->next_update_ns = w->now_ns + i->period_ns;
    }
}

/* Nobody can say yet whose pairs these are; or bodies are held back by what had their names, or are yet to go. */
static size_t undone_in_common(const world *w)
{
    return w->figures.pairs_left_out + (w->match.unmatched.count || w->leaving.count || w->going);
}

void events_collect(world *w, world_batches *out)
{
    size_t common = undone_in_common(w);
    w->batches.count = 0;
    for (uint32_t id = 0; common != w->reported_in_common && id < w->subscriptions.count; id++)
        subscription_wake(w, id);
    w->reported_in_common = common;
    subscription_sort_lively(w);
    for (size_t k = 0; k < w->lively.count; k++) {
        uint32_t id = (uint32_t)w->lively.at[k];
        subscription *i = &w->subscriptions.at[id];
        i->undone += common + subscription_unseen(w, i) + (slices_concern(w, id) ? w->figures.pending_pairs : 0);
        i->undone += i->olds && !i->closing;
        bool more_or_less = i->undone != i->reported,
             closes = i->closing && !i->olds; /* left undone than was told last */
        const world_soft *soft;
        size_t soft_count = soft_told_to(w, id, &soft), news = i->events.count + soft_count;
        if (!i->used || !(news || i->snapshot || i->images_reported || closes || more_or_less)) continue;
        i->reported = i->undone;
        if (news || closes || more_or_less)
            array_push(&w->batches, ((world_batch){.subscription = id,
                                        .closing = closes,
                                        .undone = i->undone,
                                        .soft = soft_count ? soft : NULL,
                                        .soft_count = soft_count,
                                        .events = i->events.at,
                                        .count = i->events.count}));
        if (i->images_reported && !closes)
            array_push(&w->batches, ((world_batch){.subscription = id,
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
