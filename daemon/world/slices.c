/* slices: how many pairs a tick finds and decides, and whose are next. Tick thread.
 *
 * All that a tick has to do with pairs follows from bodies that were put again. With a slice (world_set_slice) a tick
 * takes them, one after the other, as far as its units go; bodies that are left are due, and go first from then on. Of
 * a body that is taken what the broad phase has put off is searched (new pairs, and those that have parted), and each
 * of its pairs is decided that was decided last before one of its bodies changed: so none is decided twice, and a pair
 * says itself whether it is out of date (pair_is_pending). A body of so many pairs that they do not fit goes back
 * behind its owner's others; what it has waited for longest is decided first, new pairs among it. One of so many that
 * to find out which these are takes longer than a tick has goes through them by ids, a part of them in each turn.
 *
 * Who is next: each owner has a purse; the purses take turns, and get an equal share of the slice in each (deficit
 * round robin), so that whose bodies are few are not kept waiting by who has millions of pairs. Whose body is taken
 * pays. But a pair of two bodies that are both due is left to the one whose owner has more than FAR_MORE times as many
 * that are due: nobody's work is done at the cost of those that he has surrounded with his bodies.
 *
 * Units are counts, so that all of it follows from the commands and the slices. */
#include "match.h"
#include "soft_state.h"
#include "state.h"
#include "subscription.h"

#include <stdlib.h>
#include <string.h>

enum {
    A_MILLISECOND = 1000000,
    A_BODY = 100,         /* units */
    A_PAIR_SEEN = 25,     /* one that is looked at, and perhaps not pending */
    A_PAIR_LISTED = 250,  /* and sorted by how long it has waited */
    MANY_PAIRS = 256,     /* a body with fewer cheap ones is never taken in parts */
    HUB_PAIRS = 32768,    /* one with more is gone through in parts, ... */
    HUGE_PAIRS = 131072,  /* ... certainly one with so many */
    A_LOOK_UP = 100,      /* of the pair, far away in memory */
    SHARES = 8,           /* of a slice: so many turns in it at least, ... */
    LEAST_SHARE = 200000, /* ... but none of fewer units */
    FAR_MORE = 4
};

/* What may begin beyond max_pairs is only kept in order to say how many it is. */
static const size_t LEFT_OUT_MOST = (size_t)1 << 20;

void world_set_slice(world *w, uint64_t units)
{
    w->slice = units;
}

/* Of pairs in the broad phase. Where it is memory that is short, no more of it goes there than that is worth. */
static size_t broad_most(const world *w)
{
    size_t most = pair_most(w), spare = w->pairs_most && most < LEFT_OUT_MOST ? most : LEFT_OUT_MOST;
    return most == SIZE_MAX ? most : most + spare;
}

void slices_begin(world *w)
{
    w->sliced = w->due || w->parked || w->olds || w->leaving.count || w->going || w->reaps_late || w->searching;
    w->figures.slice_units = 0;
    broad_set_price(w->broad, w->rules.dear || w->dear ? pair_price : NULL);
    broad_set_limit(w->broad, w->slice, w->slice != UINT64_MAX ? broad_most(w) : SIZE_MAX);
}

/* ---- purses ---- */

static uint32_t purse_of(world *w, uint64_t owner)
{
    uint32_t empty = WORLD_NONE;
    for (uint32_t i = 0; i < w->purses.count; i++) {
        if (!w->purses.at[i].count && empty == WORLD_NONE) empty = i;
        if (w->purses.at[i].count && w->purses.at[i].owner == owner) return i;
    }
    if (empty == WORLD_NONE) {
        empty = (uint32_t)w->purses.count;
        array_push(&w->purses, (purse){.count = 0});
    }
    w->purses.at[empty] = (purse){.owner = owner, .first = WORLD_NONE, .last = WORLD_NONE};
    return empty;
}

static void put_due_last(world *w, uint32_t id, uint32_t to)
{
    purse *p = &w->purses.at[to];
    body *b = &w->bodies.at[id];
    b->purse = to;
    b->due_before = p->last;
    b->due_next = WORLD_NONE;
    if (p->last != WORLD_NONE)
        w->bodies.at[p->last].due_next = id;
    else
        p->first = id;
    p->last = id;
    p->count++;
    b->is_due = true;
    w->due++;
}

