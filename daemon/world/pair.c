/* pair: which pairs exist, and which ones a tick has to decide again: only those of bodies that changed. Tick thread.
 */
#include "match.h"
#include "soft_state.h"
#include "state.h"
#include "subscription.h"

#include "base/sort.h"
#include "geom/compound.h"

#include <assert.h>
#include <stdlib.h>

static bool checks(const filter_rule *rule)
{
    return rule && !rule->allow;
}

/* Of the rules that check; the larger number is the safer one. */
static void add_distances(pair_terms *t, const filter_rule *ra, const filter_rule *rb)
{
    const filter_rule *one = checks(ra) ? ra : checks(rb) ? rb : NULL, *other = checks(rb) ? rb : one;
    if (!one) return;
    t->padding = fmax(one->padding, other->padding);
    t->margin = fmax(one->margin, other->margin);
}

/* Two-way bodies must each look at the other; a one-way body decides alone, and of two of them either one. */
static bool masks_meet(const body *a, const body *b, int *looks)
{
    bool a_looks = a->mask & b->category, b_looks = b->mask & a->category;
    *looks = 0;
    if (!a->one_way && !b->one_way) return a_looks && b_looks;
    a_looks &= a->one_way;
    b_looks &= b->one_way;
    *looks = a_looks - b_looks;
    return a_looks || b_looks;
}

/* The first rule of A that matches B, or NULL. */
static const filter_rule *first_rule(const world *w, const body *a, const body *b)
{
    rule_sets *answered = (rule_sets *)&w->rules; /* what it remembers changes no answer */
    uint32_t first = rules_first(answered, a->rule_set, b->label, b->name, b->group);
    return first == PAIR_MAP_NONE ? NULL : &a->rules[first];
}

/* To say which of two that may be equal is the first, child by child. */
static uint64_t price_of_order(const shape *a, const shape *b)
{
    enum { A_CHILD = 40 };
    bool alike = a->type == SHAPE_COMPOUND && b->type == SHAPE_COMPOUND;
    return alike && a->compound->child_count == b->compound->child_count ? A_CHILD * a->compound->child_count : 0;
}

uint64_t pair_price(void *context, uint32_t a, uint32_t b)
{
    enum { A_TRY = 200 }; /* of one name against one pattern, with pieces that are found late */
    const world *w = context;
    const collider *s = &w->colliders.at[a], *t = &w->colliders.at[b];
    const body *x = &w->bodies.at[s->body], *y = &w->bodies.at[t->body];
    size_t tries = rules_price(&w->rules, x->rule_set) + rules_price(&w->rules, y->rule_set);
    return (tries > 2 * RULES_CHEAP ? A_TRY * (uint64_t)tries : 0) + price_of_order(&s->shape, &t->shape);
}

pair_terms pair_get_terms(const world *w, const body *a, const body *b)
{
    const filter_rule *ra = first_rule(w, a, b), *rb = first_rule(w, b, a);
    bool insists = checks(ra) || checks(rb);
    pair_terms t = {.rule = ra && (!rb || ra->allow == !insists) ? ra : rb};
    bool meet = masks_meet(a, b, &t.looks);
    if (a == b && !a->soft) {
        t.why = "both are the same body";
    } else if (a->fixed && b->fixed) {
        t.why = "both are fixed";
    } else if (t.rule && !insists) {
        t.why = "a rule allows them to touch";
    } else if (!insists && !meet) {
        t.why = "their masks exclude each other";
    } else {
        t.checked = true;
        t.why = insists ? "a rule asks for it" : "nothing excludes it";
        add_distances(&t, ra, rb);
    }
    return t;
}

/* Rules are held against names for each two bodies, not for each two of their shapes, nor in each tick: a decision is
 * kept where no other one takes its place, until one of the two filters changes. Which are kept changes no answer. */
enum { RULINGS_LOG2 = 14 };

