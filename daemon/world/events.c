/* events: what the outcomes of a tick mean to each subscription: begin, update, end, near, far. Impacts and what is
 * predicted are reported by events_impact.c, the unknown by events_stale.c, what is due without news by events_due.c.
 * Tick thread.
 *
 * Pairs are walked in the order of their colliders' ids and subscriptions by theirs, so ids and order of events follow
 * from the commands, and from nothing that is in the broad phase: neither how fat its boxes are, nor in which order it
 * has found pairs, nor the ids that these were given. A contact id has exactly one begin and one end: it is taken in
 * `begin_or_end_touch` and given up there, or in `watch_end` when the pair or the subscription goes. */
#include "events.h"
#include "soft_state.h"

#include "subscription.h"

#include <string.h>

bool events_may_update(const world *w, const subscription *i)
{
    return !i->period_ns || w->now_ns >= i->next_update_ns;
}

/* A rate-limited update is sent at the next permitted time, even if the pair has returned to its old state. */
static void update(world *w, uint32_t id, const world_event *now, uint8_t kind, int64_t contact, bool news)
{
    watch *v = &w->watches.at[id];
    subscription *i = &w->subscriptions.at[v->subscription];
    if (!news && !v->dirty && !i->all) return;
    if (events_may_update(w, i)) {
        v->dirty = false;
        events_emit(w, v->subscription, now, kind, CAUSE_MOTION, contact);
    } else if (!v->dirty) {
        v->dirty = true;
        watch_hold_back(w, id);
    }
}

static void begin_or_end_touch(world *w, watch *v, const world_event *now, bool touches, uint8_t cause)
{
    if (touches && !v->touch_id) {
        v->touch_id = ++w->serial;
        w->figures.contacts++;
        events_emit(w, v->subscription, now, EVENT_BEGIN, cause, v->touch_id);
    } else if (!touches && v->touch_id) {
        events_emit(w, v->subscription, now, EVENT_END, cause, v->touch_id);
        v->touch_id = 0;
        w->figures.contacts--;
    }
}

/* A pair in contact is near as well: both episodes have an id, a begin and an end of their own; while it lasts, the
 * contact alone is updated. */
static void transit(world *w, uint32_t id, const world_event *now, bool touches, bool near, bool news, uint8_t cause)
{
    watch *v = &w->watches.at[id];
    bool touched = v->touch_id, was_near = v->near_id;
    if (v->unknown) {
        v->unknown = false;
        news = true;
        const world_event *first = v->touch_id || v->near_id ? now : &w->last_predicted.at[id];
        events_emit(w, v->subscription, first, EVENT_KNOWN, CAUSE_MOTION, watch_id(v));
    }
    if (near && !was_near) {
        v->near_id = ++w->serial;
        events_emit(w, v->subscription, now, EVENT_NEAR, cause, v->near_id);
    }
    begin_or_end_touch(w, v, now, touches, cause);
    if (touched && touches)
        update(w, id, now, EVENT_UPDATE, v->touch_id, news);
    else if (near && was_near && !touches)
        update(w, id, now, EVENT_NEAR, v->near_id, news || touched);
    if (!near && was_near) {
        events_emit(w, v->subscription, now, EVENT_FAR, cause, v->near_id);
        v->near_id = 0;
    }
    if (touched != (v->touch_id != 0) || was_near != (v->near_id != 0)) pair_note_reported(w, v->pair);
    if (!watch_id(v)) watch_drop(w, id);
}

typedef struct terms { /* under which a pair is judged in this tick */
    pair_terms distances;
    uint8_t cause; /* of what begins or ends */
} terms;

static terms terms_of(const pair *p)
{
    return (terms){pair_kept_terms(p), p->ruled ? CAUSE_FILTER : CAUSE_MOTION};
}

uint8_t events_achieved(const narrow_result *r, const outcome *o, double limit)
{
    if (o->left) return WORLD_STOPPED;
    if (r->status == NARROW_WIDE) return WORLD_WIDE;
    return r->lo > limit || r->hi <= limit ? WORLD_CERTAIN : WORLD_WITHIN;
}

