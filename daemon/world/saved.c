/* Structs are written as they are, with what they point to behind them; a pointer is never read from bytes. Names in
 * events are those of the pair's bodies, one way round or the other. Tick thread. */
#include "saved.h"

#include "base/hash.h"
#include "events.h"
#include "geom/compound.h"
#include "match.h"
#include "soft_state.h"
#include "state.h"
#include "subscription.h"

#include <stdlib.h>

/* ---- id pools ---- */

static void put_pool(bytes_out *to, const id_pool *p)
{
    bytes_put_count(to, p->end);
    for (uint32_t id = 0; id < p->end; id++) {
        uint8_t taken = id_pool_has(p, id);
        bytes_put(to, &taken, 1);
    }
}

/* The least free one is taken first: to take some, all before them are taken for a while. */
static void get_pool(bytes_in *from, id_pool *p)
{
    size_t end = bytes_get_count(from, 1);
    const uint8_t *taken = from->at;
    from->at += end;
    from->left -= end;
    for (size_t id = 0; id < end; id++) id_pool_take(p);
    for (size_t id = 0; id < end; id++)
        if (!taken[id]) id_pool_give(p, (uint32_t)id);
}

/* ---- shapes ---- */

static void put_shape(bytes_out *to, const world_lender *l, const shape *s)
{
    shape bare = *s;
    int64_t number = s->hull || s->mesh || s->soft ? l->name_of(l->context, s) : 0;
    bare.soft = NULL;
    bare.span = NULL;
    bare.hull = NULL;
    bare.mesh = NULL;
    bare.compound = NULL;
    bytes_put(to, &bare, sizeof bare);
    bytes_put(to, &number, sizeof number);
}

static bool get_shape(bytes_in *from, const world_lender *l, shape *s)
{
    int64_t number;
    bytes_get(from, s, sizeof *s);
    s->hull = NULL;
    s->mesh = NULL;
    s->compound = NULL;
    s->soft = NULL;
    s->span = NULL;
    if (!bytes_get(from, &number, sizeof number)) return false;
    bool needs = s->type == SHAPE_HULL || s->type == SHAPE_MESH || s->type == SHAPE_SOFT;
    return needs ? l->lend(l->context, number, s) : number == 0;
}

static void put_compound(bytes_out *to, const world_lender *l, const compound *c)
{
    bytes_put_count(to, c->child_count);
    for (uint32_t i = 0; i < c->child_count; i++) {
        compound_child bare = c->children[i];
        put_shape(to, l, &bare.shape);
        bare.shape = (shape){0};
        bytes_put(to, &bare, sizeof bare);
    }
    bytes_put_count(to, c->node_count);
    bytes_put(to, c->nodes, c->node_count * sizeof *c->nodes);
}

/* Built anew, and then given the very numbers: to divide an orientation by its norm again could change its last bit. */
static compound *get_compound(bytes_in *from, const world_lender *l)
{
    size_t count = bytes_get_count(from, sizeof(compound_child));
    compound_child *children = base_zalloc(count + 1, sizeof *children);
    shape *shapes = base_zalloc(count + 1, sizeof *shapes);
    pose *locals = base_zalloc(count + 1, sizeof *locals);
    bool good = true;
    for (size_t i = 0; i < count; i++) {
        good &= get_shape(from, l, &shapes[i]);
        bytes_get(from, &children[i], sizeof children[i]);
        children[i].shape = shapes[i];
        locals[i] = children[i].local;
    }
    compound *c = NULL;
    size_t nodes = bytes_get_count(from, sizeof(compound_node));
    good = good && !from->broken && compound_build(shapes, locals, count, &c) == COMPOUND_OK && c->node_count == nodes;
    if (good) {
        memcpy(c->children, children, count * sizeof *children);
        bytes_get(from, c->nodes, nodes * sizeof *c->nodes);
    } else if (c) {
        compound_destroy(c);
        c = NULL;
    }
    free(children);
    free(shapes);
    free(locals);
    return c;
}

