/* events_stale: bodies that become unknown, or known again, and those that teleport. Tick thread. */
#include "events.h"
#include "match.h"

#include <stdlib.h>
#include <string.h>

world_event events_of_body(const world *w, uint32_t body_id)
{
    const body *b = &w->bodies.at[body_id];
    return (world_event){.name_a = b->name,
        .name_b = "*",
        .shape_a = -1,
        .shape_b = -1,
        .achieved = WORLD_WIDE,
        .lo = -INFINITY,
        .hi = INFINITY,
        .age_a_ns = body_age_ns(w, b),
        .age_b_ns = -1};
}

void events_emit_body(world *w, uint32_t body_id, uint32_t subscription, uint8_t kind, uint8_t cause)
{
    world_event e = events_of_body(w, body_id);
    events_emit(w, subscription, &e, kind, cause, 0);
}

/* Who changed in this tick has not heard of a body that is gone. */
static void report_whole_body(world *w, uint32_t body_id, uint8_t kind, uint8_t cause)
{
    const body *b = &w->bodies.at[body_id];
    match_list all = match_of_class(&w->match, b->match);
    for (uint32_t k = 0; k < all.count; k++)
        if (!b->ghost || w->subscriptions.at[all.at[k]].changed_tick != w->figures.ticks)
            events_emit_body(w, body_id, all.at[k], kind, cause);
}

typedef struct watched { /* reported pairs of a collider, by their keys: ids of pairs follow from boxes
                          */
    const world *w;
    uint32_t collider;
    ARRAY(uint64_t) keys;
} watched;

static void list_pair(void *context, uint32_t other)
{
    watched *l = context;
    uint32_t id = pair_find(l->w, l->collider, other);
    if (id != PAIR_MAP_NONE && l->w->pairs.at[id].first_watch != WORLD_NONE)
        array_push(&l->keys, pair_key(l->w->pairs.at[id].a, l->w->pairs.at[id].b));
}

static void list_lingering(watched *l)
{
    for (size_t i = 0; i < l->w->lingering.count; i++) {
        const pair *p = &l->w->pairs.at[l->w->lingering.at[i]];
        if (p->a == l->collider || p->b == l->collider) array_push(&l->keys, pair_key(p->a, p->b));
    }
}

static int compare_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static void report_pair_unknown(world *w, uint64_t key)
{
    uint32_t place = pair_map_get(&w->pair_of, key);
    const pair *p = place == PAIR_MAP_NONE ? NULL : &w->pairs.at[place]; /* NULL: it has ended meanwhile */
    if (!p || !(w->bodies.at[w->colliders.at[p->a].body].stale || w->bodies.at[w->colliders.at[p->b].body].stale))
        return;
    for (uint32_t id = p->first_watch; id != WORLD_NONE; id = w->watches.at[id].pair_next) {
        watch *v = &w->watches.at[id];
        if (v->unknown) continue;
        snapshot_before(w, id);
        v->unknown = true;
        world_event last = watch_last(w, id);
        events_emit(w, v->subscription, &last, EVENT_UNKNOWN, CAUSE_STALE, watch_id(v));
    }
}

static void list_pairs(world *w, uint32_t collider_id)
{
    watched list = {.w = w, .collider = collider_id};
    broad_each_pair_of(w->broad, collider_id, list_pair, &list);
    list_lingering(&list);
    if (list.keys.count) qsort(list.keys.at, list.keys.count, sizeof *list.keys.at, compare_keys);
    for (size_t i = 0; i < list.keys.count; i++) array_push(&w->unknown_due, list.keys.at[i]);
    array_free(&list.keys);
}

/* One body alone may have more pairs than a tick has time to tell of: the others follow in the next ones. That it is
 * unknown as a whole has been told. */
static void report_pairs_unknown(world *w, size_t *most)
{
    size_t some = w->unknown_due.count < *most ? w->unknown_due.count : *most;
    for (size_t i = 0; i < some; i++) report_pair_unknown(w, w->unknown_due.at[i]);
    *most -= some;
    w->unknown_due.count -= some;
    if (some && w->unknown_due.count)
        memmove(w->unknown_due.at, w->unknown_due.at + some, w->unknown_due.count * sizeof *w->unknown_due.at);
}

/* What they were to each other ends where they were. All pairs of what was moved are active, or will be. */
void events_teleported(world *w)
{
    if (!w->some_teleported) return;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        const pair *p = &w->pairs.at[w->active_pairs.at[k]];
        if (p->jumped) events_pair_ended(w, w->active_pairs.at[k], CAUSE_TELEPORT);
    }
    w->some_teleported = false;
}

void events_unknown(world *w)
{
    enum { PART = 4 /* of a slice, at most */, SOME_AT_LEAST = 64 };
    size_t most = w->slice == UINT64_MAX ? SIZE_MAX : (size_t)(w->slice / PART / REPORT_UNKNOWN);
    if (most < SOME_AT_LEAST) most = SOME_AT_LEAST;
    report_pairs_unknown(w, &most);
    for (size_t i = 0; i < w->stale_now.count; i++) {
        const body *b = &w->bodies.at[w->stale_now.at[i]];
        report_whole_body(w, w->stale_now.at[i], EVENT_UNKNOWN, CAUSE_STALE);
        for (size_t k = 0; k < b->shape_count; k++) list_pairs(w, b->shapes[k]);
        report_pairs_unknown(w, &most);
    }
    w->sliced |= w->unknown_due.count > 0;
}

/* A stale body that was removed is not unknown any more either: it is gone. */
void events_known(world *w)
{
    for (size_t i = 0; i < w->fresh_now.count; i++) report_whole_body(w, w->fresh_now.at[i], EVENT_KNOWN, CAUSE_MOTION);
    for (size_t i = 0; i < w->reap.count; i++) {
        body *b = &w->bodies.at[w->reap.at[i]];
        if (b->stale) report_whole_body(w, w->reap.at[i], EVENT_KNOWN, b->ghost_cause);
        b->stale = false;
    }
}