static void take_from_due(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    purse *p = &w->purses.at[b->purse];
    if (b->due_before != WORLD_NONE)
        w->bodies.at[b->due_before].due_next = b->due_next;
    else
        p->first = b->due_next;
    if (b->due_next != WORLD_NONE)
        w->bodies.at[b->due_next].due_before = b->due_before;
    else
        p->last = b->due_before;
    p->count--;
    b->is_due = false;
    w->due--;
}

static void note_concerned(world *w, const body *b);

/* At least so many pairs are not decided as long as it waits. */
static uint32_t weight_of(const world *w, const body *b)
{
    uint32_t weight = 1;
    for (size_t i = 0; i < b->shape_count; i++) weight += broad_pairs_of(w->broad, b->shapes[i]);
    return weight;
}

static void weigh(world *w, body *b, uint32_t weight)
{
    w->pending = w->pending - b->weight + weight;
    b->weight = weight;
}

/* `recent`: the purse of the one before it, most often of the same owner. */
static void make_due(world *w, uint32_t id, uint32_t *recent)
{
    body *b = &w->bodies.at[id];
    w->parked -= b->is_parked;
    b->is_parked = false;
    note_concerned(w, b);
    weigh(w, b, weight_of(w, b));
    if (b->is_due) return;
    bool same = *recent < w->purses.count && w->purses.at[*recent].count && w->purses.at[*recent].owner == b->owner;
    if (!same) *recent = purse_of(w, b->owner);
    put_due_last(w, id, *recent);
}

void slices_forget(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (b->is_due) take_from_due(w, id);
    w->parked -= b->is_parked;
    b->is_parked = false;
    weigh(w, b, 0);
}

/* ---- a body's turn ---- */

typedef struct turn {
    world *w;
    const body *body;
    uint32_t collider;
    uint64_t spent;
    bool left;       /* something was, to another body's turn; ... */
    bool left_new;   /* ... and a search found it */
    uint64_t since;  /* the tick in which the look at its pairs began */
    size_t searched; /* shapes */
} turn;

static bool is_left_to(const turn *t, const body *other)
{
    const purse *all = t->w->purses.at;
    if (!t->body->is_due || !other->is_due || other->purse == t->body->purse) return false;
    return all[other->purse].count > (uint64_t)FAR_MORE * all[t->body->purse].count;
}

static bool leave_to_other(void *context, uint32_t other)
{
    turn *t = context;
    bool left = is_left_to(t, &t->w->bodies.at[t->w->colliders.at[other].body]);
    t->left_new |= left;
    return left;
}

/* One that is dear waits like those that were there, to be decided with them as far as there are units. */
static uint64_t activate_found(world *w, uint32_t id)
{
    pair *p = &w->pairs.at[id];
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    bool is_new = p->asked_epoch == 0 && p->first_watch == WORLD_NONE;
    if (!is_new || !(slices_is_dear(a) || slices_is_dear(b))) return pair_activate(w, id);
    uint64_t x = w->bodies.at[a->body].changed_tick, y = w->bodies.at[b->body].changed_tick;
    pair_set_active_tick(p, (x < y ? x : y) - 1);
    return 0;
}

typedef enum searched { ALL_FOUND, CUT_OFF, NO_ROOM } searched;

static searched search_collider(turn *t, uint32_t collider, uint64_t units)
{
    world *w = t->w;
    broad_changes changes;
    uint64_t spent, left = t->spent < units ? units - t->spent : 0;
    if (!broad_is_unsearched(w->broad, collider)) return ALL_FOUND;
    size_t most = broad_most(w), kept = payers_kept_for(w, t->body);
    if (most != SIZE_MAX) most += kept;
    broad_set_limit(w->broad, w->slice, most);
    t->searched++;
    bool whole = broad_search(w->broad, collider, left, leave_to_other, t, &changes, &spent);
    t->spent += spent;
    for (size_t i = 0; i < changes.ended_count; i++) {
        uint32_t id = pair_part(w, changes.ended[i].a, changes.ended[i].b);
        if (id != PAIR_MAP_NONE) t->spent += pair_activate(w, id);
    }
    for (size_t i = 0; i < changes.began_count; i++) {
        uint32_t id = pair_meet(w, changes.began[i].a, changes.began[i].b);
        if (id != PAIR_MAP_NONE) t->spent += activate_found(w, id);
    }
    bool full = broad_pair_count(w->broad) >= most;
    return whole ? ALL_FOUND : full ? NO_ROOM : CUT_OFF;
}