/* Colliders whose search has been put off, and ghosts that leave, in the order of their ids. */
typedef struct put_off {
    uint32_t collider;
    bool refiltered, leaves;
    uint64_t asked;
} put_off_collider;
typedef ARRAY(put_off_collider) unsearched;

static void put_collider(bytes_out *to, const world *w, uint32_t id, const world_lender *l)
{
    const collider *s = &w->colliders.at[id];
    collider bare = *s;
    bare.shape = (shape){0};
    bytes_put(to, &id, sizeof id);
    bytes_put(to, &bare, sizeof bare);
    if (s->ghost) { /* only waits for its id to be free, or for the end of its pairs */
        uint8_t leaves = broad_is_leaving(w->broad, id);
        broad_move last = broad_fat_box(w->broad, id);
        bytes_put(to, &leaves, 1);
        if (leaves) bytes_put(to, &last, sizeof last);
        return;
    }
    put_shape(to, l, &s->shape);
    uint8_t is_compound = s->shape.type == SHAPE_COMPOUND;
    bytes_put(to, &is_compound, 1);
    if (is_compound) put_compound(to, l, s->shape.compound);
    broad_move fat = broad_fat_box(w->broad, id);
    bytes_put(to, &fat, sizeof fat);
    uint8_t search = broad_is_unsearched(w->broad, id) ? 1 + broad_was_refiltered(w->broad, id) : 0;
    uint64_t asked = broad_asked_until(w->broad, id);
    bytes_put(to, &search, 1);
    if (search) bytes_put(to, &asked, sizeof asked);
}

static bool is_box(const aabb *box)
{
    return box->lo.x <= box->hi.x && box->lo.y <= box->hi.y && box->lo.z <= box->hi.z;
}

static void put_box(world *w, uint32_t id, const broad_move *fat)
{
    broad_put(w->broad, &(broad_move){.proxy = id, .fixed = fat->fixed, .passive = fat->passive, .box = fat->box});
}

static const char *get_collider(bytes_in *from, world *w, const world_lender *l, unsearched *put_off)
{
    uint32_t id;
    collider s;
    uint8_t is_compound = 0, search;
    broad_move fat;
    bytes_get(from, &id, sizeof id);
    if (!bytes_get(from, &s, sizeof s) || id >= w->colliders.count) return "a shape is cut off";
    s.shape = (shape){0};
    s.shape.type = SHAPE_SPHERE;
    if (s.ghost) {
        uint8_t leaves = 0;
        bytes_get(from, &leaves, 1);
        if (leaves) bytes_get(from, &fat, sizeof fat);
        if (from->broken || (leaves && !is_box(&fat.box))) return "a shape that leaves has no box";
        if (leaves) put_box(w, id, &fat);
        if (leaves) array_push(put_off, ((put_off_collider){.collider = id, .leaves = true}));
    } else {
        if (!get_shape(from, l, &s.shape)) return "a shape's hull or mesh is not there";
        bytes_get(from, &is_compound, 1);
        s.shape.compound = NULL;
        if (is_compound != (s.shape.type == SHAPE_COMPOUND)) return "a compound is none";
        if (is_compound && !(s.shape.compound = get_compound(from, l))) return "a compound cannot be built";
        bytes_get(from, &fat, sizeof fat);
        if (from->broken || !is_box(&fat.box)) {
            compound_destroy((compound *)s.shape.compound); /* it is its own */
            return "a shape has no box";
        }
        put_box(w, id, &fat);
        uint64_t asked;
        if (bytes_get(from, &search, 1) && search && bytes_get(from, &asked, sizeof asked))
            array_push(put_off, ((put_off_collider){.collider = id, .refiltered = search > 1, .asked = asked}));
    }
    w->colliders.at[id] = s;
    w->dear += !s.ghost && slices_is_dear(&s);
    return NULL;
}

/* ---- bodies ---- */

static void put_rule(bytes_out *to, const filter_rule *r)
{
    filter_rule bare = *r;
    bare.pattern = bare.reason = NULL;
    bytes_put(to, &bare, sizeof bare);
    bytes_put_text(to, r->pattern);
    bytes_put_text(to, r->reason);
}