/* `a` has the lower id. */
static ruling rule_on(world *w, uint32_t a, uint32_t b)
{
    const body *x = &w->bodies.at[a], *y = &w->bodies.at[b];
    bool ruled = x->rule_count || y->rule_count;
    if (ruled && !w->rulings) w->rulings = base_zalloc((size_t)1 << RULINGS_LOG2, sizeof *w->rulings);
    ruling *kept = ruled ? &w->rulings[pair_key(a, b) * 0x9e3779b97f4a7c15u >> (64 - RULINGS_LOG2)] : NULL;
    if (kept && kept->filter_a == x->ruling && kept->filter_b == y->ruling) return *kept;
    pair_terms t = pair_get_terms(w, x, y);
    ruling r = {x->ruling, y->ruling, t.padding, t.margin, t.checked, (int8_t)t.looks};
    w->figures.rulings += ruled;
    if (kept) *kept = r;
    return r;
}

/* `looks` as of A and B. */
static ruling decide(world *w, uint32_t a, uint32_t b)
{
    ruling r = a < b ? rule_on(w, a, b) : rule_on(w, b, a);
    if (a > b) r.looks = (int8_t)-r.looks;
    return r;
}

static void keep_terms(world *w, pair *p)
{
    ruling r = decide(w, w->colliders.at[p->a].body, w->colliders.at[p->b].body);
    p->padding = r.padding;
    p->margin = r.margin;
    p->looks = r.looks;
    p->asked_epoch = 0;
}

bool pair_accept(void *context, uint32_t a, uint32_t b)
{
    world *w = context;
    const body *x = &w->bodies.at[w->colliders.at[a].body], *y = &w->bodies.at[w->colliders.at[b].body];
    bool shadowed = w->colliders.at[a].shadow || w->colliders.at[b].shadow; /* only beside its own surface */
    return (x == y) == shadowed && subscription_wants(w, x, y) &&
           decide(w, w->colliders.at[a].body, w->colliders.at[b].body).checked;
}

void pair_note_reported(world *w, uint32_t pair_id)
{
    pair *p = &w->pairs.at[pair_id];
    bool reported = false;
    for (uint32_t id = p->first_watch; id != WORLD_NONE && !reported; id = w->watches.at[id].pair_next)
        reported = w->watches.at[id].touch_id || w->watches.at[id].near_id;
    p->is_reported = reported;
}

bool pair_is_predicted(const world *w, const pair *p)
{
    for (uint32_t id = p->first_watch; id != WORLD_NONE; id = w->watches.at[id].pair_next)
        if (w->watches.at[id].predicted_id) return true;
    return false;
}

uint32_t pair_find(const world *w, uint32_t a, uint32_t b)
{
    return pair_map_get(&w->pair_of, pair_key(a, b));
}

/* From here on its shapes are looked at. */
static void enter_pair(world *w, uint32_t collider)
{
    uint32_t id = w->colliders.at[collider].body;
    body *b = &w->bodies.at[id];
    body_account(w, id);
    b->is_calm = false;
    b->pair_count++;
}

void pair_reserve(world *w, size_t count)
{
    array_reserve_in_place(&w->pairs, count);
    array_reserve_in_place(&w->pairs_more, count);
}

static uint32_t begin_pair(world *w, uint32_t a, uint32_t b)
{
    assert(a != b && w->colliders.at[a].used && w->colliders.at[b].used);
    uint32_t id = id_pool_take(&w->pair_ids);
    pair_reserve(w, (size_t)id + 1);
    if (id >= w->pairs.count) w->pairs.count = id + 1;
    bool in_order = colliders_in_order(w, &w->colliders.at[a], &w->colliders.at[b]);
    enter_pair(w, a);
    enter_pair(w, b);
    w->pairs.at[id] = (pair){.a = in_order ? a : b,
        .b = in_order ? b : a,
        .first_watch = WORLD_NONE,
        .at_origins = w->colliders.at[a].at_origin && w->colliders.at[b].at_origin,
        .used = true};
    pair_set_active_tick(&w->pairs.at[id], w->figures.ticks - 1);
    payers_charge(w, &w->pairs.at[id]);
    keep_terms(w, &w->pairs.at[id]);
    pair_map_put(&w->pair_of, pair_key(a, b), id);
    w->figures.pairs++;
    return id;
}

