/* broad: which proxies need a new fat box, and the batch of those, carried out in the order of their places in the
 * trees. One thread; only the queries may run in several, between updates. Between updates two proxies are a pair if
 * and only if their fat boxes meet, not both are fixed, and the filter accepted them when their boxes met or one of the
 * two was refiltered. */
#include "broad.h"

#include "base/sort.h"
#include "base/whole.h"
#include "state.h"

#include <assert.h>
#include <stdlib.h>

/* m. Boxes that reach further are kept beside the trees: the surface of a union stays below the greatest float. */
static const float TREE_REACH = 1e18F;

/* A fat box that is this many times larger than a new one would be is replaced although the tight box is inside: it was
 * made for a wider range or a faster body. */
static const double TOO_FAT = 2;

/* For how many puts a fat box reaches ahead of a body that keeps moving as it does, and at most how far, as a share of
 * the tight box along that axis: what is fast would meet half the world. Measured, 1,000 boxes that all move by 1 to 2
 * % of their size: reaching ahead for 12, 16, 24 and 32 puts costs 57, 49, 45 and 41 ns a body, and brings 0.79, 0.87,
 * 0.98 and 1.13 pairs a body, each of which the narrow phase has to settle. */
static const double LOOK_AHEAD = 16, LOOK_AHEAD_MOST = 0.5;

broad *broad_create(broad_kind kind, broad_filter *filter, void *context)
{
    broad *b = base_zalloc(1, sizeof *b);
    b->filter = filter;
    b->filter_context = context;
    b->kind = kind;
    b->limit = UINT64_MAX;
    b->most_pairs = SIZE_MAX;
    b->index = broad_first_index(kind);
    tree_init(&b->moving);
    tree_init(&b->fixed);
    pairs_init(&b->pairs);
    return b;
}

void broad_destroy(broad *b)
{
    if (!b) return;
    b->index->free(b);
    pairs_free(&b->pairs);
    array_free_in_place(&b->proxies);
    array_free(&b->unbounded);
    array_free(&b->listed);
    array_free(&b->marks);
    array_free(&b->asked);
    array_free(&b->pending);
    array_free(&b->order);
    array_free(&b->unsettled);
    array_free(&b->met);
    array_free(&b->began);
    array_free(&b->ended);
    array_free(&b->scratch);
    free(b);
}

/* ---- fat boxes ---- */

static inline void fatten(double *lo, double *hi, double margin, double motion)
{
    double most = LOOK_AHEAD_MOST * (*hi - *lo), reach = LOOK_AHEAD * motion;
    if (reach > most) reach = most;
    if (reach < -most) reach = -most;
    *lo += (reach < 0 ? reach : 0) - margin;
    *hi += (reach > 0 ? reach : 0) + margin;
}

static fbox fat_box(const broad_move *m)
{
    aabb b = m->box;
    fatten(&b.lo.x, &b.hi.x, m->margin, m->motion.x);
    fatten(&b.lo.y, &b.hi.y, m->margin, m->motion.y);
    fatten(&b.lo.z, &b.hi.z, m->margin, m->motion.z);
    return fbox_outward(b);
}

/* Boxes that are at most TOO_FAT times the tight one are told at a glance; the others are compared with what a new fat
 * box would be. */
static inline bool slim(const fbox *old, const aabb *tight)
{
    return ((double)old->hi[0] - old->lo[0] <= TOO_FAT * (tight->hi.x - tight->lo.x)) &
           ((double)old->hi[1] - old->lo[1] <= TOO_FAT * (tight->hi.y - tight->lo.y)) &
           ((double)old->hi[2] - old->lo[2] <= TOO_FAT * (tight->hi.z - tight->lo.z));
}

static bool too_fat(const fbox *old, const broad_move *move)
{
    fbox new = fat_box(move);
    for (int k = 0; k < 3; k++)
        if (old->hi[k] - old->lo[k] > (float)TOO_FAT * (new.hi[k] - new.lo[k])) return true;
    return false;
}