/* Two that both changed have their pair in both lists: the second is passed over, where the first has had its turn, and
 * none of its pairs was left. */
static bool is_done(const turn *t, const body *other)
{
    return other->gathered_tick >= t->body->changed_tick && other->gathered_tick >= other->changed_tick;
}

static bool is_waiting(turn *t, uint32_t other, uint32_t *id)
{
    world *w = t->w;
    const body *o = &w->bodies.at[w->colliders.at[other].body];
    if (is_done(t, o)) return false;
    t->spent += A_LOOK_UP;
    *id = pair_find(w, t->collider, other);
    if (*id == PAIR_MAP_NONE) return false;
    bool changed_now = t->body->changed_tick == w->figures.ticks; /* then it has not been decided since, but here */
    if (!changed_now && !pair_is_pending(w, &w->pairs.at[*id])) return false;
    bool left = is_left_to(t, o);
    t->left |= left;
    return !left;
}

static void activate_with(void *context, uint32_t other)
{
    turn *t = context;
    uint32_t id;
    t->spent += A_PAIR_SEEN;
    if (is_waiting(t, other, &id)) t->spent += pair_activate(t->w, id);
}

typedef struct queue {
    turn *turn;
    uint64_t units; /* of all */
} queue;

static void list_with(void *context, uint32_t other)
{
    queue *q = context;
    uint32_t id;
    q->turn->spent += A_PAIR_SEEN;
    if (!is_waiting(q->turn, other, &id)) return;
    q->turn->spent += A_PAIR_LISTED;
    const pair *p = &q->turn->w->pairs.at[id];
    q->units += pair_units(q->turn->w, p);
    array_push(&q->turn->w->queue, ((waiting_pair){p->active_tick, pair_key(p->a, p->b), id}));
}

static int compare_waiting(const void *a, const void *b)
{
    const waiting_pair *x = a, *y = b;
    if (x->since != y->since) return x->since < y->since ? -1 : 1;
    return (x->key > y->key) - (x->key < y->key);
}

/* Of many pairs those that have waited longest; false: not all. */
static bool activate_oldest(turn *t, const body *b, uint64_t units)
{
    enum { SOME_AT_LEAST = 64 };
    queue q = {.turn = t};
    world *w = t->w;
    w->queue.count = 0;
    for (size_t i = 0; i < b->shape_count; i++) {
        t->collider = b->shapes[i];
        broad_each_pair_of(w->broad, b->shapes[i], list_with, &q);
    }
    bool fits = t->spent + q.units <= units; /* one that is on the list takes nothing */
    if (!fits && w->queue.count) qsort(w->queue.at, w->queue.count, sizeof *w->queue.at, compare_waiting);
    size_t done = 0;
    uint64_t before = t->spent;
    for (; done < w->queue.count; done++) {
        bool some = done < SOME_AT_LEAST && t->spent - before < A_MILLISECOND;
        if (!fits && done && !some && t->spent >= units) break;
        t->spent += pair_activate(w, w->queue.at[done].pair);
    }
    bool whole = done == w->queue.count;
    return whole;
}

/* ---- a body of so many pairs that to look at each of them takes longer than a tick has ---- */

/* Not if it has them among far more that it has none with. */
static bool is_hub(const world *w, size_t pairs)
{
    return pairs > HUGE_PAIRS || (pairs > HUB_PAIRS && pairs * 4 >= w->colliders.count);
}

/* By the ids of the others, from where the last turn ended: a pass over all of them may take many ticks. What it has
 * gone by before the body changed again is for the next pass. False: something is left. */
static bool activate_by_ids(turn *t, body *b, uint64_t units)
{
    enum { SOME_AT_LEAST = 64 };
    world *w = t->w;
    uint64_t before = t->spent, seen = 0;
    if (!b->pass_tick) {
        b->pass_tick = w->figures.ticks;
        b->pass_shape = b->pass_next = b->pass_left = 0;
    }
    for (; b->pass_shape < b->shape_count; b->pass_shape++, b->pass_next = 0) {
        t->collider = b->shapes[b->pass_shape];
        for (; b->pass_next < w->colliders.count; b->pass_next++, seen++) {
            bool some = seen < SOME_AT_LEAST && t->spent - before < A_MILLISECOND;
            if (!some && t->spent >= units) {
                b->pass_left |= t->left;
                return false;
            }
            uint32_t id;
            t->spent += A_PAIR_SEEN;
            if (w->colliders.at[b->pass_next].used && is_waiting(t, b->pass_next, &id))
                t->spent += pair_activate(w, id);
        }
    }
    t->left |= b->pass_left;
    t->since = b->pass_tick;
    b->pass_tick = 0;
    return b->changed_tick <= t->since;
}