static uint8_t cause_of_end(world *w, const pair *p)
{
    const collider *sa = &w->colliders.at[p->a], *sb = &w->colliders.at[p->b];
    const body *a = &w->bodies.at[sa->body], *b = &w->bodies.at[sb->body];
    if (a->ghost) return a->ghost_cause;
    if (b->ghost) return b->ghost_cause;
    if (sa->ghost || sb->ghost) return CAUSE_SHAPE;
    if (!decide(w, sa->body, sb->body).checked) return CAUSE_FILTER;
    if (!subscription_wants(w, a, b)) return CAUSE_SUBSCRIPTION;
    bool jumped = a->teleport_tick > p->active_tick || b->teleport_tick > p->active_tick || p->jumped;
    return jumped ? CAUSE_TELEPORT : CAUSE_MOTION;
}

static void end(world *w, uint32_t id)
{
    pair *p = &w->pairs.at[id];
    assert(id < w->pairs.count && p->used && pair_find(w, p->a, p->b) == id);
    pair_map_remove(&w->pair_of, pair_key(p->a, p->b));
    bool reported = p->first_watch != WORLD_NONE; /* to ask the rules why may take long, and nobody else is told */
    events_pair_ended(w, id, reported ? cause_of_end(w, p) : (uint8_t)CAUSE_MOTION);
    impact_forget(w, id);
    free(p->cache.shell);
    p->cache.shell = NULL;
    assert(p->first_watch == WORLD_NONE && w->lingers >= p->lingers);
    w->lingers -= p->lingers;
    if (!p->lingers) payers_release(w, p);
    p->used = p->lingers = false;
    w->bodies.at[w->colliders.at[p->a].body].pair_count--;
    w->bodies.at[w->colliders.at[p->b].body].pair_count--;
    id_pool_give(&w->pair_ids, id);
    w->figures.pairs--;
}

/* ---- whose boxes have parted ----
 *
 * Boxes are fat, and by how much must not show: nothing that is reported follows from them. A pair that somebody has
 * been told of lingers, and is decided like any other, until its last watch has ended. */

static bool may_linger(world *w, const pair *p)
{
    if (p->first_watch == WORLD_NONE) return false;
    uint8_t cause = cause_of_end(w, p);
    return cause == CAUSE_MOTION || cause == CAUSE_TELEPORT;
}

/* One that is on the active list stays until the tick is over. */
uint32_t pair_part(world *w, uint32_t a, uint32_t b)
{
    uint32_t id = pair_find(w, a, b);
    if (id == PAIR_MAP_NONE) return id; /* it was left out */
    if (w->pairs.at[id].active_tick != w->figures.ticks && !may_linger(w, &w->pairs.at[id])) {
        end(w, id);
        return PAIR_MAP_NONE;
    }
    payers_release(w, &w->pairs.at[id]);
    w->pairs.at[id].lingers = true;
    w->lingers++;
    array_push(&w->lingering, id);
    return id;
}

/* Ends those that may not linger any more, and forgets those whose boxes have met again. */
static void end_lingering(world *w)
{
    size_t kept = 0;
    for (size_t i = 0; i < w->lingering.count; i++) {
        uint32_t id = w->lingering.at[i];
        if (!w->pairs.at[id].lingers) continue;
        if (may_linger(w, &w->pairs.at[id]))
            w->lingering.at[kept++] = id;
        else
            end(w, id);
    }
    w->lingering.count = kept;
}

