/* broad: the batch of queued changes, carried out proxy by proxy in the order of their ids. One thread; only the
 * queries at the end may run in several, between updates. Between updates two proxies are a pair if and only if their
 * fat boxes meet, not both are fixed, and the filter accepted them when one of the two was last looked at. */
#include "broad.h"

#include "base/array.h"
#include "base/sort.h"
#include "broad_peek.h"
#include "pairs.h"
#include "tree.h"

#include <assert.h>
#include <stdlib.h>

#define NOTHING_PENDING UINT32_MAX

/* m. Boxes that reach further are kept beside the trees: the surface of a union stays below the greatest float. */
static const float TREE_REACH = 1e18F;

/* A fat box that is this many times larger than a new one would be is replaced although the tight box is inside: it was
 * made for a wider range or a faster body. */
static const float TOO_FAT = 2;

typedef enum place { NOWHERE, IN_TREE, UNBOUNDED } place;

typedef struct proxy {
    fbox fat;
    uint32_t pending; /* index into `pending`, or NOTHING_PENDING */
    uint32_t listed;  /* index into `unbounded` */
    uint8_t place;
    bool fixed;
} proxy;

typedef struct change { /* what was asked for one proxy since the last update: first removed, then put */
    uint32_t proxy;
    bool removed, put, refilter;
    broad_move move; /* the last one put */
} change;

typedef ARRAY(uint64_t) key_array;

struct broad {
    broad_filter *filter;
    void *filter_context;

    ARRAY(proxy) proxies; /* by the caller's id */
    size_t proxy_count;   /* those that are somewhere */
    tree moving, fixed;
    ARRAY(uint32_t) unbounded;
    pairs pairs;

    ARRAY(change) pending;
    key_array order;           /* proxy << 32 | index into `pending` */
    ARRAY(uint32_t) unsettled; /* indices into `pending`: whose pairs have to be looked at */
    key_array began_keys, ended_keys, scratch;
    ARRAY(broad_pair) began, ended; /* the same, handed out */
};

broad *broad_create(broad_filter *filter, void *context)
{
    broad *b = base_zalloc(1, sizeof *b);
    b->filter = filter;
    b->filter_context = context;
    tree_init(&b->moving);
    tree_init(&b->fixed);
    pairs_init(&b->pairs);
    return b;
}

void broad_destroy(broad *b)
{
    if (!b) return;
    tree_free(&b->moving);
    tree_free(&b->fixed);
    pairs_free(&b->pairs);
    array_free(&b->proxies);
    array_free(&b->unbounded);
    array_free(&b->pending);
    array_free(&b->order);
    array_free(&b->unsettled);
    array_free(&b->began_keys);
    array_free(&b->ended_keys);
    array_free(&b->scratch);
    array_free(&b->began);
    array_free(&b->ended);
    free(b);
}

/* ---- queueing ---- */