typedef struct prices {
    const world *w;
    double sum;
} prices;

static void add_price(void *context, uint32_t other)
{
    prices *p = context;
    p->sum += p->w->colliders.at[other].overlapping;
}

/* May its pairs take more than that, though they are few? What is cheap is not added up. */
static bool may_take_more(const world *w, const body *b, uint64_t units)
{
    prices p = {.w = w};
    if (!w->dear) return false;
    for (size_t i = 0; i < b->shape_count; i++) {
        broad_each_pair_of(w->broad, b->shapes[i], add_price, &p);
        p.sum += (double)broad_pairs_of(w->broad, b->shapes[i]) * w->colliders.at[b->shapes[i]].overlapping;
    }
    return p.sum > (double)units;
}

static bool activate_pairs(turn *t, body *b, uint64_t units)
{
    size_t pairs = 0;
    for (size_t i = 0; i < b->shape_count; i++) pairs += broad_pairs_of(t->w->broad, b->shapes[i]);
    if (units != UINT64_MAX && is_hub(t->w, pairs)) return activate_by_ids(t, b, units);
    b->pass_tick = 0;
    bool many = pairs > MANY_PAIRS || (units != UINT64_MAX && may_take_more(t->w, b, units));
    if (many && units != UINT64_MAX) return activate_oldest(t, b, units);
    for (size_t i = 0; i < b->shape_count; i++) {
        t->collider = b->shapes[i];
        broad_each_pair_of(t->w->broad, b->shapes[i], activate_with, t);
    }
    return true;
}

/* What a search has left is not looked for again until the next one: until then somebody else owes it. */
static void note_left(const turn *t, body *b)
{
    bool owed = b->left_new && b->left_tick > t->w->past_clear && t->searched < b->shape_count;
    b->left_new = t->left_new || owed;
    b->left_tick = b->gathered_tick && !b->left_new ? 0 : t->w->figures.ticks;
}

typedef enum taken { WHOLE, IN_PART, FULL } taken;

static taken take_body(world *w, uint32_t id, uint64_t units, uint64_t *spent)
{
    body *b = &w->bodies.at[id];
    turn t = {.w = w, .body = b, .spent = A_BODY, .since = w->figures.ticks};
    taken how = WHOLE;
    for (size_t i = 0; i < b->shape_count; i++) {
        searched s = search_collider(&t, b->shapes[i], units);
        if (s == CUT_OFF) how = IN_PART;
        if (s == NO_ROOM && how == WHOLE) how = FULL;
    }
    if (!activate_pairs(&t, b, units)) how = IN_PART;
    b->gathered_tick = how == WHOLE && !t.left ? t.since : 0;
    if (w->ccds) note_left(&t, b);
    *spent += t.spent;
    return how;
}

/* A pair of the broad phase has the same pair here as long as it is one, unless it was left out: it keeps its id. */
static void activate_at_once(void *context, uint32_t other, uint32_t *number)
{
    turn *t = context;
    if (*number == BROAD_NO_NUMBER) *number = pair_find(t->w, t->collider, other);
    t->spent += A_PAIR_SEEN;
    bool on_list = *number == PAIR_MAP_NONE || t->w->pairs.at[*number].active_tick == t->w->figures.ticks;
    if (!on_list) t->spent += pair_activate(t->w, *number);
}

/* The same, and as many units, of a body that has changed for this tick, where nothing is due or left out, all is
 * searched, and its pairs are not too many: all of them are out of date but those that have had their turn. */
static bool take_at_once(world *w, uint32_t id, uint64_t *spent)
{
    body *b = &w->bodies.at[id];
    turn t = {.w = w, .spent = A_BODY};
    if (b->pair_count > MANY_PAIRS || b->is_due) return false;
    for (size_t i = 0; i < b->shape_count && b->pair_count; i++) {
        t.collider = b->shapes[i];
        broad_each_number_of(w->broad, t.collider, activate_at_once, &t);
    }
    b->gathered_tick = w->figures.ticks;
    *spent += t.spent;
    return true;
}