void pair_end_unwatched(world *w)
{
    size_t kept = 0;
    for (size_t i = 0; i < w->lingering.count; i++) {
        uint32_t id = w->lingering.at[i];
        if (!w->pairs.at[id].lingers) continue; /* a search has found that they meet again */
        if (w->pairs.at[id].first_watch != WORLD_NONE)
            w->lingering.at[kept++] = id;
        else
            end(w, id);
    }
    w->lingering.count = kept;
}

/* ---- as many as max_pairs allows ---- */

/* Those that linger are about to end, and take no room. */
static size_t meeting(const world *w)
{
    return w->figures.pairs - w->lingers;
}

size_t pair_left_out(const world *w)
{
    return broad_pair_count(w->broad) - meeting(w);
}

size_t pair_most(const world *w)
{
    size_t most = w->options.max_pairs ? w->options.max_pairs : SIZE_MAX;
    return w->pairs_most && w->pairs_most < most ? w->pairs_most : most;
}

/* For anybody's. */
static size_t room_for_pairs(const world *w)
{
    size_t most = payers_open(pair_most(w));
    return meeting(w) < most ? most - meeting(w) : 0;
}

uint32_t pair_meet(world *w, uint32_t a, uint32_t b)
{
    if (!payers_allow(w, a, b)) return PAIR_MAP_NONE;
    uint32_t id = pair_find(w, a, b);
    if (id == PAIR_MAP_NONE) return begin_pair(w, a, b);
    if (w->pairs.at[id].lingers) payers_charge(w, &w->pairs.at[id]);
    w->lingers -= w->pairs.at[id].lingers;
    w->pairs.at[id].lingers = false;
    return id;
}

typedef struct latecomers {
    const world *w;
    uint32_t proxy;
    size_t passed;
    ARRAY(uint64_t) keys;
} latecomers;

static void find_latecomer(void *context, uint32_t other)
{
    latecomers *l = context;
    uint32_t id = pair_find(l->w, l->proxy, other);
    l->passed++;
    if (l->proxy < other && !l->w->colliders.at[other].ghost && (id == PAIR_MAP_NONE || l->w->pairs.at[id].lingers))
        array_push(&l->keys, pair_key(l->proxy, other));
}

/* In units, with finding, deciding and reporting of it. */
enum { A_LATECOMER = 4000, A_PASSED = 50, LET_IN_PART = 4 /* of a slice, at most */, LET_IN_AT_LEAST = 64 };

static size_t most_looked_at(const world *w, uint64_t each)
{
    uint64_t most = w->slice / LET_IN_PART / each;
    return w->slice == UINT64_MAX ? SIZE_MAX : most < LET_IN_AT_LEAST ? LET_IN_AT_LEAST : (size_t)most;
}

/* From the next collider on, so many, or until so many pairs have been passed. */
static void find_latecomers(world *w, latecomers *l, size_t most)
{
    size_t passed = 0, passes = most_looked_at(w, A_PASSED);
    while (w->lets_in_next < w->colliders.count && l->keys.count < most && passed < passes) {
        uint32_t id = w->lets_in_next++;
        size_t first = l->keys.count;
        passed++;
        if (!w->colliders.at[id].used || w->colliders.at[id].ghost) continue;
        l->proxy = id;
        l->passed = 0;
        broad_each_pair_of(w->broad, id, find_latecomer, l);
        passed += l->passed;
        array_reserve(&w->sort_scratch, l->keys.count);
        sort_keys(l->keys.at + first, w->sort_scratch.at, l->keys.count - first);
    }
    if (l->keys.count <= most) return;
    w->lets_in_next--; /* it has more */
    l->keys.count = most;
}

/* Those that were left out begin in the order of their ids, and are decided like what the last tick left. To find them
 * takes a walk over all pairs: only once there is room for all of them, or for a good share of what may be; then some
 * in each tick, until that walk is over. */
