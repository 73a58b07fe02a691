/* events_stale: bodies that become unknown, or known again, and those that teleport. Tick thread. */
#include "events.h"

#include <stdlib.h>

void events_emit_body(world *w, uint32_t body_id, uint32_t interest, uint8_t kind, uint8_t cause)
{
    const body *b = &w->bodies.at[body_id];
    world_event e = {.name_a = b->name,
        .name_b = "*",
        .shape_a = -1,
        .shape_b = -1,
        .achieved = WORLD_WIDE,
        .lo = -INFINITY,
        .hi = INFINITY,
        .age_a_ns = body_age_ns(w, b),
        .age_b_ns = -1};
    events_emit(w, interest, &e, kind, cause, 0);
}

static void tell_whole_body(world *w, uint32_t body_id, uint8_t kind, uint8_t cause)
{
    const body *b = &w->bodies.at[body_id];
    for (size_t word = 0; word < w->words; word++)
        for (uint64_t bits = b->match_a[word] | b->match_b[word]; bits; bits &= bits - 1)
            events_emit_body(w, body_id, (uint32_t)(word * 64) + (uint32_t)__builtin_ctzll(bits), kind, cause);
}

typedef struct pair_list {
    const world *w;
    uint32_t proxy;
    ARRAY(uint32_t) pairs;
} pair_list;

static void list_pair(void *context, uint32_t other)
{
    pair_list *l = context;
    uint32_t id = pair_find(l->w, l->proxy, other);
    if (id != PAIR_MAP_NONE && l->w->pairs.at[id].first_watch != WORLD_NONE) array_push(&l->pairs, id);
}

static int compare_u32(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void tell_watches_unknown(world *w, uint32_t solid_id)
{
    pair_list list = {.w = w, .proxy = solid_id};
    broad_each_pair_of(w->broad, solid_id, list_pair, &list);
    if (list.pairs.count) qsort(list.pairs.at, list.pairs.count, sizeof *list.pairs.at, compare_u32);
    for (size_t i = 0; i < list.pairs.count; i++) {
        for (uint32_t id = w->pairs.at[list.pairs.at[i]].first_watch; id != WORLD_NONE;
             id = w->watches.at[id].pair_next) {
            watch *v = &w->watches.at[id];
            if (v->unknown) continue;
            v->unknown = true;
            events_emit(w, v->interest, watch_last(v), EVENT_UNKNOWN, CAUSE_STALE, watch_id(v));
        }
    }
    array_free(&list.pairs);
}

/* What they were to each other ends where they were. */
void events_teleported(world *w)
{
    if (w->teleported.count) qsort(w->teleported.at, w->teleported.count, sizeof *w->teleported.at, compare_u32);
    for (size_t i = 0; i < w->teleported.count; i++) {
        const body *b = &w->bodies.at[w->teleported.at[i]];
        if (!b->used || b->ghost || !b->teleported) continue;
        for (size_t k = 0; k < b->shape_count; k++) {
            pair_list list = {.w = w, .proxy = b->shapes[k]};
            broad_each_pair_of(w->broad, b->shapes[k], list_pair, &list);
            if (list.pairs.count) qsort(list.pairs.at, list.pairs.count, sizeof *list.pairs.at, compare_u32);
            for (size_t n = 0; n < list.pairs.count; n++) events_pair_ended(w, list.pairs.at[n], CAUSE_TELEPORT);
            array_free(&list.pairs);
        }
    }
    w->teleported.count = 0;
}

void events_unknown(world *w)
{
    for (size_t i = 0; i < w->stale_now.count; i++) {
        const body *b = &w->bodies.at[w->stale_now.at[i]];
        tell_whole_body(w, w->stale_now.at[i], EVENT_UNKNOWN, CAUSE_STALE);
        for (size_t k = 0; k < b->shape_count; k++) tell_watches_unknown(w, b->shapes[k]);
    }
}

/* A stale body that was removed is not unknown any more either: it is gone. */
void events_known(world *w)
{
    for (size_t i = 0; i < w->fresh_now.count; i++) tell_whole_body(w, w->fresh_now.at[i], EVENT_KNOWN, CAUSE_MOTION);
    for (size_t i = 0; i < w->reap.count; i++) {
        const body *b = &w->bodies.at[w->reap.at[i]];
        if (b->stale) tell_whole_body(w, w->reap.at[i], EVENT_KNOWN, b->ghost_cause);
    }
}