/* ---- the slice ---- */

/* Those of a tick before which nothing was due, in the order of their ids, as long as there is room; the others are due
 * from here on. */
static void take_or_put_off(world *w, uint32_t id, bool direct, uint64_t *spent, uint32_t *recent)
{
    const body *b = &w->bodies.at[id];
    if (!b->used || b->ghost) return;
    bool whole = direct && *spent < w->slice && !w->figures.pairs_left_out && take_at_once(w, id, spent);
    if (whole || (direct && *spent < w->slice && take_body(w, id, w->slice - *spent, spent) == WHOLE)) return;
    w->sliced = true;
    make_due(w, id, recent);
}

/* A turn of one purse. */
static void take_turn(world *w, uint32_t at, uint64_t *spent)
{
    for (uint32_t some = w->purses.at[at].count; some; some--) {
        purse *p = &w->purses.at[at];
        if (!p->count || p->credit <= 0 || *spent >= w->slice) return;
        uint32_t id = p->first;
        uint64_t before = *spent, left = w->slice - before, mine = (uint64_t)p->credit;
        taken how = take_body(w, id, left < mine ? left : mine, spent);
        w->purses.at[at].credit -= (int64_t)(*spent - before);
        take_from_due(w, id);
        if (how == IN_PART) put_due_last(w, id, at);
        w->bodies.at[id].is_parked = how == FULL;
        w->parked += how == FULL;
        weigh(w, &w->bodies.at[id], how == WHOLE ? 0 : how == FULL ? 1 : weight_of(w, &w->bodies.at[id]));
    }
}

/* Whatever searches that wait are expected to take: one alone may take more than a slice, and goes on in the next tick,
 * too. */
static uint64_t least_of_turns(const world *w)
{
    return w->slice / 4;
}

static void take_turns(world *w, uint64_t *spent)
{
    uint64_t most = w->slice - least_of_turns(w), beyond = *spent > most ? *spent - most : 0;
    *spent -= beyond;
    uint64_t share = w->slice / SHARES > LEAST_SHARE ? w->slice / SHARES : LEAST_SHARE;
    if (share > INT64_MAX / 4) share = INT64_MAX / 4;
    while (w->due && *spent < w->slice) {
        if (w->turn >= w->purses.count) w->turn = 0;
        purse *p = &w->purses.at[w->turn];
        if (p->count) {
            if (p->credit < (int64_t)share) p->credit += (int64_t)share;
            take_turn(w, w->turn, spent);
        }
        if (!w->purses.at[w->turn].count) w->purses.at[w->turn].credit = 0;
        w->turn++;
    }
    *spent += beyond;
}

/* There is room again for those that found none. */
static void unpark(world *w)
{
    uint32_t recent = WORLD_NONE;
    size_t most = pair_most(w);
    if (!w->parked || broad_pair_count(w->broad) >= most - most / 16) return;
    for (uint32_t id = 0; id < w->bodies.count; id++)
        if (w->bodies.at[id].used && w->bodies.at[id].is_parked) make_due(w, id, &recent);
}

/* What lies beyond the caches in a large world is asked for while the bodies before are taken: a body, then the records
 * of its pairs, then its pairs. */
static void fetch_pair_of_number(void *context, uint32_t other, uint32_t *number)
{
    const world *w = context;
    (void)other;
    if (*number != BROAD_NO_NUMBER) __builtin_prefetch(&w->pairs.at[*number]);
}

static void fetch_awake_ahead(world *w, size_t i)
{
    enum { BODIES_AHEAD = 16, SHAPES_AHEAD = 12, RECORDS_AHEAD = 8, PAIRS_AHEAD = 4, PAIRS_MOST = 16 };
    if (i + BODIES_AHEAD >= w->awake.count) return;
    __builtin_prefetch(&w->bodies.at[w->awake.at[i + BODIES_AHEAD]].shapes);
    const body *shapes = &w->bodies.at[w->awake.at[i + SHAPES_AHEAD]],
               *records = &w->bodies.at[w->awake.at[i + RECORDS_AHEAD]],
               *pairs = &w->bodies.at[w->awake.at[i + PAIRS_AHEAD]];
    if (shapes->shape_count) __builtin_prefetch(shapes->shapes);
    if (records->shape_count) broad_fetch_numbers_of(w->broad, records->shapes[0]);
    if (pairs->shape_count && pairs->pair_count <= PAIRS_MOST)
        broad_each_number_of(w->broad, pairs->shapes[0], fetch_pair_of_number, w);
}