static void get_rule(bytes_in *from, filter_rule *r)
{
    bytes_get(from, r, sizeof *r);
    r->pattern = base_strdup(bytes_get_text(from));
    r->reason = base_strdup(bytes_get_text(from));
}

static void put_body(bytes_out *to, const world *w, uint32_t id)
{
    const body *b = &w->bodies.at[id];
    body bare = *b;
    bare.name = bare.group = NULL;
    bare.shapes = NULL;
    bare.rules = NULL;
    bare.passed.at = NULL;
    bare.passed.count = bare.passed.capacity = 0;
    bare.past.at = NULL;
    bare.past.count = bare.past.capacity = 0;
    bytes_put(to, &id, sizeof id);
    bytes_put(to, &bare, sizeof bare);
    bytes_put_text(to, b->name);
    bytes_put_text(to, b->group);
    bytes_put(to, b->shapes, b->shape_count * sizeof *b->shapes);
    for (size_t i = 0; i < b->rule_count; i++) put_rule(to, &b->rules[i]);
    match_save_class(&w->match, b->match, to);
    past_save(b, to);
}

static const char *get_body(bytes_in *from, world *w)
{
    uint32_t id;
    body b;
    bytes_get(from, &id, sizeof id);
    if (!bytes_get(from, &b, sizeof b) || id >= w->bodies.count || b.shape_count > from->left ||
        b.rule_count > from->left)
        return "a body is cut off";
    b.name = base_strdup(bytes_get_text(from));
    body_set_group(&b, bytes_get_text(from));
    body_make_shapes(&w->bodies.at[id], b.ghost ? 0 : b.shape_count);
    uint32_t *shapes = w->bodies.at[id].shapes;
    if (b.ghost) b.shape_count = 0;
    bytes_get(from, shapes, b.shape_count * sizeof *shapes);
    b.shapes = shapes;
    b.only_shape = w->bodies.at[id].only_shape;
    b.rules = b.rule_count ? base_zalloc(b.rule_count, sizeof *b.rules) : NULL;
    for (size_t i = 0; i < b.rule_count; i++) get_rule(from, &b.rules[i]);
    b.match = b.rule_set = 0;
    rules_choose(&w->rules, &b.rule_set, b.rules, b.rule_count);
    match_restore_class(&w->match, &b.match, from);
    b.passed.at = NULL;
    b.passed.count = b.passed.capacity = 0;
    b.past.at = NULL;
    b.past.count = b.past.capacity = 0;
    b.as_of = NULL;
    w->bodies.at[id] = b;
    w->ccds += !b.ghost && b.ccd != WORLD_CCD_OFF;
    if (!past_restore(w, id, from)) return "a body's motions are cut off";
    if (b.ruled_tick > w->ruled_tick) w->ruled_tick = b.ruled_tick;
    if (b.teleport_tick > w->teleport_tick) w->teleport_tick = b.teleport_tick;
    if (!b.ghost) body_add_name(w, id);
    effort_restored(w, &w->bodies.at[id]);
    return from->broken ? "a body is cut off" : NULL;
}

/* ---- subscriptions ---- */

static void put_subscription(bytes_out *to, const world *w, uint32_t id)
{
    const subscription *i = &w->subscriptions.at[id];
    subscription bare = *i;
    bare.select_a = bare.select_b = NULL;
    bare.held.at = NULL;
    bare.held.count = bare.held.capacity = 0;
    bare.events.at = bare.images.at = NULL;
    bare.events.count = bare.events.capacity = 0;
    bare.images.count = bare.images.capacity = 0;
    bytes_put(to, &id, sizeof id);
    bytes_put(to, &bare, sizeof bare);
    bytes_put_text(to, i->select_a);
    bytes_put_text(to, i->select_b);
    bytes_put_count(to, i->held.count);
    bytes_put(to, i->held.at, i->held.count * sizeof *i->held.at);
}

