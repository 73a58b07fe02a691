/* impact_wait: pairs whose searches a tick has put off. They wait in lists by the owners of their bodies, take turns,
 * and are decided again in the next ticks, as far as a share of the slice goes; until then what was reported of them
 * stands, and they count as pending. A pair remembers how far its searches have come: those for its swept motions are
 * in the order of ticks and subscriptions, and go on where they ended; so do those for what is predicted, in rounds
 * over its subscriptions: where its bodies have changed since a round began, it is followed by another one. Tick
 * thread. */
#include "state.h"

enum { PART = 2 /* of a slice */ };

uint32_t impact_list_of(const world *w, const pair *p)
{
    uint64_t owner = w->bodies.at[w->colliders.at[p->a].body].owner;
    if (!p->lingers && p->payer < w->payers.count) owner = w->payers.at[p->payer].owner;
    return (uint32_t)(owner * 0x9e3779b97f4a7c15u >> 32) % SEARCH_LISTS;
}

/* ---- whose they are ---- */

static leaver *searcher_of(world *w, uint64_t owner)
{
    leaver *empty = NULL;
    for (size_t i = 0; i < w->searchers.count; i++) {
        if (w->searchers.at[i].count && w->searchers.at[i].owner == owner) return &w->searchers.at[i];
        if (!w->searchers.at[i].count) empty = &w->searchers.at[i];
    }
    if (!empty) {
        array_push(&w->searchers, (leaver){.count = 0});
        empty = &w->searchers.at[w->searchers.count - 1];
    }
    *empty = (leaver){.owner = owner};
    return empty;
}

size_t impact_waiting_of(const world *w, uint64_t owner)
{
    for (size_t i = 0; i < w->searchers.count; i++)
        if (w->searchers.at[i].count && w->searchers.at[i].owner == owner) return w->searchers.at[i].count;
    return 0;
}

static void count_body(world *w, uint32_t collider, const pair *p, bool anew)
{
    body *b = &w->bodies.at[w->colliders.at[collider].body];
    b->swept_left += p->swept_wait;
    if (b->searches_left++) return;
    if (anew) b->searcher = b->owner;
    searcher_of(w, b->searcher)->count++;
    w->searching_bodies++;
}

static void uncount_body(world *w, uint32_t collider, const pair *p)
{
    body *b = &w->bodies.at[w->colliders.at[collider].body];
    b->swept_left -= p->swept_wait;
    if (--b->searches_left) return;
    searcher_of(w, b->searcher)->count--;
    w->searching_bodies--;
}

/* ---- the lists ---- */

static void put_last(world *w, uint32_t id)
{
    pair_more *p = pair_more_make(w, &w->pairs.at[id]);
    search_list *list = &w->waiting[p->wait_list];
    p->wait_before = list->last;
    p->wait_next = WORLD_NONE;
    if (list->last != WORLD_NONE)
        pair_more_make(w, &w->pairs.at[list->last])->wait_next = id;
    else
        list->first = id;
    list->last = id;
}

static void take_out(world *w, uint32_t id)
{
    const pair_more *p = pair_more_of(w, &w->pairs.at[id]);
    search_list *list = &w->waiting[p->wait_list];
    if (p->wait_before != WORLD_NONE)
        pair_more_make(w, &w->pairs.at[p->wait_before])->wait_next = p->wait_next;
    else
        list->first = p->wait_next;
    if (p->wait_next != WORLD_NONE)
        pair_more_make(w, &w->pairs.at[p->wait_next])->wait_before = p->wait_before;
    else
        list->last = p->wait_before;
}

void impact_forget(world *w, uint32_t id)
{
    pair *p = &w->pairs.at[id];
    if (!p->search_waits) return;
    take_out(w, id);
    uncount_body(w, p->a, p);
    uncount_body(w, p->b, p);
    p->search_waits = p->swept_wait = false;
    w->searching--;
}

/* Behind the others that wait. */
static void wait(world *w, uint32_t id, bool swept_motions)
{
    pair *p = &w->pairs.at[id];
    impact_forget(w, id);
    p->search_waits = true;
    p->swept_wait = swept_motions;
    pair_more_make(w, p)->wait_list = (uint8_t)impact_list_of(w, p);
    put_last(w, id);
    count_body(w, p->a, p, true);
    count_body(w, p->b, p, true);
    slices_concern_body(w, w->colliders.at[p->a].body);
    slices_concern_body(w, w->colliders.at[p->b].body);
    w->searching++;
}

void impact_wait_init(world *w)
{
    for (size_t i = 0; i < SEARCH_LISTS; i++) w->waiting[i] = (search_list){WORLD_NONE, WORLD_NONE};
}