static inline bool contains(const fbox *outer, const aabb *inner)
{
    return (outer->lo[0] <= inner->lo.x) & (outer->lo[1] <= inner->lo.y) & (outer->lo[2] <= inner->lo.z) &
           (inner->hi.x <= outer->hi[0]) & (inner->hi.y <= outer->hi[1]) & (inner->hi.z <= outer->hi[2]);
}

static place place_for(const fbox *box)
{
    for (int k = 0; k < 3; k++)
        if (box->lo[k] < -TREE_REACH || box->hi[k] > TREE_REACH) return UNBOUNDED;
    return INDEXED;
}

/* The common case of a body that moves a little: nothing is to be done. */
static inline bool may_stay(const proxy *p, const broad_move *move)
{
    return p->place != NOWHERE && p->fixed == move->fixed && contains(&p->fat, &move->box) &&
           (slim(&p->fat, &move->box) || !too_fat(&p->fat, move));
}

/* ---- queueing ---- */

static proxy *proxy_at(broad *b, uint32_t id)
{
    array_reserve_in_place(&b->proxies, (size_t)id + 1);
    while (b->proxies.count <= id) b->proxies.at[b->proxies.count++] = (proxy){.pending = NOTHING_PENDING};
    return &b->proxies.at[id];
}

static change *pending_of(broad *b, uint32_t id)
{
    proxy *p = proxy_at(b, id);
    if (p->pending == NOTHING_PENDING) {
        p->pending = (uint32_t)b->pending.count;
        array_push(&b->pending, (change){.proxy = id});
    }
    return &b->pending.at[p->pending];
}

static void queue_put(broad *b, const broad_move *move)
{
    change *c = pending_of(b, move->proxy);
    c->put = c->removed || !may_stay(&b->proxies.at[move->proxy], move);
    c->fixed = move->fixed;
    c->fat = fat_box(move);
}

bool broad_put(broad *b, const broad_move *move)
{
    assert(move->box.lo.x <= move->box.hi.x && move->box.lo.y <= move->box.hi.y && move->box.lo.z <= move->box.hi.z);
    assert(move->margin >= 0);
    if (move->proxy < b->proxies.count) {
        proxy *p = &b->proxies.at[move->proxy];
        p->passive = move->passive;
        if (may_stay(p, move) && p->pending == NOTHING_PENDING) return true;
    }
    queue_put(b, move);
    b->proxies.at[move->proxy].passive = move->passive;
    return false;
}

/* The fat box that it will have after the next update, and where. */
static const fbox *coming_box(const broad *b, uint32_t id, place *at)
{
    const proxy *p = &b->proxies.at[id];
    const change *c = p->pending == NOTHING_PENDING ? NULL : &b->pending.at[p->pending];
    *at = c && c->put ? place_for(&c->fat) : c && c->removed ? NOWHERE : (place)p->place;
    return c && c->put ? &c->fat : &p->fat;
}

bool broad_region_of(const broad *b, uint32_t id, aabb tight, double margin, broad_region *out)
{
    place at;
    if (id >= b->proxies.count) return false;
    const fbox *fat = coming_box(b, id, &at);
    if (at != INDEXED || !contains(fat, &tight)) return false;
    const double *lo = &tight.lo.x, *hi = &tight.hi.x;
    out->fat = fbox_aabb(fat);
    out->slim = true;
    for (int k = 0; k < 3; k++) {
        out->down[k] = lo[k] - fat->lo[k];
        out->up[k] = fat->hi[k] - hi[k];
        /* A new one would be wider than the tight one by two margins, at least. */
        out->least[k] = ((double)fat->hi[k] - fat->lo[k]) / TOO_FAT - 2 * margin;
        out->slim &= hi[k] - lo[k] >= out->least[k];
    }
    return true;
}

broad_move broad_fat_box(const broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    return (broad_move){.proxy = id, .fixed = p->fixed, .passive = p->passive, .box = fbox_aabb(&p->fat)};
}

void broad_remove(broad *b, uint32_t id)
{
    change *c = pending_of(b, id);
    c->removed = true;
    c->put = c->refilter = c->late = false;
}

void broad_let_leave(broad *b, uint32_t id)
{
    pending_of(b, id)->late = true;
}