static const char *get_subscription(bytes_in *from, world *w)
{
    uint32_t id;
    subscription i;
    bytes_get(from, &id, sizeof id);
    if (!bytes_get(from, &i, sizeof i) || id >= w->subscriptions.count) return "a subscription is cut off";
    i.select_a = base_strdup(bytes_get_text(from));
    i.select_b = base_strdup(bytes_get_text(from));
    i.held.at = NULL;
    i.held.count = i.held.capacity = 0;
    i.events.at = i.images.at = NULL;
    i.events.count = i.events.capacity = 0;
    i.images.count = i.images.capacity = 0;
    size_t held = bytes_get_count(from, sizeof *i.held.at);
    array_reserve(&i.held, held);
    bytes_get(from, i.held.at, held * sizeof *i.held.at);
    i.held.count = held;
    w->subscriptions.at[id] = i;
    return from->broken ? "a subscription is cut off" : NULL;
}

/* ---- pairs and watches ---- */

/* Of its cache what bounds begin with: with a budget they are told, and must be the other world's. The rest changes the
 * time alone. */
static narrow_cache bare_cache(const narrow_cache *c)
{
    return (narrow_cache){.axis = c->axis, .b_in_a = c->b_in_a, .lower = c->lower};
}

static void put_pair(bytes_out *to, const world *w, uint32_t id)
{
    pair bare = w->pairs.at[id];
    bare.cache = bare_cache(&w->pairs.at[id].cache);
    bytes_put(to, &id, sizeof id);
    bytes_put(to, &bare, sizeof bare);
    if (bare.has_more) bytes_put(to, pair_more_of(w, &w->pairs.at[id]), sizeof(pair_more));
}

static const char *get_pair(bytes_in *from, world *w)
{
    uint32_t id;
    pair p;
    bytes_get(from, &id, sizeof id);
    if (!bytes_get(from, &p, sizeof p) || id >= w->pairs.count || p.a >= w->colliders.count ||
        p.b >= w->colliders.count)
        return "a pair is cut off";
    p.cache = bare_cache(&p.cache);
    p.edition = 0;
    if (p.has_more && !bytes_get(from, &w->pairs_more.at[id], sizeof(pair_more))) return "a pair is cut off";
    w->pairs.at[id] = p;
    w->lingers += p.lingers;
    pair_map_put(&w->pair_of, pair_key(p.a, p.b), id);
    return NULL;
}

/* Whose names an event has is told by one bit. */
static void put_predicted(bytes_out *to, const world *w, const pair *p, const world_event *e)
{
    bool turned = e->name_a != w->bodies.at[w->colliders.at[p->a].body].name;
    world_event bare = *e;
    bare.name_a = bare.name_b = NULL;
    bytes_put(to, &turned, sizeof turned);
    bytes_put(to, &bare, sizeof bare);
}

static void get_predicted(bytes_in *from, const world *w, const pair *p, world_event *e)
{
    const char *a = w->bodies.at[w->colliders.at[p->a].body].name, *b = w->bodies.at[w->colliders.at[p->b].body].name;
    bool turned = false;
    bytes_get(from, &turned, sizeof turned);
    bytes_get(from, e, sizeof *e);
    e->name_a = turned ? b : a;
    e->name_b = turned ? a : b;
}

/* Much of what there is room for was never reported, of most watches: that is left out. */
static void put_watch(bytes_out *to, const world *w, uint32_t id)
{
    const watch *v = &w->watches.at[id];
    const last_contact *l = &w->last_contacts.at[id];
    bytes_put(to, &id, sizeof id);
    bytes_put(to, v, sizeof *v);
    if (v->has_contact) bytes_put(to, l, sizeof *l);
    if (v->has_contact) bytes_put(to, w->last_points.at[id].at, l->points * sizeof(manifold_point));
    if (v->has_predicted) put_predicted(to, w, &w->pairs.at[v->pair], &w->last_predicted.at[id]);
}