static void let_in(world *w)
{
    size_t out = pair_left_out(w), room = room_for_pairs(w), most = most_looked_at(w, A_LATECOMER);
    if (!w->lets_in && room < out && room <= w->options.max_pairs / 16) return;
    if (!w->lets_in) w->lets_in_next = 0;
    latecomers l = {.w = w};
    find_latecomers(w, &l, room < most ? room : most);
    for (size_t i = 0; i < l.keys.count; i++) {
        uint32_t a = (uint32_t)(l.keys.at[i] >> 32), b = (uint32_t)l.keys.at[i];
        pair_meet(w, a, b);
        array_push(&w->unfinished, pair_find(w, a, b));
    }
    w->lets_in = w->lets_in_next < w->colliders.count && l.keys.count < room;
    w->sliced |= w->lets_in;
    array_free(&l.keys);
}

void pair_apply_changes(world *w, const broad_changes *changes)
{
    for (size_t i = 0; i < changes->ended_count; i++) pair_part(w, changes->ended[i].a, changes->ended[i].b);
    for (size_t i = 0; i < changes->began_count; i++) pair_meet(w, changes->began[i].a, changes->began[i].b);
    if (w->figures.pairs_left_out)
        let_in(w);
    else
        w->lets_in = false;
    end_lingering(w);
    w->figures.pairs_left_out = pair_left_out(w);
}

/* ---- the active list ---- */

/* Units, as work.c has them, from what is known before it is decided: one that was reported is reported again.
 */
enum { A_LOOK = 150, A_WATCH = 1500 };

static __attribute__((noinline)) uint64_t units_of_work(const world *w, const pair *p, bool reported, bool is_new)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    double units = A_LOOK;
    if (reported)
        units += (double)a->overlapping + b->overlapping;
    else if (is_new || !(p->cache.lower > 0))
        units += slices_is_dear(a) || slices_is_dear(b) ? (double)a->overlapping + b->overlapping
                                                        : (double)a->apart + b->apart;
    for (uint32_t id = p->first_watch; id != WORLD_NONE; id = w->watches.at[id].pair_next) units += A_WATCH;
    if (is_new && !reported) units += A_WATCH; /* one, at least, may begin */
    return (uint64_t)units + impact_units(w, p);
}

static inline uint64_t cheap_units(const world *w, const pair *p)
{
    if (w->slice == UINT64_MAX) return A_LOOK; /* nobody counts */
    bool reported = p->first_watch != WORLD_NONE, is_new = p->asked_epoch == 0;
    if (!reported && !is_new && p->cache.lower > 0 && !w->sweepers) return A_LOOK;
    return units_of_work(w, p, reported, is_new);
}

uint64_t pair_units(const world *w, const pair *p)
{
    return cheap_units(w, p);
}

/* Has a filter been put, a body teleported, or become one of another class, since the pair was active last? Not for
 * this pair, perhaps, but somewhere. */
static inline bool may_be_outdated(const world *w, const pair *p)
{
    uint64_t since = p->active_tick;
    return w->ruled_tick > since || w->teleport_tick > since || p->edition != w->match.edition;
}

/* Brings up to date what it keeps of its bodies. One that a filter refuses by now, whose search has been put off, is
 * left to that: false. */
static __attribute__((noinline)) bool renew(world *w, pair *p)
{
    uint64_t since = p->active_tick;
    const body *a = &w->bodies.at[w->colliders.at[p->a].body], *b = &w->bodies.at[w->colliders.at[p->b].body];
    bool ruled = w->ruled_tick > since && (a->ruled_tick > since || b->ruled_tick > since);
    if (ruled && w->sliced && !decide(w, w->colliders.at[p->a].body, w->colliders.at[p->b].body).checked) return false;
    p->ruled = ruled;
    p->jumped = w->teleport_tick > since && (a->teleport_tick > since || b->teleport_tick > since);
    w->some_teleported |= p->jumped;
    if (ruled) keep_terms(w, p);
    p->wanted = match_wanted(&w->match, a->match, b->match);
    p->edition = w->match.edition;
    return true;
}

