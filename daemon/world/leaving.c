/* leaving: bodies are removed, or get other shapes, that have very many pairs. Tick thread.
 *
 * Where what was removed since the last tick has more pairs than a share of the slice, its colliders leave: they are
 * ghosts that are nowhere any more, but whose pairs are still to be ended, in slices, and with them what was reported.
 * Their ids, and names in events, stay until then. What gets the same name meanwhile, or the same body with its new
 * shapes, is held back: it is in no subscription, so that under a name one thing ends before another begins. All of it
 * is counted. */
#include "match.h"
#include "state.h"

enum { A_PAIR = 1500 /* units: its end, with what is reported */, PART = 4 /* of a slice, at most */ };

static leaver *leaver_of(world *w, uint64_t owner)
{
    leaver *empty = NULL;
    for (size_t i = 0; i < w->leavers.count; i++) {
        if (w->leavers.at[i].count && w->leavers.at[i].owner == owner) return &w->leavers.at[i];
        if (!w->leavers.at[i].count) empty = &w->leavers.at[i];
    }
    if (!empty) {
        array_push(&w->leavers, (leaver){.count = 0});
        empty = &w->leavers.at[w->leavers.count - 1];
    }
    *empty = (leaver){.owner = owner};
    return empty;
}

size_t leaving_of(const world *w, uint64_t owner)
{
    for (size_t i = 0; i < w->leavers.count; i++)
        if (w->leavers.at[i].count && w->leavers.at[i].owner == owner) return w->leavers.at[i].count;
    return 0;
}

bool leaving_holds(const world *w, const body *b)
{
    if (!w->leaving.count) return false;
    return b->leaving || pair_map_get(&w->leaving_names, body_name_hash(b->name)) != PAIR_MAP_NONE;
}

static void count_name(world *w, const char *name, int by)
{
    uint64_t key = body_name_hash(name);
    uint32_t was = pair_map_get(&w->leaving_names, key), is = (was == PAIR_MAP_NONE ? 0 : was) + (uint32_t)by;
    if (is)
        pair_map_put(&w->leaving_names, key, is);
    else
        pair_map_remove(&w->leaving_names, key);
}

void leaving_ghost(world *w, uint32_t id)
{
    const body *b = &w->bodies.at[id];
    if (b->leaving) count_name(w, b->name, 1);
}

static void note_leaving(world *w, uint32_t id)
{
    uint32_t of = w->colliders.at[id].body;
    body *b = &w->bodies.at[of];
    array_push(&w->leaving, id);
    leaver_of(w, b->owner)->count++;
    if (b->leaving++) return;
    if (b->ghost) count_name(w, b->name, 1);
}

static void hold_changed(world *w)
{
    for (size_t i = 0; i < w->dirty.count; i++) {
        const body *b = &w->bodies.at[w->dirty.at[i]];
        if (b->used && !b->ghost && leaving_holds(w, b)) match_hold_body(w, (uint32_t)w->dirty.at[i]);
    }
}

/* Those that were removed since the last tick are the ones that wait to be reaped. */
void leaving_begin(world *w)
{
    uint64_t pairs = 0;
    if (w->slice == UINT64_MAX) return;
    for (size_t i = 0; i < w->reap_colliders.count; i++) pairs += broad_pairs_of(w->broad, w->reap_colliders.at[i]);
    if (pairs <= w->slice / PART / A_PAIR) return;
    w->sliced = true;
    for (size_t i = 0; i < w->reap_colliders.count; i++) {
        uint32_t id = w->reap_colliders.at[i];
        if (!broad_pairs_of(w->broad, id)) continue;
        broad_let_leave(w->broad, id);
        note_leaving(w, id);
    }
    hold_changed(w);
}

/* What has waited for it may begin. */
static void free_held(world *w, uint32_t of)
{
    const body *b = &w->bodies.at[of];
    if (b->ghost) count_name(w, b->name, -1);
    uint32_t held = b->ghost ? world_find_body(w, b->name) : of;
    if (held != WORLD_NONE) match_free_body(w, held);
}

static void has_left(world *w, uint32_t id)
{
    uint32_t of = w->colliders.at[id].body;
    body *b = &w->bodies.at[of];
    if (w->colliders.at[id].kept) array_push(&w->reap_colliders, id);
    leaver_of(w, b->owner)->count--;
    if (--b->leaving) return;
    if (b->kept) array_push(&w->reap, of);
    free_held(w, of);
}

void leaving_go_on(world *w)
{
    uint64_t spent = 0, units = w->slice == UINT64_MAX ? UINT64_MAX : w->slice / PART;
    size_t gone = 0;
    while (gone < w->leaving.count && spent < units) {
        uint32_t id = w->leaving.at[gone];
        broad_changes changes;
        uint64_t took;
        bool whole = broad_end_leaving(w->broad, id, units - spent, &changes, &took);
        for (size_t i = 0; i < changes.ended_count; i++) pair_part(w, changes.ended[i].a, changes.ended[i].b);
        spent += took + (uint64_t)A_PAIR * changes.ended_count;
        if (!whole) break;
        has_left(w, id);
        gone++;
    }
    if (!gone) return;
    w->leaving.count -= gone;
    memmove(w->leaving.at, w->leaving.at + gone, w->leaving.count * sizeof *w->leaving.at);
}

void leaving_restored(world *w)
{
    size_t count = w->leaving.count;
    w->leaving.count = 0;
    for (size_t i = 0; i < count; i++) w->bodies.at[w->colliders.at[w->leaving.at[i]].body].leaving = 0;
    for (size_t i = 0; i < count; i++) note_leaving(w, w->leaving.at[i]);
}