static const char *get_watch(bytes_in *from, world *w)
{
    uint32_t id;
    watch v = {.used = false};
    bytes_get(from, &id, sizeof id);
    if (!bytes_get(from, &v, sizeof v) || id >= w->watches.count || v.pair >= w->pairs.count ||
        v.subscription >= w->subscriptions.count || !w->pairs.at[v.pair].used)
        return "a watch is cut off";
    last_contact *l = &w->last_contacts.at[id];
    if (v.has_contact && (!bytes_get(from, l, sizeof *l) || l->points > MANIFOLD_POINTS_MAX))
        return "a watch is cut off";
    if (v.has_contact) bytes_get(from, w->last_points.at[id].at, l->points * sizeof(manifold_point));
    if (v.has_predicted) get_predicted(from, w, &w->pairs.at[v.pair], &w->last_predicted.at[id]);
    w->watches.at[id] = v;
    return from->broken ? "a watch is cut off" : NULL;
}

/* ---- the whole ---- */

typedef struct head {
    int64_t last_tick_ns, now_ns, serial;
    uint64_t hash, capacity, next_bound, round, ruling, due, parked, pending, past_clear, moves_before, concern_next;
    search_list waiting[SEARCH_LISTS];
    uint32_t turn, search_turn, lets_in, lets_in_next, in_parts;
    uint32_t body_serial, epoch;
    world_figures figures;
} head;

uint64_t world_saved_layout(void)
{
    enum { LISTS = 3 /* changes with which lists are behind the rest */ };
    const uint64_t all[] = {LISTS, sizeof(head), sizeof(body), sizeof(collider), sizeof(subscription), sizeof(pair),
        sizeof(watch), sizeof(shape), sizeof(compound_child), sizeof(compound_node), sizeof(broad_move), sizeof(purse),
        sizeof(payer), sizeof(past_motion), sizeof(goer), offsetof(body, past), offsetof(body, effort),
        offsetof(body, passed), offsetof(body, name), offsetof(body, searches_left), offsetof(subscription, events),
        sizeof(pair_more), offsetof(pair_more, swept_tick), offsetof(pair_more, wait_next),
        offsetof(pair_more, standing), offsetof(pair, cache), offsetof(pair, payer), offsetof(collider, shape),
        sizeof(last_contact), sizeof(world_event), offsetof(watch, has_contact)};
    return hash_bytes(HASH_START, all, sizeof all);
}

#define PUT_LIST(to, list)                                                                                             \
    (bytes_put_count((to), (list)->count), bytes_put((to), (list)->at, (list)->count * sizeof *(list)->at))
#define GET_LIST(from, list)                                                                                           \
    do {                                                                                                               \
        size_t list_count = bytes_get_count((from), sizeof *(list)->at);                                               \
        array_reserve((list), list_count + 1);                                                                         \
        bytes_get((from), (list)->at, list_count * sizeof *(list)->at);                                                \
        (list)->count = list_count;                                                                                    \
    } while (0)

#define EACH_USED(list, call)                                                                                          \
    do {                                                                                                               \
        size_t used_count = 0;                                                                                         \
        for (size_t n = 0; n < (list)->count; n++) used_count += (list)->at[n].used;                                   \
        bytes_put_count(to, used_count);                                                                               \
        for (uint32_t id = 0; id < (list)->count; id++)                                                                \
            if ((list)->at[id].used) (call);                                                                           \
    } while (0)

static bool is_whole(const world *w, uint32_t a, uint32_t b)
{
    uint32_t id = pair_find(w, a, b);
    return id != PAIR_MAP_NONE && !w->pairs.at[id].lingers;
}

/* Where searches have been put off, or not all bodies have been looked at for a subscription, the boxes do not say what
 * the pairs are: all of them are reported. */
typedef struct left_out {
    const world *w;
    uint32_t collider;
    ARRAY(uint64_t) keys;
} left_out;

static void list_left_out(void *context, uint32_t other)
{
    left_out *l = context;
    if (l->collider < other && !is_whole(l->w, l->collider, other)) array_push(&l->keys, pair_key(l->collider, other));
}