/* Are the links what they say? */
static const char *check_list(const world *w, uint32_t list, size_t *count)
{
    uint32_t last = WORLD_NONE;
    for (uint32_t id = w->waiting[list].first; id != WORLD_NONE;) {
        if (id >= w->pairs.count || ++*count > w->pairs.count) return "a list of pairs that wait leads nowhere";
        const pair *p = &w->pairs.at[id];
        const pair_more *more = pair_more_of(w, p);
        if (!p->used || !p->search_waits || !p->has_more || more->wait_list != list || more->wait_before != last)
            return "a pair waits in the wrong place";
        last = id;
        id = more->wait_next;
    }
    return w->waiting[list].last == last ? NULL : "a list of pairs that wait ends elsewhere";
}

const char *impact_wait_validate(const world *w)
{
    size_t count = 0;
    const char *wrong = NULL;
    for (uint32_t list = 0; list < SEARCH_LISTS && !wrong; list++) wrong = check_list(w, list, &count);
    for (size_t i = 0; i < w->pairs.count; i++) count -= w->pairs.at[i].used && w->pairs.at[i].search_waits;
    return wrong ? wrong : count ? "a pair that waits is in no list" : NULL;
}

const char *impact_wait_restored(world *w)
{
    for (size_t i = 0; i < w->bodies.count; i++) w->bodies.at[i].searches_left = w->bodies.at[i].swept_left = 0;
    for (size_t i = 0; i < w->pairs.count; i++) {
        const pair *p = &w->pairs.at[i];
        if (!p->used || !p->search_waits) continue;
        count_body(w, p->a, p, false);
        count_body(w, p->b, p, false);
        w->searching++;
    }
    return impact_wait_validate(w);
}

/* ---- their turns ---- */

/* The first of the next list that has one, which goes behind the others. */
static uint32_t take_next(world *w)
{
    search_list *list;
    do {
        list = &w->waiting[w->search_turn];
        w->search_turn = (w->search_turn + 1) % SEARCH_LISTS;
    } while (list->first == WORLD_NONE);
    uint32_t id = list->first;
    take_out(w, id);
    put_last(w, id);
    return id;
}

uint64_t impact_go_on(world *w)
{
    uint64_t spent = 0, units = w->slice == UINT64_MAX ? UINT64_MAX : w->slice / PART;
    for (size_t some = w->searching; some && spent < units; some--) spent += pair_activate(w, take_next(w));
    return spent;
}

/* ---- after the searches ---- */

/* All up to this tick are done. */
static void finish(world *w, uint32_t id)
{
    pair *p = &w->pairs.at[id];
    uint64_t x = w->bodies.at[w->colliders.at[p->a].body].changed_tick;
    uint64_t y = w->bodies.at[w->colliders.at[p->b].body].changed_tick;
    const pair_more *more = pair_more_of(w, p);
    bool again = more->predicted_from && (x > more->predicted_round || y > more->predicted_round);
    if (p->has_more) pair_more_make(w, p)->predicted_from = 0;
    if (again)
        wait(w, id, false);
    else
        impact_forget(w, id);
}

/* From `first` on, of those from `from` to `to`. */
static void put_off(world *w, uint32_t id, size_t from, size_t first, size_t to)
{
    const sweep *s = &w->sweeps.at[first];
    for (size_t k = first; k < to; k++) w->sweeps.at[k].put_off = true;
    w->sliced = true;
    pair_more *more = pair_more_make(w, &w->pairs.at[id]);
    more->swept_tick = s->predicts ? w->figures.ticks : s->tick - 1;
    more->swept_from = s->predicts ? 0 : s->subscription;
    if (s->predicts && first > from && s[-1].predicts) {
        if (!more->predicted_from) more->predicted_round = w->figures.ticks;
        more->predicted_from = s->subscription;
    }
    wait(w, id, !s->predicts);
}

/* Until when a pair has been searched matters where some are behind. */
static void note_done(world *w)
{
    bool matters = w->searching || (w->ccds && (w->due || w->past_bodies.count));
    for (size_t k = 0; k < w->active_pairs.count && matters; k++) {
        pair *p = &w->pairs.at[w->active_pairs.at[k]];
        if (w->outcomes.at[k].search_left) continue;
        pair_more *more = pair_more_make(w, p);
        more->swept_tick = w->figures.ticks;
        more->swept_from = 0;
        if (p->search_waits) finish(w, w->active_pairs.at[k]);
    }
}

void impact_settle(world *w)
{
    for (size_t k = 0, end; k < w->sweeps.count; k = end) {
        uint32_t active = w->sweeps.at[k].active;
        size_t first = w->sweeps.count;
        for (end = k; end < w->sweeps.count && w->sweeps.at[end].active == active; end++)
            if (!w->sweeps.at[end].done && first > end) first = end;
        if (first >= end) continue;
        put_off(w, w->active_pairs.at[active], k, first, end);
        w->outcomes.at[active].search_left = true;
    }
    note_done(w);
}