void broad_refilter(broad *b, uint32_t id)
{
    pending_of(b, id)->refilter = true;
}

/* ---- where a proxy is kept ---- */

static void list_beside(broad *b, uint32_t id)
{
    array_reserve(&b->listed, (size_t)id + 1);
    while (b->listed.count <= id) b->listed.at[b->listed.count++] = 0;
    b->listed.at[id] = (uint32_t)b->unbounded.count;
    array_push(&b->unbounded, id);
}

static void take_from_list(broad *b, uint32_t id)
{
    uint32_t last = b->unbounded.at[--b->unbounded.count];
    b->unbounded.at[b->listed.at[id]] = last;
    b->listed.at[last] = b->listed.at[id];
}

static void take_proxy_out(broad *b, uint32_t id)
{
    proxy *p = &b->proxies.at[id];
    if (p->place == INDEXED) b->index->remove(b, id);
    if (p->place == UNBOUNDED) take_from_list(b, id);
    b->proxy_count -= p->place != NOWHERE;
    p->place = NOWHERE;
}

void broad_take_leaving(broad *b, uint32_t id)
{
    broad_forget_put_off(b, id);
    take_proxy_out(b, id);
    broad_set_leaving(b, id, true);
}

static void put_proxy_in(broad *b, const change *c)
{
    proxy *p = &b->proxies.at[c->proxy];
    p->place = (uint8_t)place_for(&c->fat);
    b->proxy_count++;
    if (p->place == INDEXED)
        b->index->put(b, c);
    else
        list_beside(b, c->proxy);
}

static void replace(broad *b, change *c)
{
    proxy *p = &b->proxies.at[c->proxy];
    if (p->place == INDEXED && place_for(&c->fat) == INDEXED) {
        b->index->move(b, c);
    } else {
        take_proxy_out(b, c->proxy);
        put_proxy_in(b, c);
    }
    p->fat = c->fat;
    p->fixed = c->fixed;
}

/* ---- the update ---- */

static void sort_in_scratch(broad *b, key_array *keys)
{
    array_reserve(&b->scratch, keys->count);
    sort_keys(keys->at, b->scratch.at, keys->count);
}

/* Where a proxy is in memory, unique. */
static uint64_t position_in_order(const broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    if (p->place != INDEXED) return UINT64_C(1) << 31 | id;
    return (uint64_t)p->fixed << 30 | b->index->position(b, id);
}

/* By position, which depends only on what is there, so that the order of the calls does not matter; and what is near
 * in space is mostly near in memory. */
static void order_pending(broad *b)
{
    b->order.count = 0;
    array_reserve(&b->order, b->pending.count);
    for (size_t i = 0; i < b->pending.count; i++)
        b->order.at[b->order.count++] = position_in_order(b, b->pending.at[i].proxy) << 32 | i;
    sort_in_scratch(b, &b->order);
}

/* Those in `unsettled`, again: the boxes have been applied. */
static void order_unsettled(broad *b)
{
    b->order.count = 0;
    array_reserve(&b->order, b->unsettled.count);
    for (size_t i = 0; i < b->unsettled.count; i++) {
        uint32_t index = b->unsettled.at[i];
        b->order.at[b->order.count++] = position_in_order(b, b->pending.at[index].proxy) << 32 | index;
    }
    sort_in_scratch(b, &b->order);
    for (size_t i = 0; i < b->unsettled.count; i++) b->unsettled.at[i] = (uint32_t)b->order.at[i];
}

static void apply_box(broad *b, uint32_t index)
{
    change *c = &b->pending.at[index];
    proxy *p = &b->proxies.at[c->proxy];
    if (c->removed) {
        bool leaves = c->late && !c->put && pairs_of(&b->pairs, c->proxy);
        if (!leaves) broad_end_all_pairs(b, c->proxy);
        broad_forget_put_off(b, c->proxy);
        take_proxy_out(b, c->proxy);
        broad_set_leaving(b, c->proxy, leaves);
    }
    c->asks = true;
    c->was = p->place != NOWHERE;
    c->was_fixed = p->fixed;
    c->old = p->fat;
    if (c->put) replace(b, c);
    c->asks |= b->all_ask;
    if (p->place != NOWHERE && (c->put || c->refilter)) array_push(&b->unsettled, index);
}