static void put_left_out(bytes_out *to, const world *w)
{
    left_out l = {.w = w};
    for (l.collider = 0; l.collider < w->colliders.count && w->figures.pairs_left_out; l.collider++)
        if (w->colliders.at[l.collider].used) broad_each_pair_of(w->broad, l.collider, list_left_out, &l);
    PUT_LIST(to, &l.keys);
    array_free(&l.keys);
}

size_t world_saved_size(const world *w)
{
    enum { TEXTS = 64, BESIDE = 32 };
    size_t a_body = sizeof(body) + TEXTS + BESIDE;
    size_t a_collider = sizeof(collider) + sizeof(shape) + sizeof(broad_move) + BESIDE;
    size_t a_watch = sizeof(watch) + sizeof(last_contact) + sizeof(world_event) + BESIDE;
    return sizeof(head) + w->bodies.count * a_body + w->colliders.count * a_collider +
           w->pairs.count * (sizeof(pair) + sizeof(pair_more) + BESIDE) + w->watches.count * a_watch +
           w->subscriptions.count * (sizeof(subscription) + TEXTS + BESIDE) +
           w->expiries.count * sizeof *w->expiries.at;
}

void world_save(const world *w, const world_lender *l, bytes_out *to)
{
    head h = {.last_tick_ns = w->last_tick_ns,
        .now_ns = w->now_ns,
        .serial = w->serial,
        .hash = w->hash,
        .capacity = w->capacity,
        .next_bound = w->next_bound,
        .round = w->round,
        .ruling = w->ruling,
        .due = w->due,
        .parked = w->parked,
        .pending = w->pending,
        .past_clear = w->past_clear,
        .turn = w->turn,
        .lets_in = w->lets_in,
        .lets_in_next = w->lets_in_next,
        .in_parts = w->in_parts,
        .moves_before = w->moves_before,
        .search_turn = w->search_turn,
        .concern_next = w->concern_next,
        .body_serial = w->body_serial,
        .epoch = w->epoch,
        .figures = w->figures};
    memcpy(h.waiting, w->waiting, sizeof h.waiting);
    bytes_put(to, &h, sizeof h);
    const id_pool *pools[] = {&w->body_ids, &w->collider_ids, &w->subscription_ids, &w->pair_ids, &w->watch_ids};
    for (int i = 0; i < 5; i++) put_pool(to, pools[i]);
    EACH_USED(&w->subscriptions, put_subscription(to, w, id));
    match_save(w, to);
    EACH_USED(&w->bodies, put_body(to, w, id));
    EACH_USED(&w->colliders, put_collider(to, w, id, l));
    EACH_USED(&w->pairs, put_pair(to, w, id));
    bool put_off = broad_unsearched_count(w->broad) || w->leaving.count;
    if (put_off || match_is_unsettled(&w->match)) put_left_out(to, w);
    EACH_USED(&w->watches, put_watch(to, w, id));
    PUT_LIST(to, &w->reap);
    PUT_LIST(to, &w->reap_colliders);
    PUT_LIST(to, &w->expiries);
    PUT_LIST(to, &w->unfinished);
    PUT_LIST(to, &w->purses);
    PUT_LIST(to, &w->payers);
    PUT_LIST(to, &w->concerned);
    PUT_LIST(to, &w->concerned_found);
    PUT_LIST(to, &w->leaving);
    PUT_LIST(to, &w->held_now);
    PUT_LIST(to, &w->unknown_due);
    PUT_LIST(to, &w->lingering); /* in the order in which their boxes parted: so they end */
    removal_save(w, to);
    soft_save(w, to);
}

/* There is room for them. */
#define MAKE_PLACES(list, pool)                                                                                        \
    do {                                                                                                               \
        memset((list)->at, 0, ((size_t)(pool)->end + 1) * sizeof *(list)->at);                                         \
        (list)->count = (pool)->end;                                                                                   \
    } while (0)

