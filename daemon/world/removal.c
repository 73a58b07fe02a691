/* removal: bodies that go because their client does, which may be very many at once. Tick thread.
 *
 * A tick removes as many as a share of its slice allows, by turns of their owners, in the order in which it was told of
 * them. The others stand where they are, and are told of as such: nothing ends, or is free, before its turn. But they
 * hold neither their names nor a place among those that may be there: who takes the name of one makes it go first. All
 * of it is counted. */
#include "state.h"

#include <stdlib.h>

enum {
    A_BODY = 500, /* units: it is taken out of all that knows it, and out of memory a tick later */
    A_SHAPE = 1000,
    A_RULE = 600,       /* two texts */
    SOME = 4,           /* of an owner, in a row ... */
    SOME_UNITS = 50000, /* ... if they take no more than that */
    PART = 4            /* of a slice, at most */
};

static goers *goers_of(world *w, uint64_t owner)
{
    goers *empty = NULL;
    for (size_t i = 0; i < w->goers.count; i++) {
        goers *g = &w->goers.at[i];
        if (g->list.count && g->owner == owner) return g;
        if (!g->list.count && !empty) empty = g;
    }
    if (!empty) {
        array_push(&w->goers, (goers){.first = 0});
        empty = &w->goers.at[w->goers.count - 1];
    }
    empty->owner = owner;
    w->goer = (size_t)(empty - w->goers.at);
    return empty;
}

/* The one of before, most often. */
static goers *goers_for(world *w, uint64_t owner)
{
    goers *last = w->goer < w->goers.count ? &w->goers.at[w->goer] : NULL;
    return last && last->list.count && last->owner == owner ? last : goers_of(w, owner);
}

world_status world_remove_soon(world *w, uint32_t id, uint8_t cause)
{
    if (!body_is(w, id)) return WORLD_UNKNOWN_ID;
    enum { AHEAD = 16 }; /* a client's bodies most often have ids that follow each other, and all of them go */
    body *b = &w->bodies.at[id], *later = &w->bodies.at[id + AHEAD < w->bodies.count ? id + AHEAD : id];
    __builtin_prefetch(&later->goes, 1);
    __builtin_prefetch(&later->owner);
    __builtin_prefetch(&later->label);
    if (b->goes) return WORLD_OK;
    b->goes = true;
    b->ghost_cause = cause;
    w->going++;
    w->figures.bodies--;
    w->figures.shapes -= b->shape_count;
    w->changed = true;
    goers *g = goers_for(w, b->owner);
    array_push(&g->list, ((goer){b->label, id}));
    return WORLD_OK;
}

bool world_some_go(const world *w)
{
    return w->going > 0;
}

/* It does now: what was counted when it was told is counted where it is done. */
void removal_forget(world *w, body *b)
{
    if (!b->goes) return;
    b->goes = false;
    w->going--;
    w->figures.bodies++;
    w->figures.shapes += b->shape_count;
}

bool removal_hastens(world *w, uint32_t id)
{
    if (id == WORLD_NONE || !w->bodies.at[id].goes) return false;
    return world_remove_body(w, id, w->bodies.at[id].ghost_cause) == WORLD_OK;
}

uint64_t removal_units(const body *b)
{
    return A_BODY + A_SHAPE * (uint64_t)b->shape_count + A_RULE * (uint64_t)b->rule_count;
}

/* 0: that one went before, and its id may be another's. */
static uint64_t remove_one(world *w, const goer *one)
{
    const body *b = &w->bodies.at[one->body];
    if (!b->used || b->ghost || !b->goes || b->label != one->label) return 0;
    uint64_t units = removal_units(b);
    world_remove_body(w, one->body, b->ghost_cause);
    return units;
}

static uint64_t remove_some(world *w, goers *g)
{
    uint64_t spent = 0;
    for (int n = 0; n < SOME && spent < SOME_UNITS && g->first < g->list.count; n++)
        spent += remove_one(w, &g->list.at[g->first++]);
    if (g->first == g->list.count) {
        array_free(&g->list);
        g->first = 0;
    }
    return spent;
}

void removal_go_on(world *w)
{
    uint64_t spent = 0, units = w->slice == UINT64_MAX ? UINT64_MAX : w->slice / PART;
    while (w->going && spent < units) {
        if (w->goer_turn >= w->goers.count) w->goer_turn = 0;
        spent += remove_some(w, &w->goers.at[w->goer_turn++]);
    }
    for (size_t i = 0; i < w->goers.count && !w->going; i++) {
        array_free(&w->goers.at[i].list); /* those that went before their turn */
        w->goers.at[i].first = 0;
    }
}

size_t removal_of(const world *w, uint64_t owner)
{
    for (size_t i = 0; i < w->goers.count; i++)
        if (w->goers.at[i].owner == owner && w->goers.at[i].list.count)
            return w->goers.at[i].list.count - w->goers.at[i].first;
    return 0;
}

void removal_free(world *w)
{
    for (size_t i = 0; i < w->goers.count; i++) array_free(&w->goers.at[i].list);
    array_free(&w->goers);
}

/* ---- a saved state ---- */

void removal_save(const world *w, bytes_out *to)
{
    bytes_put_count(to, w->goer_turn);
    bytes_put_count(to, w->goers.count);
    for (size_t i = 0; i < w->goers.count; i++) {
        const goers *g = &w->goers.at[i];
        bytes_put(to, &g->owner, sizeof g->owner);
        bytes_put_count(to, g->list.count - g->first);
        bytes_put(to, g->list.at + g->first, (g->list.count - g->first) * sizeof *g->list.at);
    }
}

/* Bodies know whether they go. */
bool removal_restore(world *w, bytes_in *from)
{
    uint64_t turn;
    bytes_get(from, &turn, sizeof turn);
    w->goer_turn = (size_t)turn;
    size_t owners = bytes_get_count(from, sizeof(uint64_t));
    for (size_t i = 0; i < owners; i++) {
        goers g = {.first = 0};
        bytes_get(from, &g.owner, sizeof g.owner);
        size_t count = bytes_get_count(from, sizeof *g.list.at);
        array_reserve(&g.list, count + 1);
        bytes_get(from, g.list.at, count * sizeof *g.list.at);
        g.list.count = count;
        array_push(&w->goers, g);
        for (size_t k = 0; k < count; k++)
            if (g.list.at[k].body >= w->bodies.count) return false;
    }
    for (size_t i = 0; i < w->bodies.count; i++) w->going += w->bodies.at[i].used && w->bodies.at[i].goes;
    return !from->broken;
}