/* One that the budget left may have ended since, and its id may be another's. */
uint64_t pair_activate(world *w, uint32_t id)
{
    enum {
        A_WISH = 20, /* to list a subscription that wants it, and to hold what is found against its terms; ... */
        A_SOFT_BEGIN = 4000, /* ... of a soft body, most often all of them are told that it begins, ... */
        A_SOFT_NEWS = 800    /* ... or goes on elsewhere */
    };
    pair *p = &w->pairs.at[id];
    if (!p->used || p->active_tick == w->figures.ticks) return 0;
    bool leaves = w->leaving.count && (w->colliders.at[p->a].ghost || w->colliders.at[p->b].ghost);
    if (leaves) return 0; /* it is about to end */
    if (w->left.count &&
        (w->bodies.at[w->colliders.at[p->a].body].dirty || w->bodies.at[w->colliders.at[p->b].body].dirty))
        return 0; /* it is decided when both are where their poses say */
    if (!may_be_outdated(w, p))
        p->ruled = p->jumped = false;
    else if (!renew(w, p))
        return 0;
    pair_set_active_tick(p, w->figures.ticks);
    array_push(&w->active_pairs, id);
    array_push(&w->active, pair_key(p->a, p->b));
    uint64_t each = !pair_is_soft(w, p) ? A_WISH : p->first_watch == WORLD_NONE ? A_SOFT_BEGIN : A_SOFT_NEWS;
    return cheap_units(w, p) + each * (uint64_t)subscription_list(w, p).count;
}

static void activate_lingering(world *w, uint32_t id)
{
    if (pair_is_pending(w, &w->pairs.at[id])) pair_activate(w, id);
}

static unsigned bits_of(size_t count)
{
    unsigned bits = 0;
    while (bits < 64 && count >> bits) bits++;
    return bits;
}

void pair_sort_active(world *w, unsigned of_colliders, unsigned of_pairs)
{
    size_t count = w->active_pairs.count;
    bool fits = 2 * of_colliders + of_pairs <= 64;
    array_reserve(&w->sort_scratch, count);
    for (size_t i = 0; fits && i < count; i++) {
        uint64_t key = w->active.at[i];
        w->active.at[i] = (key >> 32 << of_colliders | (uint32_t)key) << of_pairs | w->active_pairs.at[i];
    }
    sort_keys_above(w->active.at, w->sort_scratch.at, count, fits ? of_pairs : 0);
    for (size_t i = 0; i < count; i++) {
        uint64_t key = w->active.at[i];
        if (fits) {
            w->active_pairs.at[i] = (uint32_t)(key & ((UINT64_C(1) << of_pairs) - 1));
            key >>= of_pairs;
            w->active.at[i] = key >> of_colliders << 32 | (key & ((UINT64_C(1) << of_colliders) - 1));
        } else {
            w->active_pairs.at[i] = pair_map_get(&w->pair_of, key);
        }
    }
}

/* The pairs of what moved or was refiltered, in the order of their colliders' ids; as many as a slice has room for. New
 * pairs are among them: a pair begins only when one of its bodies was put again, or it was left out until now, and is
 * unfinished, or when its search was put off, and puts it on the list. */
void pair_collect_active(world *w)
{
    w->active_pairs.count = w->active.count = 0;
    leaving_go_on(w);
    slices_take(w, impact_go_on(w));
    for (size_t i = 0; i < w->unfinished.count; i++) pair_activate(w, w->unfinished.at[i]);
    for (size_t i = 0; i < w->lingering.count; i++) activate_lingering(w, w->lingering.at[i]);
    pair_sort_active(w, bits_of(w->colliders.count), bits_of(w->pairs.count));
}