/* Ids that are written in the structs point to what is there. */
static const char *check_ids(const world *w)
{
    for (size_t i = 0; i < w->colliders.count; i++)
        if (w->colliders.at[i].used && w->colliders.at[i].body >= w->bodies.count) return "a shape has no body";
    for (size_t i = 0; i < w->bodies.count; i++)
        for (size_t k = 0; k < w->bodies.at[i].shape_count; k++)
            if (w->bodies.at[i].shapes[k] >= w->colliders.count) return "a body has no shape";
    return NULL;
}

/* The boxes are those of the other world, and so must the pairs be, but for those that were left out; `pairs`: those
 * that do not linger. */
static const char *settle_pairs(world *w, size_t pairs, size_t left_out)
{
    broad_changes changes;
    size_t missing = 0;
    broad_update(w->broad, &changes);
    if (changes.began_count != pairs + left_out) return "its pairs are not those of its boxes";
    for (size_t i = 0; i < changes.began_count; i++) missing += !is_whole(w, changes.began[i].a, changes.began[i].b);
    return missing == left_out ? NULL : "a pair is not among its pairs";
}

static const char *take_pairs(bytes_in *from, world *w, const unsearched *put_off)
{
    broad_changes none;
    ARRAY(uint64_t) keys = {0};
    bool good = true;
    GET_LIST(from, &keys);
    broad_set_limit(w->broad, 0, SIZE_MAX);
    broad_update(w->broad, &none);
    for (uint32_t id = 0; id < w->pairs.count; id++)
        if (w->pairs.at[id].used && !w->pairs.at[id].lingers)
            good &= broad_take_pair(w->broad, w->pairs.at[id].a, w->pairs.at[id].b);
    for (size_t i = 0; i < keys.count; i++)
        good &= broad_take_pair(w->broad, (uint32_t)(keys.at[i] >> 32), (uint32_t)keys.at[i]);
    for (size_t i = 0, k = 0; i < w->colliders.count; i++) {
        const put_off_collider *p = k < put_off->count && put_off->at[k].collider == i ? &put_off->at[k++] : NULL;
        if (p && p->leaves) broad_take_leaving(w->broad, (uint32_t)i);
        if (!w->colliders.at[i].used || w->colliders.at[i].ghost) continue;
        broad_take_searched(w->broad, (uint32_t)i, !p, p && p->refiltered);
        if (p) broad_take_asked(w->broad, (uint32_t)i, p->asked);
    }
    array_free(&keys);
    return good && !from->broken ? NULL : "a pair has no boxes";
}

#define GET_EACH(call)                                                                                                 \
    do {                                                                                                               \
        size_t some = bytes_get_count(from, 1);                                                                        \
        for (size_t n = 0; n < some; n++)                                                                              \
            if ((wrong = (call)) != NULL) return wrong;                                                                \
    } while (0)

static const char *restore_colliders(bytes_in *from, world *w, const world_lender *l, unsearched *put_off)
{
    const char *wrong;
    GET_EACH(get_collider(from, w, l, put_off));
    return NULL;
}

static const char *restore_pairs(bytes_in *from, world *w, size_t left_out, const unsearched *put_off)
{
    const char *wrong;
    size_t pairs = bytes_get_count(from, sizeof(pair));
    for (size_t i = 0; i < pairs; i++)
        if ((wrong = get_pair(from, w)) != NULL) return wrong;
    bool reported = put_off->count || match_is_unsettled(&w->match);
    return reported ? take_pairs(from, w, put_off) : settle_pairs(w, pairs - w->lingers, left_out);
}