const broad_pair *broad_hand_out(broad *b, key_array *keys)
{
    sort_in_scratch(b, keys);
    broad_pair *pairs = (broad_pair *)keys->at; /* in place: both are 8 bytes */
    for (size_t i = 0; i < keys->count; i++) {
        uint64_t key = keys->at[i];
        pairs[i] = (broad_pair){(uint32_t)(key >> 32), (uint32_t)key};
    }
    return pairs;
}

/* What a fill has grown no later update needs at that size: without this it would be a third of all memory. */
static void give_all_buffers_back(broad *b)
{
    array_free(&b->pending);
    array_free(&b->order);
    array_free(&b->unsettled);
    array_free(&b->scratch);
    array_free(&b->met);
    b->index->give_buffers_back(b);
}

void broad_update(broad *b, broad_changes *changes)
{
    size_t count_before = b->proxy_count;
    b->updates++;
    b->began.count = b->ended.count = b->unsettled.count = b->met.count = 0;
    broad_choose_index(b);
    b->all_ask = broad_must_ask(b);
    order_pending(b);
    for (size_t i = 0; i < b->order.count; i++) apply_box(b, (uint32_t)b->order.at[i]);
    b->index->settle(b);
    order_unsettled(b);
    broad_settle(b);
    for (size_t i = 0; i < b->pending.count; i++) b->proxies.at[b->pending.at[i].proxy].pending = NOTHING_PENDING;
    b->pending.count = 0;
    *changes = (broad_changes){.began = broad_hand_out(b, &b->began),
        .ended = broad_hand_out(b, &b->ended),
        .began_count = b->began.count,
        .ended_count = b->ended.count};
    if (b->proxy_count > 2 * count_before) give_all_buffers_back(b);
    ASSERT_WHOLE(whole_is_due(b->updates, b->proxy_count + b->pairs.count), broad_validate(b));
}

void broad_trim(broad *b)
{
    if (b->pending.count) return;
    give_all_buffers_back(b);
    array_free(&b->began);
    array_free(&b->ended);
    pairs_trim(&b->pairs);
}

size_t broad_proxy_count(const broad *b)
{
    return b->proxy_count;
}
size_t broad_pair_count(const broad *b)
{
    return b->pairs.count;
}

/* ---- validation ---- */

static const char *validate_place(const broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    switch ((place)p->place) {
    case NOWHERE:
        return p->leaving || pairs_first(&b->pairs, id) == PAIRS_NO_LINK ? NULL : "a proxy that is gone has pairs";
    case UNBOUNDED:
        return b->unbounded.at[b->listed.at[id]] == id ? NULL : "a listed proxy is lost";
    case INDEXED:
        return NULL; /* the index knows */
    }
    return "a proxy is at no known place";
}

static const char *validate_proxy(const broad *b, uint32_t id)
{
    const char *broken = validate_place(b, id);
    const proxy *p = &b->proxies.at[id];
    for (uint32_t link = pairs_first(&b->pairs, id); !broken && link != PAIRS_NO_LINK;
         link = pairs_next(&b->pairs, link)) {
        const proxy *q = &b->proxies.at[pairs_other(&b->pairs, link)];
        if (!may_pair(&p->fat, p->fixed, &q->fat, q->fixed) && !p->unsearched && !q->unsearched && !p->leaving &&
            !q->leaving)
            broken = "a pair has parted";
    }
    return broken;
}

const char *broad_validate(const broad *b)
{
    size_t indexed = 0;
    const char *broken = b->index->validate(b, &indexed);
    if (!broken) broken = pairs_validate(&b->pairs);
    for (uint32_t id = 0; !broken && id < b->proxies.count; id++) broken = validate_proxy(b, id);
    if (broken) return broken;
    return indexed + b->unbounded.count == b->proxy_count ? NULL : "the count of proxies is wrong";
}