/* ---- where most bodies have changed ----
 *
 * Then their pairs are gone through where they lie, one after the other, and not body by body: the same list, since it
 * is sorted, and as many units. Where these are more than the slice has, it is as if nothing had been done. */

/* Bits of the colliders of all bodies that have changed. False: some body takes more than a glance, or most pairs are
 * none of theirs. */
static bool mark_awake(world *w, uint64_t *spent)
{
    enum { MANY = 4 }; /* a share of all bodies; of fewer the bits would cost more than they spare */
    size_t words = w->colliders.count / 64 + 1, links = 0;
    if (w->awake.count < w->bodies.count / MANY) return false;
    array_reserve(&w->awake_bits, words);
    memset(w->awake_bits.at, 0, words * sizeof *w->awake_bits.at);
    for (size_t i = 0; i < w->awake.count; i++) {
        const body *b = &w->bodies.at[w->awake.at[i]];
        if (!b->used || b->ghost) continue;
        if (b->pair_count > MANY_PAIRS || b->is_due) return false;
        links += b->pair_count;
        *spent += A_BODY;
        for (size_t k = 0; k < b->shape_count && b->pair_count; k++)
            w->awake_bits.at[b->shapes[k] >> 6] |= UINT64_C(1) << (b->shapes[k] & 63);
    }
    return links && links >= w->pairs.count / 2;
}

static inline unsigned is_awake(const world *w, uint32_t collider)
{
    return w->awake_bits.at[collider >> 6] >> (collider & 63) & 1;
}

static bool take_all_at_once(world *w, uint64_t *spent)
{
    size_t first = w->active_pairs.count;
    uint64_t units = *spent;
    if (!mark_awake(w, &units)) return false;
    array_reserve(&w->sort_scratch, w->pairs.count);
    uint64_t *since = w->sort_scratch.at;
    for (uint32_t id = 0; id < w->pairs.count && units <= w->slice; id++) {
        const pair *p = &w->pairs.at[id];
        if (!p->used || p->lingers) continue;
        unsigned seen = is_awake(w, p->a) + is_awake(w, p->b);
        if (!seen) continue;
        since[w->active_pairs.count - first] = p->active_tick;
        units += (uint64_t)seen * A_PAIR_SEEN + pair_activate(w, id);
    }
    if (units > w->slice) {
        for (size_t i = first; i < w->active_pairs.count; i++)
            pair_set_active_tick(&w->pairs.at[w->active_pairs.at[i]], since[i - first]);
        w->active_pairs.count = w->active.count = first;
        return false;
    }
    for (size_t i = 0; i < w->awake.count; i++) {
        body *b = &w->bodies.at[w->awake.at[i]];
        if (b->used && !b->ghost) b->gathered_tick = w->figures.ticks;
    }
    *spent = units;
    return true;
}

void slices_take(world *w, uint64_t spent)
{
    uint32_t recent = WORLD_NONE;
    unpark(w);
    bool direct = !w->due && !broad_unsearched_count(w->broad);
    for (size_t i = 0; i < w->fresh_now.count; i++) {
        body *b = &w->bodies.at[w->fresh_now.at[i]];
        if (b->changed_tick != w->figures.ticks) b->changed_before = b->changed_tick;
        b->changed_tick = w->figures.ticks;
    }
    bool at_once = direct && !w->figures.pairs_left_out && take_all_at_once(w, &spent);
    for (size_t i = 0; i < w->awake.count && !at_once; i++) {
        fetch_awake_ahead(w, i);
        take_or_put_off(w, w->awake.at[i], direct, &spent, &recent);
    }
    for (size_t i = 0; i < w->fresh_now.count; i++) take_or_put_off(w, w->fresh_now.at[i], direct, &spent, &recent);
    if (!direct) take_turns(w, &spent);
    w->figures.slice_units = spent;
    if (w->sliced) w->figures.pairs_left_out = pair_left_out(w);
}

/* ---- what is reported of it ---- */