const char *world_restore(world *w, const world_lender *l, bytes_in *from)
{
    head h;
    const char *wrong;
    if (!bytes_get(from, &h, sizeof h)) return "it is cut off";
    id_pool *pools[] = {&w->body_ids, &w->collider_ids, &w->subscription_ids, &w->pair_ids, &w->watch_ids};
    for (int i = 0; i < 5; i++) get_pool(from, pools[i]);
    if (from->broken) return "it is cut off";
    body_reserve(w, (size_t)w->body_ids.end + 1);
    array_reserve_in_place(&w->colliders, (size_t)w->collider_ids.end + 1);
    array_reserve(&w->subscriptions, (size_t)w->subscription_ids.end + 1);
    pair_reserve(w, (size_t)w->pair_ids.end + 1);
    watch_reserve(w, (size_t)w->watch_ids.end + 1);
    MAKE_PLACES(&w->bodies, &w->body_ids);
    MAKE_PLACES(&w->colliders, &w->collider_ids);
    MAKE_PLACES(&w->subscriptions, &w->subscription_ids);
    MAKE_PLACES(&w->pairs, &w->pair_ids);
    MAKE_PLACES(&w->watches, &w->watch_ids);
    GET_EACH(get_subscription(from, w));
    subscription_restored(w);
    if ((wrong = match_restore(w, from)) != NULL) return wrong;
    GET_EACH(get_body(from, w));
    unsearched put_off = {0};
    wrong = restore_colliders(from, w, l, &put_off);
    if (!wrong) wrong = check_ids(w);
    if (!wrong) wrong = restore_pairs(from, w, h.figures.pairs_left_out, &put_off);
    array_free(&put_off);
    if (wrong) return wrong;
    GET_EACH(get_watch(from, w));
    GET_LIST(from, &w->reap);
    GET_LIST(from, &w->reap_colliders);
    GET_LIST(from, &w->expiries);
    GET_LIST(from, &w->unfinished);
    GET_LIST(from, &w->purses);
    GET_LIST(from, &w->payers);
    payers_restored(w);
    for (size_t i = 0; i < w->pairs.count; i++)
        if (w->pairs.at[i].used && !w->pairs.at[i].lingers && w->pairs.at[i].payer >= w->payers.count)
            return "nobody is charged for a pair";
    GET_LIST(from, &w->concerned);
    GET_LIST(from, &w->concerned_found);
    GET_LIST(from, &w->leaving);
    GET_LIST(from, &w->held_now);
    GET_LIST(from, &w->unknown_due);
    GET_LIST(from, &w->lingering);
    if (w->lingering.count != w->lingers) return "pairs that linger are missing";
    for (size_t i = 0; i < w->lingering.count; i++)
        if (w->lingering.at[i] >= w->pairs.count || !w->pairs.at[w->lingering.at[i]].lingers)
            return "a pair that lingers is not there";
    for (size_t i = 0; i < w->held_now.count; i++)
        if (w->held_now.at[i] >= w->bodies.count) return "a body that is held is not there";
    for (size_t i = 0; i < w->leaving.count; i++)
        if (w->leaving.at[i] >= w->colliders.count) return "a shape that leaves is not there";
    leaving_restored(w);
    if (!removal_restore(w, from)) return "a body that is to go is not there";
    if ((wrong = soft_restore(w, from)) != NULL) return wrong;
    w->due = (size_t)h.due;
    w->parked = (size_t)h.parked;
    w->pending = h.pending;
    w->past_clear = h.past_clear;
    w->turn = h.turn;
    w->lets_in = h.lets_in != 0;
    w->lets_in_next = h.lets_in_next;
    w->in_parts = h.in_parts != 0;
    w->moves_before = h.moves_before;
    w->search_turn = h.search_turn % SEARCH_LISTS;
    w->concern_next = h.concern_next < w->bodies.count ? (size_t)h.concern_next : 0;
    memcpy(w->waiting, h.waiting, sizeof w->waiting);
    if ((wrong = impact_wait_restored(w)) != NULL) return wrong;
    w->last_tick_ns = h.last_tick_ns;
    w->now_ns = h.now_ns;
    w->serial = h.serial;
    w->hash = h.hash;
    w->capacity = h.capacity;
    w->next_bound = h.next_bound;
    w->round = h.round;
    w->ruling = h.ruling; /* decisions are found anew */
    w->body_serial = h.body_serial;
    w->epoch = h.epoch;
    w->figures = h.figures;
    settling_restored(w);
    w->changed = false;
    return from->broken ? "it is cut off" : NULL;
}
