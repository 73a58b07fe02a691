/* watch: what one subscription was told of one pair, from the first event to the end. Whatever ends it, each id that
 * stands has its end: here, or where the outcome of a tick says so (events.c, events_impact.c). Tick thread. */
#include "events.h"
#include "subscription.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

int64_t watch_id(const watch *v)
{
    return v->touch_id ? v->touch_id : v->near_id ? v->near_id : v->predicted_id;
}

/* Room for what is reported of it; memory only where something is. */
static void reserve_last(world *w, uint32_t id)
{
    array_reserve_in_place(&w->last_contacts, (size_t)id + 1);
    array_reserve_in_place(&w->last_points, (size_t)id + 1);
    array_reserve_in_place(&w->last_predicted, (size_t)id + 1);
}

void watch_reserve(world *w, size_t count)
{
    array_reserve_in_place(&w->watches, count);
    if (count) reserve_last(w, (uint32_t)count - 1);
}

void watch_keep_contact(world *w, uint32_t id, const world_event *e)
{
    watch *v = &w->watches.at[id];
    const body *a = &w->bodies.at[w->colliders.at[w->pairs.at[v->pair].a].body];
    v->has_contact = true;
    w->last_contacts.at[id] = (last_contact){.lo = e->lo,
        .hi = e->hi,
        .axis = e->axis,
        .point_a = e->point_a,
        .point_b = e->point_b,
        .closing = e->closing,
        .age_a_ns = e->age_a_ns,
        .age_b_ns = e->age_b_ns,
        .shape_a = e->shape_a,
        .shape_b = e->shape_b,
        .achieved = e->achieved,
        .points = (uint8_t)e->manifold.count,
        .turned = e->name_a != a->name};
    memcpy(w->last_points.at[id].at, e->manifold.points, e->manifold.count * sizeof(manifold_point));
}

world_event watch_contact(const world *w, uint32_t id)
{
    const last_contact *l = &w->last_contacts.at[id];
    const pair *p = &w->pairs.at[w->watches.at[id].pair];
    const char *a = w->bodies.at[w->colliders.at[p->a].body].name, *b = w->bodies.at[w->colliders.at[p->b].body].name;
    world_event e = {.name_a = l->turned ? b : a,
        .name_b = l->turned ? a : b,
        .lo = l->lo,
        .hi = l->hi,
        .axis = l->axis,
        .point_a = l->point_a,
        .point_b = l->point_b,
        .closing = l->closing,
        .age_a_ns = l->age_a_ns,
        .age_b_ns = l->age_b_ns,
        .shape_a = l->shape_a,
        .shape_b = l->shape_b,
        .achieved = l->achieved,
        .manifold = {.count = l->points}};
    memcpy(e.manifold.points, w->last_points.at[id].at, l->points * sizeof(manifold_point));
    return e;
}