static void report(world *w, uint32_t pair_id, const outcome *o, uint32_t subscription_id, const terms *t)
{
    const narrow_result *r = &w->results.at[o->result];
    const pair *p = &w->pairs.at[pair_id];
    const subscription *i = &w->subscriptions.at[subscription_id];
    double threshold = i->threshold + t->distances.padding, range = i->range + t->distances.margin;
    uint32_t id = watch_find(w, p, subscription_id);
    if (id != WORLD_NONE && w->watches.at[id].touch_id) threshold += i->hysteresis;
    if (id != WORLD_NONE && w->watches.at[id].near_id) range += i->hysteresis;
    bool touches = i->facts & (WORLD_TOUCH | WORLD_MANIFOLD) && r->lo <= threshold;
    bool near = i->facts & WORLD_DISTANCE && r->lo <= range;
    const soft_result *soft = NULL;
    bool is_soft = pair_is_soft(w, p);
    if (is_soft) {
        near = false;
        touches =
            soft_touches(w, p, i->threshold + t->distances.padding, &soft) && i->facts & (WORLD_TOUCH | WORLD_MANIFOLD);
        if (!soft) return;
    }
    if (id == WORLD_NONE && !touches && !near) return;
    if (id == WORLD_NONE) id = watch_add(w, pair_id, subscription_id);
    watch *v = &w->watches.at[id];
    world_event now;
    events_fill(w, p, r, subscription_id, t->distances.looks, &now);
    now.achieved = events_achieved(r, o, touches || !(i->facts & WORLD_DISTANCE) ? threshold : range);
    if (is_soft) now.achieved = soft->unfinished ? WORLD_WIDE : WORLD_CERTAIN;
    if (!(i->facts & WORLD_MANIFOLD) || !touches) now.manifold.count = 0;
    bool news = v->recovered || !(v->touch_id || v->near_id) || !watch_has_said(w, id, &now);
    v->recovered = false;
    watch_keep_contact(w, id, &now);
    transit(w, id, &now, touches, near, news, t->cause);
}

/* What lies beyond the caches in a large world is asked for while pairs before it are reported: a pair, then its shapes
 * and what was reported of it, then its bodies, at last their names. */
static inline void fetch_reported_body(const body *b)
{
    __builtin_prefetch(&b->pose);
    __builtin_prefetch(&b->region);
    __builtin_prefetch(&b->before);
    __builtin_prefetch(&b->fixed);
    __builtin_prefetch(&b->name);
}

static inline void events_fetch_ahead(const world *w, const uint32_t *told, size_t n, size_t count)
{
    enum { PAIRS_AHEAD = 16, SHAPES_AHEAD = 12, BODIES_AHEAD = 8, NAMES_AHEAD = 4 };
    if (n + PAIRS_AHEAD >= count) return;
    __builtin_prefetch(&w->pairs.at[w->active_pairs.at[told[n + PAIRS_AHEAD]]]);
    const pair *p = &w->pairs.at[w->active_pairs.at[told[n + SHAPES_AHEAD]]];
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    __builtin_prefetch(&a->world);
    __builtin_prefetch(&a->body);
    __builtin_prefetch(&b->body);
    if (p->first_watch != WORLD_NONE) {
        __builtin_prefetch(&w->watches.at[p->first_watch], 1);
        watch_fetch_last(w, p->first_watch);
    }
    p = &w->pairs.at[w->active_pairs.at[told[n + BODIES_AHEAD]]];
    fetch_reported_body(&w->bodies.at[w->colliders.at[p->a].body]);
    fetch_reported_body(&w->bodies.at[w->colliders.at[p->b].body]);
    p = &w->pairs.at[w->active_pairs.at[told[n + NAMES_AHEAD]]];
    __builtin_prefetch(w->bodies.at[w->colliders.at[p->a].body].name);
    __builtin_prefetch(w->bodies.at[w->colliders.at[p->b].body].name);
}

/* Of the active pairs, those that have a result. */
static const uint32_t *list_told(world *w, size_t *count)
{
    array_reserve(&w->told, w->active_pairs.count);
    uint32_t *at = w->told.at;
    size_t n = 0;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        at[n] = (uint32_t)k;
        n += w->outcomes.at[k].result != WORLD_NONE;
    }
    *count = n;
    return at;
}

void events_of_active(world *w)
{
    size_t count;
    const uint32_t *told = list_told(w, &count);
    for (size_t n = 0; n < count; n++) {
        events_fetch_ahead(w, told, n, count);
        size_t k = told[n];
        uint32_t id = w->active_pairs.at[k];
        const pair *p = &w->pairs.at[id];
        terms t = terms_of(p);
        match_list wanted = subscription_list(w, p);
        for (uint32_t i = 0; i < wanted.count; i++) report(w, id, &w->outcomes.at[k], wanted.at[i], &t);
    }
}