/* Selectors of which a body is due, or was so when all were last looked at: that takes some ticks where they are very
 * many, and those that are found are `found` until it is done. */
static void set_bit(concerned_bits *bits, uint32_t selector)
{
    size_t word = selector >> 6;
    array_reserve(bits, word + 1);
    while (bits->count <= word) bits->at[bits->count++] = 0;
    bits->at[word] |= (uint64_t)1 << (selector & 63);
}

static void note_concerned(world *w, const body *b)
{
    const match_class *c = &w->match.classes.at[b->match];
    for (uint32_t i = 0; i < c->count; i++) {
        set_bit(&w->concerned, c->selectors[i]);
        if (w->concern_next) set_bit(&w->concerned_found, c->selectors[i]);
    }
}

void slices_concern_body(world *w, uint32_t id)
{
    note_concerned(w, &w->bodies.at[id]);
}

/* What is undone for them changes with each tick. */
static void wake_concerned(world *w)
{
    for (size_t word = 0; word < w->concerned.count; word++)
        for (uint64_t bits = w->concerned.at[word]; bits; bits &= bits - 1)
            subscription_wake_selecting(w, (uint32_t)(word * 64) + (uint32_t)__builtin_ctzll(bits));
}

/* A part of all bodies, from where the last tick ended. What is found, or was noted since, are those. */
static void find_concerned(world *w)
{
    enum { AHEAD = 16 /* bodies: each is several lines of memory */, PART = 4096 };
    size_t end = w->bodies.count < w->concern_next + PART ? w->bodies.count : w->concern_next + PART;
    if (!w->concern_next) w->concerned_found.count = 0;
    for (size_t i = w->concern_next; i < end; i++) {
        const body *b = &w->bodies.at[i], *later = &w->bodies.at[i + AHEAD < w->bodies.count ? i + AHEAD : i];
        __builtin_prefetch(&later->is_due);
        __builtin_prefetch(&later->searches_left);
        if (!b->used || b->ghost || !(b->is_due || b->is_parked || b->searches_left)) continue;
        const match_class *c = &w->match.classes.at[b->match];
        for (uint32_t k = 0; k < c->count; k++) set_bit(&w->concerned_found, c->selectors[k]);
    }
    w->concern_next = end < w->bodies.count ? end : 0;
    if (w->concern_next) return;
    concerned_bits was = w->concerned;
    w->concerned = w->concerned_found;
    w->concerned_found = was;
}

/* Nobody is concerned any more. */
static void forget_concerned(world *w)
{
    w->concerned.count = w->concerned_found.count = 0;
    w->concern_next = 0;
}

void slices_report(world *w)
{
    enum { NOW_AND_THEN = 32 }; /* ticks */
    if (!(w->due || w->parked || w->searching))
        forget_concerned(w);
    else if (w->concern_next || w->figures.ticks % NOW_AND_THEN == 0)
        find_concerned(w);
    for (size_t i = 0; i < w->left.count; i++) note_concerned(w, &w->bodies.at[w->left.at[i]]);
    wake_concerned(w);
    w->figures.pending_bodies = w->due + w->leaving.count + w->going + w->left.count + w->searching_bodies;
    w->figures.parked_bodies = w->parked;
    w->figures.pending_pairs = (size_t)w->pending + w->left.count + w->searching;
    w->figures.sliced_ticks += w->sliced;
}

static bool is_concerned(const world *w, uint32_t selector)
{
    return selector >> 6 < w->concerned.count && w->concerned.at[selector >> 6] >> (selector & 63) & 1;
}

bool slices_concern(const world *w, uint32_t subscription)
{
    uint32_t of = w->subscriptions.at[subscription].selection;
    if (of == WORLD_NONE || !w->concerned.count) return false;
    const uint32_t *s = w->match.selections.at[of].selectors;
    return is_concerned(w, s[0]) || is_concerned(w, s[1]);
}

bool world_was_sliced(const world *w)
{
    return w->sliced;
}

size_t world_pending_of(const world *w, uint64_t owner)
{
    size_t leave = soft_waiting_of(w, owner) + leaving_of(w, owner) + removal_of(w, owner) + settling_of(w, owner) +
                   impact_waiting_of(w, owner);
    for (size_t i = 0; i < w->purses.count; i++)
        if (w->purses.at[i].count && w->purses.at[i].owner == owner) return w->purses.at[i].count + leave;
    return leave;
}