static proxy *proxy_at(broad *b, uint32_t id)
{
    array_reserve(&b->proxies, (size_t)id + 1);
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

void broad_put(broad *b, const broad_move *move)
{
    assert(move->box.lo.x <= move->box.hi.x && move->box.lo.y <= move->box.hi.y && move->box.lo.z <= move->box.hi.z);
    assert(move->margin >= 0);
    change *c = pending_of(b, move->proxy);
    c->put = true;
    c->move = *move;
}

void broad_remove(broad *b, uint32_t id)
{
    change *c = pending_of(b, id);
    c->removed = true;
    c->put = c->refilter = false;
}

void broad_refilter(broad *b, uint32_t id)
{
    pending_of(b, id)->refilter = true;
}

/* ---- where a proxy is kept ---- */

static tree *tree_of(broad *b, const proxy *p)
{
    return p->fixed ? &b->fixed : &b->moving;
}

static place place_for(const fbox *box)
{
    for (int k = 0; k < 3; k++)
        if (box->lo[k] < -TREE_REACH || box->hi[k] > TREE_REACH) return UNBOUNDED;
    return IN_TREE;
}

static void take_proxy_out(broad *b, uint32_t id)
{
    proxy *p = &b->proxies.at[id];
    if (p->place == IN_TREE) tree_remove(tree_of(b, p), id);
    if (p->place == UNBOUNDED) {
        uint32_t last = b->unbounded.at[--b->unbounded.count];
        b->unbounded.at[p->listed] = last;
        b->proxies.at[last].listed = p->listed;
    }
    b->proxy_count -= p->place != NOWHERE;
    p->place = NOWHERE;
}

static void put_proxy_in(broad *b, uint32_t id, const fbox *fat, bool fixed)
{
    proxy *p = &b->proxies.at[id];
    p->fat = *fat;
    p->fixed = fixed;
    p->place = (uint8_t)place_for(fat);
    b->proxy_count++;
    if (p->place == IN_TREE) {
        tree_insert(tree_of(b, p), id, fat);
        return;
    }
    p->listed = (uint32_t)b->unbounded.count;
    array_push(&b->unbounded, id);
}

static bool too_fat(const fbox *old, const fbox *new)
{
    for (int k = 0; k < 3; k++)
        if (old->hi[k] - old->lo[k] > TOO_FAT * (new->hi[k] - new->lo[k])) return true;
    return false;
}

static bool may_stay(const proxy *p, const broad_move *move, const fbox *fat)
{
    return p->place == place_for(fat) && p->fixed == move->fixed && fbox_contains_aabb(&p->fat, &move->box) &&
           !too_fat(&p->fat, fat);
}

/* ---- pairs ---- */

static void end_pair(broad *b, uint32_t id, uint32_t link)
{
    array_push(&b->ended_keys, pair_key(id, pairs_other(&b->pairs, link)));
    pairs_end(&b->pairs, link);
}

static void end_all_pairs(broad *b, uint32_t id)
{
    for (uint32_t link; (link = pairs_first(&b->pairs, id)) != PAIRS_NO_LINK;) end_pair(b, id, link);
}

static bool accepts(const broad *b, uint32_t x, uint32_t y)
{
    return x < y ? b->filter(b->filter_context, x, y) : b->filter(b->filter_context, y, x);
}

/* By boxes alone. */
static bool may_pair(const proxy *p, const proxy *q)
{
    return !(p->fixed && q->fixed) && fbox_overlap(&p->fat, &q->fat);
}

static void end_parted_pairs(broad *b, uint32_t id, bool refilter)
{
    for (uint32_t next, link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = next) {
        next = pairs_next(&b->pairs, link);
        uint32_t other = pairs_other(&b->pairs, link);
        bool stays = may_pair(&b->proxies.at[id], &b->proxies.at[other]) && (!refilter || accepts(b, id, other));
        if (!stays) end_pair(b, id, link);
    }
}

typedef struct meeting {
    broad *b;
    uint32_t id;
} meeting;

static bool meet(void *context, uint32_t other)
{
    const meeting *m = context;
    broad *b = m->b;
    if (other == m->id || pairs_have(&b->pairs, m->id, other) || !accepts(b, m->id, other)) return true;
    pairs_begin(&b->pairs, m->id, other);
    array_push(&b->began_keys, pair_key(m->id, other));
    return true;
}

static void begin_new_pairs(broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    meeting m = {b, id};
    tree_query_box(&b->moving, &p->fat, meet, &m);
    if (!p->fixed) tree_query_box(&b->fixed, &p->fat, meet, &m);
    for (size_t i = 0; i < b->unbounded.count; i++)
        if (may_pair(p, &b->proxies.at[b->unbounded.at[i]])) meet(&m, b->unbounded.at[i]);
}

/* ---- the update ---- */

static void sort_in_scratch(broad *b, key_array *keys)
{
    array_reserve(&b->scratch, keys->count);
    sort_keys(keys->at, b->scratch.at, keys->count);
}

/* By proxy, so that the order of the calls does not matter. */
static void order_pending(broad *b)
{
    b->order.count = 0;
    for (size_t i = 0; i < b->pending.count; i++) array_push(&b->order, (uint64_t)b->pending.at[i].proxy << 32 | i);
    sort_in_scratch(b, &b->order);
}

/* The boxes first, all of them: pairs are decided by where everybody is at the end of the batch. */
static void apply_boxes(broad *b, uint32_t index)
{
    const change *c = &b->pending.at[index];
    proxy *p = &b->proxies.at[c->proxy];
    p->pending = NOTHING_PENDING;
    if (c->removed) {
        end_all_pairs(b, c->proxy);
        take_proxy_out(b, c->proxy);
    }
    bool moved = false;
    if (c->put) {
        fbox fat = fbox_outward(aabb_grow(c->move.box, c->move.margin));
        moved = !may_stay(p, &c->move, &fat);
        if (moved) {
            take_proxy_out(b, c->proxy);
            put_proxy_in(b, c->proxy, &fat, c->move.fixed);
        }
    }
    if (p->place != NOWHERE && (moved || c->refilter)) array_push(&b->unsettled, index);
}

static const broad_pair *hand_out(broad *b, key_array *keys, broad_pair *to)
{
    sort_in_scratch(b, keys);
    for (size_t i = 0; i < keys->count; i++) to[i] = (broad_pair){(uint32_t)(keys->at[i] >> 32), (uint32_t)keys->at[i]};
    return to;
}

void broad_update(broad *b, broad_changes *changes)
{
    b->began_keys.count = b->ended_keys.count = b->unsettled.count = 0;
    order_pending(b);
    for (size_t i = 0; i < b->order.count; i++) apply_boxes(b, (uint32_t)b->order.at[i]);
    for (size_t i = 0; i < b->unsettled.count; i++) {
        const change *c = &b->pending.at[b->unsettled.at[i]];
        end_parted_pairs(b, c->proxy, c->refilter);
        begin_new_pairs(b, c->proxy);
    }
    b->pending.count = 0;

    array_reserve(&b->began, b->began_keys.count);
    array_reserve(&b->ended, b->ended_keys.count);
    *changes = (broad_changes){.began = hand_out(b, &b->began_keys, b->began.at),
        .ended = hand_out(b, &b->ended_keys, b->ended.at),
        .began_count = b->began_keys.count,
        .ended_count = b->ended_keys.count};
}

/* ---- questions ---- */

size_t broad_proxy_count(const broad *b)
{
    return b->proxy_count;
}
size_t broad_pair_count(const broad *b)
{
    return pairs_count(&b->pairs);
}

void broad_each_pair_of(const broad *b, uint32_t id, void (*visit)(void *context, uint32_t other), void *context)
{
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        visit(context, pairs_other(&b->pairs, link));
}

void broad_query_box(const broad *b, aabb box, broad_visit *visit, void *context)
{
    fbox query = fbox_inward(box);
    if (!tree_query_box(&b->moving, &query, visit, context)) return;
    if (!tree_query_box(&b->fixed, &query, visit, context)) return;
    for (size_t i = 0; i < b->unbounded.count; i++) {
        uint32_t id = b->unbounded.at[i];
        if (fbox_overlap(&query, &b->proxies.at[id].fat) && !visit(context, id)) return;
    }
}

void broad_query_ray(const broad *b, vec3 from, vec3 direction, double length, broad_visit *visit, void *context)
{
    tree_ray ray = {{from.x, from.y, from.z}, {direction.x, direction.y, direction.z}, length};
    if (!tree_query_ray(&b->moving, &ray, visit, context)) return;
    if (!tree_query_ray(&b->fixed, &ray, visit, context)) return;
    for (size_t i = 0; i < b->unbounded.count; i++) {
        uint32_t id = b->unbounded.at[i];
        if (tree_ray_meets(&ray, &b->proxies.at[id].fat) && !visit(context, id)) return;
    }
}

bool broad_peek(const broad *b, uint32_t id, broad_stored *stored)
{
    if (id >= b->proxies.count || b->proxies.at[id].place == NOWHERE) return false;
    const proxy *p = &b->proxies.at[id];
    *stored = (broad_stored){.fat = p->fat, .fixed = p->fixed, .unbounded = p->place == UNBOUNDED};
    return true;
}

/* ---- validation ---- */

static const char *validate_place(const broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    const tree *t = p->fixed ? &b->fixed : &b->moving;
    switch ((place)p->place) {
    case NOWHERE:
        return pairs_first(&b->pairs, id) == PAIRS_NO_LINK ? NULL : "a proxy that is gone has pairs";
    case UNBOUNDED:
        return p->listed < b->unbounded.count && b->unbounded.at[p->listed] == id ? NULL : "a listed proxy is lost";
    case IN_TREE:
        if (id >= t->leaf_of.count || t->leaf_of.at[id] == TREE_NONE) return "a proxy is missing from its tree";
        return fbox_equal(tree_box(t, id), &p->fat) ? NULL : "a leaf differs from the proxy's box";
    }
    return "a proxy is at no known place";
}

static const char *validate_proxy(const broad *b, uint32_t id)
{
    const char *broken = validate_place(b, id);
    for (uint32_t link = pairs_first(&b->pairs, id); !broken && link != PAIRS_NO_LINK;
         link = pairs_next(&b->pairs, link))
        if (!may_pair(&b->proxies.at[id], &b->proxies.at[pairs_other(&b->pairs, link)])) broken = "a pair has parted";
    return broken;
}

const char *broad_validate(const broad *b)
{
    const char *broken = tree_validate(&b->moving);
    if (!broken) broken = tree_validate(&b->fixed);
    if (!broken) broken = pairs_validate(&b->pairs);
    for (uint32_t id = 0; !broken && id < b->proxies.count; id++) broken = validate_proxy(b, id);
    if (broken) return broken;
    size_t kept = b->moving.leaf_count + b->fixed.leaf_count + b->unbounded.count;
    return kept == b->proxy_count ? NULL : "the count of proxies is wrong";
}
