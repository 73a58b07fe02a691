/* settling: which of the bodies that have moved are put into the broad phase in this tick, where a step has moved more
 * than it can take. Tick thread.
 *
 * What a tick has to do with poses follows from bodies that are put anew, and a step brings very many at once. As many
 * are settled as twice a slice allows, less what it took to move them; the others stay dirty, and stand where the last
 * tick left them: nothing is decided of a pair of such a body, who asks is told of where it was, and all of them are
 * pending, so that the step is not answered, nor followed by the next one. Who has moved few goes first: each owner has
 * an equal share, and what those leave that need less goes to the others, whose bodies go by how long they have waited.
 * Counted, so that it follows from the commands and the slices. Where swept motions count none is left: they would be
 * searched in parts. Nor is it where there was no step: of bodies that never rest two might never be settled in one
 * tick. */
#include "base/sort.h"
#include "state.h"

#include <stdlib.h>

enum { SLICES = 2, A_MOVE = 150 /* units */, LEAST_PART = 8 /* of a slice, however many have moved */ };

static uint64_t units_of_tick(const world *w)
{
    if (!w->in_parts || w->slice > UINT64_MAX / SLICES || w->sweepers) return UINT64_MAX;
    uint64_t units = SLICES * w->slice, moved = A_MOVE * (w->figures.moves - w->moves_before);
    uint64_t least = w->slice / LEAST_PART;
    return units > moved + least ? units - moved : least;
}

/* ---- whose they are ---- */

/* By a command: it is told of as it is from now on, and its shapes may not be there yet. */
static bool must_settle(const body *b)
{
    return !b->used || b->ghost || !b->dirty || b->refilter;
}

static uint64_t key_of(uint64_t owner)
{
    return owner ? owner : UINT64_MAX;
}

static uint32_t mover_of(world *w, pair_map *places, uint64_t owner, uint32_t recent)
{
    if (recent < w->movers.count && w->movers.at[recent].owner == owner) return recent;
    uint32_t place = pair_map_get(places, key_of(owner));
    if (place != PAIR_MAP_NONE) return place;
    place = (uint32_t)w->movers.count;
    pair_map_put(places, key_of(owner), place);
    array_push(&w->movers, (mover){.owner = owner});
    return place;
}

/* Fills mover_at: of each that is dirty, whose it is; WORLD_NONE: it does not matter. */
static void count_movers(world *w)
{
    pair_map places;
    uint32_t recent = WORLD_NONE;
    pair_map_init(&places);
    w->mover_at.count = 0;
    array_reserve(&w->mover_at, w->dirty.count);
    for (size_t i = 0; i < w->dirty.count; i++) {
        const body *b = &w->bodies.at[w->dirty.at[i]];
        uint32_t of = must_settle(b) ? WORLD_NONE : (recent = mover_of(w, &places, b->owner, recent));
        if (of != WORLD_NONE) w->movers.at[of].units += b->effort;
        w->mover_at.at[w->mover_at.count++] = of;
    }
    pair_map_free(&places);
}

static int compare_needs(const void *a, const void *b)
{
    const mover *x = *(mover *const *)a, *y = *(mover *const *)b;
    if (x->units != y->units) return x->units < y->units ? -1 : 1;
    return (x->owner > y->owner) - (x->owner < y->owner);
}

/* The least first: what one leaves of his share is the next ones'. */
static void share_out(world *w, uint64_t units)
{
    size_t left = w->movers.count;
    mover **order = base_alloc(left + 1, sizeof *order);
    for (size_t i = 0; i < left; i++) order[i] = &w->movers.at[i];
    if (left) qsort(order, left, sizeof *order, compare_needs);
    for (size_t i = 0; left; i++, left--) {
        uint64_t share = units / left;
        uint64_t credit = order[i]->units < share ? order[i]->units : share;
        order[i]->credit = (int64_t)credit;
        units -= credit;
    }
    free(order);
}

/* ---- which are settled ---- */

/* True: it is among those of this tick. The last of an owner may take more than is left. */
static bool takes_turn(world *w, uint32_t id, uint32_t of)
{
    if (of == WORLD_NONE) return true;
    mover *m = &w->movers.at[of];
    if (m->credit <= 0) return false;
    m->credit -= w->bodies.at[id].effort;
    return true;
}

static void leave(world *w, uint32_t id, uint32_t of)
{
    body *b = &w->bodies.at[id];
    if (!b->left_since) b->left_since = w->figures.ticks;
    array_push(&w->left, id);
    w->movers.at[of].left++;
    w->left_effort += b->effort;
    b->moved |= b->glided == w->round - 1;
    if (b->posed) expiry_set(w, id); /* it is as fresh as if it had been settled */
}

/* Those that have waited for longest come first; then in the order of ids. */
static void order_dirty(world *w)
{
    for (size_t i = 0; i < w->dirty.count; i++) {
        uint64_t since = w->bodies.at[w->dirty.at[i]].left_since;
        w->dirty.at[i] |= (since ? since : w->figures.ticks) << 32;
    }
    sort_keys(w->dirty.at, w->sort_scratch.at, w->dirty.count);
    for (size_t i = 0; i < w->dirty.count; i++) w->dirty.at[i] = (uint32_t)w->dirty.at[i];
}

static void begin_choosing(world *w)
{
    w->moves_before = w->figures.moves;
    w->left.count = w->movers.count = w->left_effort = 0;
}

static void forget_left(world *w)
{
    for (size_t i = 0; i < w->left.count; i++) w->bodies.at[w->left.at[i]].left_since = 0;
}

void settling_choose(world *w)
{
    uint64_t units = units_of_tick(w);
    bool all = w->effort <= units;
    size_t chosen = 0;
    if (all) forget_left(w);
    begin_choosing(w);
    if (all) w->in_parts = false;
    if (all) return;
    w->sliced = true; /* whether some are left or not */
    order_dirty(w);
    count_movers(w);
    share_out(w, units);
    for (size_t i = 0; i < w->dirty.count; i++) {
        uint32_t id = (uint32_t)w->dirty.at[i];
        if (!takes_turn(w, id, w->mover_at.at[i])) {
            leave(w, id, w->mover_at.at[i]);
            continue;
        }
        w->bodies.at[id].left_since = 0;
        w->dirty.at[chosen++] = id;
    }
    w->dirty.count = chosen;
    sort_keys(w->dirty.at, w->sort_scratch.at, chosen); /* by ids, as if there were no others */
}

void settling_end(world *w)
{
    w->dirty.count = 0;
    for (size_t i = 0; i < w->left.count; i++) array_push(&w->dirty, w->left.at[i]);
    w->effort = w->left_effort;
}

void world_part_moves(world *w)
{
    w->in_parts = true;
}

size_t settling_of(const world *w, uint64_t owner)
{
    for (size_t i = 0; i < w->movers.count && w->left.count; i++)
        if (w->movers.at[i].owner == owner) return w->movers.at[i].left;
    return 0;
}

void settling_restored(world *w)
{
    w->dirty.count = w->effort = 0;
    for (uint32_t id = 0; id < w->bodies.count; id++) {
        const body *b = &w->bodies.at[id];
        if (!b->used || b->ghost || !b->dirty) continue;
        array_push(&w->dirty, id);
        array_push(&w->left, id);
        w->effort += b->effort;
    }
}