static bool is_same_memory(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static bool is_vec(const vec3 *a, const vec3 *b)
{
    return is_same_memory(a, b, sizeof *a);
}

static bool are_points(const last_points *kept, const manifold *m)
{
    bool same = true;
    for (uint32_t i = 0; same && i < m->count; i++) {
        const manifold_point *p = &kept->at[i], *q = &m->points[i];
        same = p->feature == q->feature && is_vec(&p->point, &q->point) &&
               is_same_memory(&p->distance, &q->distance, sizeof p->distance);
    }
    return same;
}

bool watch_has_said(const world *w, uint32_t id, const world_event *e)
{
    const last_contact *l = &w->last_contacts.at[id];
    const body *a = &w->bodies.at[w->colliders.at[w->pairs.at[w->watches.at[id].pair].a].body];
    bool turned = e->name_a != a->name;
    return is_same_memory(&l->lo, &e->lo, sizeof l->lo) && is_same_memory(&l->hi, &e->hi, sizeof l->hi) &&
           is_vec(&l->axis, &e->axis) && is_vec(&l->point_a, &e->point_a) && is_vec(&l->point_b, &e->point_b) &&
           is_same_memory(&l->closing, &e->closing, sizeof l->closing) && l->achieved == e->achieved &&
           l->shape_a == e->shape_a && l->shape_b == e->shape_b && l->turned == turned &&
           l->points == e->manifold.count && are_points(&w->last_points.at[id], &e->manifold);
}

void watch_fetch_last(const world *w, uint32_t id)
{
    const last_contact *l = &w->last_contacts.at[id];
    __builtin_prefetch(l, 1);
    __builtin_prefetch((const char *)l + 64, 1);
}

void watch_keep_predicted(world *w, uint32_t id, const world_event *e)
{
    w->watches.at[id].has_predicted = true;
    w->last_predicted.at[id] = *e;
}

world_event watch_last(const world *w, uint32_t id)
{
    const watch *v = &w->watches.at[id];
    return v->touch_id || v->near_id ? watch_contact(w, id) : w->last_predicted.at[id];
}

uint32_t watch_find(world *w, const pair *p, uint32_t subscription)
{
    uint32_t id = p->first_watch;
    while (id != WORLD_NONE && w->watches.at[id].subscription < subscription) id = w->watches.at[id].pair_next;
    if (id == WORLD_NONE || w->watches.at[id].subscription != subscription) return WORLD_NONE;
    snapshot_before(w, id);
    if (!watch_is_old(w, &w->watches.at[id])) return id;
    watch_end(w, id, CAUSE_SUBSCRIPTION);
    return WORLD_NONE;
}

uint32_t watch_add(world *w, uint32_t pair_id, uint32_t subscription_id)
{
    assert(w->pairs.at[pair_id].used && w->subscriptions.at[subscription_id].used);
    uint32_t id = id_pool_take(&w->watch_ids);
    watch_reserve(w, (size_t)id + 1);
    if (id >= w->watches.count) w->watches.count = id + 1;
    watch *v = &w->watches.at[id];
    subscription *i = &w->subscriptions.at[subscription_id];
    *v = (watch){.used = true,
        .pair = pair_id,
        .snap = i->snap,
        .subscription = subscription_id,
        .subscription_next = i->first_watch,
        .subscription_prev = WORLD_NONE};
    if (i->first_watch != WORLD_NONE)
        w->watches.at[i->first_watch].subscription_prev = id;
    else
        i->last_watch = id;
    i->first_watch = id;
    i->watches++;
    news_begins(w, id);

    uint32_t *link = &w->pairs.at[pair_id].first_watch;
    while (*link != WORLD_NONE && w->watches.at[*link].subscription < subscription_id)
        link = &w->watches.at[*link].pair_next;
    assert(
        *link == WORLD_NONE || w->watches.at[*link].subscription > subscription_id); /* one a pair and subscription */
    v->pair_next = *link;
    *link = id;
    return id;
}

/* It is in one of the subscription's two lists. */
static void leave_list(world *w, uint32_t id)
{
    const watch *v = &w->watches.at[id];
    subscription *i = &w->subscriptions.at[v->subscription];
    if (i->snap_next == id) i->snap_next = v->subscription_next;
    if (v->subscription_prev != WORLD_NONE)
        w->watches.at[v->subscription_prev].subscription_next = v->subscription_next;
    else
        *(i->first_old == id ? &i->first_old : &i->first_watch) = v->subscription_next;
    if (v->subscription_next != WORLD_NONE)
        w->watches.at[v->subscription_next].subscription_prev = v->subscription_prev;
    else
        *(i->last_old == id ? &i->last_old : &i->last_watch) = v->subscription_prev;
}

void watch_drop(world *w, uint32_t id)
{
    watch *v = &w->watches.at[id];
    assert(id < w->watches.count && v->used && w->subscriptions.at[v->subscription].watches > 0);
    uint32_t *link = &w->pairs.at[v->pair].first_watch;
    while (*link != id) link = &w->watches.at[*link].pair_next;
    *link = v->pair_next;
    bool old = watch_is_old(w, v);
    leave_list(w, id);
    v->used = false;
    pair_note_reported(w, v->pair);
    w->subscriptions.at[v->subscription].watches--;
    w->subscriptions.at[v->subscription].olds -= old;
    w->olds -= old;
    id_pool_give(&w->watch_ids, id);
}

bool watch_is_held_back(const world *w, uint32_t id, uint32_t subscription)
{
    const watch *v = &w->watches.at[id];
    return v->used && v->subscription == subscription && (v->dirty || v->predicted_dirty);
}

/* Leaves out watches that have ended since, and of one whose id was another's each entry but the first: in the order in
 * which they would have been told, too. */
static void drop_void_held(world *w, uint32_t subscription_id)
{
    subscription *i = &w->subscriptions.at[subscription_id];
    size_t kept = 0;
    for (size_t k = 0; k < i->held.count; k++) w->watches.at[i->held.at[k]].listed = false;
    for (size_t k = 0; k < i->held.count; k++) {
        watch *v = &w->watches.at[i->held.at[k]];
        if (v->listed || !watch_is_held_back(w, i->held.at[k], subscription_id)) continue;
        v->listed = true;
        i->held.at[kept++] = i->held.at[k];
    }
    i->held.count = kept;
}

void watch_hold_back(world *w, uint32_t id)
{
    uint32_t subscription_id = w->watches.at[id].subscription;
    subscription *i = &w->subscriptions.at[subscription_id];
    if (i->held.count >= 2 * i->watches + SPARE_HELD) drop_void_held(w, subscription_id);
    array_push(&i->held, id);
    subscription_wake(w, subscription_id);
}

void watch_end(world *w, uint32_t id, uint8_t cause)
{
    const watch *v = &w->watches.at[id];
    snapshot_before(w, id);
    if (v->touch_id || v->near_id) {
        world_event last = watch_contact(w, id);
        if (v->touch_id) events_emit(w, v->subscription, &last, EVENT_END, cause, v->touch_id);
        w->figures.contacts -= v->touch_id != 0;
        if (v->near_id) events_emit(w, v->subscription, &last, EVENT_FAR, cause, v->near_id);
    }
    if (v->predicted_id)
        events_emit(w, v->subscription, &w->last_predicted.at[id], EVENT_AVERTED, cause, v->predicted_id);
    watch_drop(w, id);
}

void events_pair_ended(world *w, uint32_t pair_id, uint8_t cause)
{
    for (uint32_t id; (id = w->pairs.at[pair_id].first_watch) != WORLD_NONE;)
        watch_end(w, id, cause == CAUSE_SUBSCRIPTION ? closing_cause(w, w->watches.at[id].subscription) : cause);
}

/* Pairs that stay for others, but are none to a subscription any more: a body is in another group. */
void events_unmatched(world *w)
{
    if (!w->rematched && !w->sliced) return;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        const pair *p = &w->pairs.at[w->active_pairs.at[k]];
        if (p->first_watch == WORLD_NONE) continue;
        match_list wanted = subscription_list(w, p);
        uint32_t at = 0; /* both are in the order of subscriptions */
        for (uint32_t id = p->first_watch, after; id != WORLD_NONE; id = after) {
            uint32_t subscription = w->watches.at[id].subscription;
            after = w->watches.at[id].pair_next;
            while (at < wanted.count && wanted.at[at] < subscription) at++;
            if (at == wanted.count || wanted.at[at] != subscription) watch_end(w, id, closing_cause(w, subscription));
        }
    }
}
