/* shares: purses, what they hold, and what waits for them. Tick thread. */
#include "shares.h"

#include "base/hash.h"
#include "base/secret.h"
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "models.h"
#include "standby.h"
#include "vertices.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double TICK_US = 10000;   /* of expected work that a tick takes, of all together */
static const double DIRECT_US = 2000;  /* of that a purse may have before others have had their turn */
static const double DEAR_US = 10;      /* what a Client costs that waits while its purse is empty */
static const double TURN_US = 1000;    /* of what waits, before the next one's turn */
static const double LEFT_OUT_US = 0.2; /* to leave out what a client that is gone has left waiting */
static const double BURST_S = 4;       /* what may be saved up, seconds of what may be spent in one */
static const double BESIDE_POSES_US =
    5000; /* of a tick, whatever poses take of it: who floods with them stops no other */
enum {
    GREETED_BY = 10 /* characters of the operator's tool's name */,
    WAITING_MAX = 1 << 20 /* messages */,
    PURSES_IDLE = 64
};
static const char OPERATOR[] = "collidectl";

typedef enum goods { CLIENTS, BODIES, SHAPES, SUBSCRIPTIONS, GEOMETRIES, SOFT_VERTICES, GEOMETRY_BYTES, GOODS } goods;

typedef struct held {
    struct link *link;
    int64_t client, origin;
    uint64_t key; /* of the message: a copy of it need not wait, too */
    wire_kind kind;
    uint32_t life; /* of its client: if that has left since, nothing comes of it */
    uint8_t *data; /* encoded */
    size_t size;
} held;

typedef struct purse {
    uint64_t key;
    struct purse
        *parent;       /* pays, and holds, with it: all of a link where nobody is told apart; all without a session */
    double rate;       /* us a second */
    double left_us;    /* what it may spend; below 0: it owes */
    double direct_us;  /* spent in this tick without waiting */
    double factor;     /* by how much its queries take longer than their prices say, of late; at least 1 */
    int64_t filled_ns; /* monotonic */
    flow flows[2];     /* messages and poses of the second that runs */
    size_t has[GOODS]; /* of the world, and of what was admitted in this tick */
    ARRAY(held) queue;
    size_t first; /* of the queue */
    size_t bytes; /* in the queue */
    bool is_parent, is_held;
} purse;

typedef struct newcomer {
    int64_t client, origin;
} newcomer;

struct shares {
    ARRAY(purse *) purses;
    pair_map purse_of;         /* key -> place */
    size_t turn;               /* whose it is */
    ARRAY(newcomer) newcomers; /* clients that this tick begins */
    pair_map come;         /* bodies, subscriptions, geometries that were admitted in this tick: what is there then */
    pair_map waits;        /* keys of what waits, and how often it does */
    pair_map waits_of;     /* client -> messages of it that wait */
    pair_map lives;        /* client that has such -> how often it has left since the first of them came */
    size_t waiting, bytes; /* in all queues */
    size_t bodies;         /* in the world */
    size_t crowded_at;     /* so many purses: time to drop those that nobody needs */
    double left_us;        /* of this tick */
    double commands_us;    /* of it, what was admitted and is neither poses nor queries, which are elsewhere */
    double dear;           /* by how much commands take longer than their prices say, of late; at least 1 */
    bool dirty;            /* what purses have is to be counted anew */
    wire_memory *memory;
    metric *waited, *refused, *deferrals, *greeted;
    metric *waiting_now, *bytes_now, *purses_now;
};

shares *shares_create(void)
{
    shares *h = base_zalloc(1, sizeof *h);
    pair_map_init(&h->purse_of);
    pair_map_init(&h->come);
    pair_map_init(&h->waits);
    pair_map_init(&h->waits_of);
    pair_map_init(&h->lives);
    h->memory = wire_memory_create();
    h->left_us = TICK_US;
    h->dear = 1;
    h->dirty = true;
    return h;
}

static void free_purse(purse *p)
{
    for (size_t i = p->first; i < p->queue.count; i++) free(p->queue.at[i].data);
    array_free(&p->queue);
    free(p);
}

void shares_destroy(shares *h)
{
    if (!h) return;
    for (size_t i = 0; i < h->purses.count; i++) free_purse(h->purses.at[i]);
    array_free(&h->purses);
    array_free(&h->newcomers);
    pair_map_free(&h->purse_of);
    pair_map_free(&h->come);
    pair_map_free(&h->waits);
    pair_map_free(&h->waits_of);
    pair_map_free(&h->lives);
    wire_memory_destroy(h->memory);
    free(h);
}

void shares_register(shares *h, metrics *m)
{
    h->waited = metrics_add(m, "commands_waited", "messages that waited for their participant's share of work");
    h->refused = metrics_add(m, "share_refused", "messages refused because of their participant's share");
    h->deferrals = metrics_add(m, "queries_deferred", "queries that were left to the next tick");
    h->greeted = metrics_add(m, "operators_greeted", "times that collidectl was let ask without a place as a client");
    h->waiting_now = metrics_add(m, "waiting_messages", "messages that wait for their participant's share of work");
    h->purses_now = metrics_add(m, "purses", "participants, or clients where nobody is told apart, that have a share");
    h->bytes_now = metrics_add(m, "waiting_bytes", "memory that these take");
}

/* ---- purses ---- */

enum { KEY_ORIGIN = 1, KEY_CLIENT, KEY_LINK, KEY_VISITORS };

static uint64_t key_of_share(uint64_t what, uint64_t of)
{
    const uint64_t words[2] = {what, of};
    uint64_t key = hash_words(secret(), words, sizeof words);
    return key ? key : 1;
}

static purse *purse_at(service *s, uint64_t key, purse *parent, double ms)
{
    shares *h = s->shares;
    uint32_t place = pair_map_get(&h->purse_of, key);
    if (place != PAIR_MAP_NONE) return h->purses.at[place];
    purse *p = base_zalloc(1, sizeof *p);
    *p = (purse){.key = key,
        .parent = parent,
        .rate = 1e3 * ms,
        .left_us = 1e3 * ms * BURST_S,
        .factor = 1,
        .filled_ns = s->monotonic_ns};
    if (parent) parent->is_parent = true;
    pair_map_put(&h->purse_of, key, (uint32_t)h->purses.count);
    array_push(&h->purses, p);
    return p;
}

static double client_ms(const service *s)
{
    return (double)s->config.max_client_work;
}

/* Where a link knows no origin, each client has a purse, and all of the link one together, if there are others. */
static purse *purse_of(service *s, const struct link *from, int64_t origin, int64_t client)
{
    if (origin) return purse_at(s, key_of_share(KEY_ORIGIN, (uint64_t)origin), NULL, client_ms(s));
    purse *all = NULL;
    for (size_t i = 0; i < s->link_count && s->link_count > 1; i++)
        if (s->links[i] == from) all = purse_at(s, key_of_share(KEY_LINK, i), NULL, client_ms(s));
    return purse_at(s, key_of_share(KEY_CLIENT, (uint64_t)client), all, client_ms(s));
}

static bool begins_session(const wire_message *m)
{
    return (m->kind == WIRE_CLIENT && !m->client.removed) || m->kind == WIRE_GEOMETRY || m->kind == WIRE_BODY ||
           m->kind == WIRE_SUBSCRIPTION || m->kind == WIRE_VERTEX_BATCH;
}

/* Who asks without a session, or says what begins none, has no client's purse, where links know nobody. */
static purse *visitors_purse(service *s)
{
    purse *p = purse_at(s, key_of_share(KEY_VISITORS, 0), NULL, (double)s->config.max_query_work);
    p->is_parent = true;
    return p;
}

static purse *visitor(service *s, int64_t origin)
{
    purse *all = visitors_purse(s);
    double each = (double)s->config.max_query_work * (double)s->config.share / 100;
    return origin ? purse_at(s, key_of_share(KEY_VISITORS, (uint64_t)origin), all, each) : all;
}

/* An object that was admitted in this tick, or is in the world: there, with so many shapes (or bytes). */
typedef struct there {
    bool is;
    uint32_t size;
} there;

static uint64_t key_of_object(const wire_message *m, int64_t client, int64_t number)
{
    const int64_t words[3] = {m->kind, client, number};
    uint64_t key = hash_words(secret(), words, sizeof words);
    return key ? key : 1;
}

static bool came(const service *s, uint64_t key, there *t)
{
    uint32_t value = pair_map_get(&s->shares->come, key);
    if (value == PAIR_MAP_NONE) return false;
    *t = (there){value & 1, value >> 1};
    return true;
}

/* It is a client, or becomes one in this tick. */
static bool is_client(service *s, int64_t client)
{
    there now;
    uint64_t key = key_of_object(&(wire_message){.kind = WIRE_CLIENT}, client, 0);
    return session_find(s, client) || came(s, key, &now);
}

static purse *payer_of(service *s, const struct link *from, int64_t origin, const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    bool visits = !begins_session(m) && !is_client(s, client);
    return visits ? visitor(s, origin) : purse_of(s, from, origin, client);
}

/* What things take when they are there, about: as in memory.c; of a mesh ten times what is sent. */
static int64_t bytes_of_holdings(const purse *p)
{
    enum { A_BODY = 2048, A_SHAPE = 2048, AN_SUBSCRIPTION = 16384, A_BYTE_OF_GEOMETRY = 10, A_VERTEX = 1024 };
    return (int64_t)(p->has[BODIES] * A_BODY + p->has[SHAPES] * A_SHAPE + p->has[SUBSCRIPTIONS] * AN_SUBSCRIPTION +
                     p->has[SOFT_VERTICES] * A_VERTEX + p->has[GEOMETRY_BYTES] * A_BYTE_OF_GEOMETRY);
}

int64_t shares_bytes(const service *s, const struct link *from, const wire_message *m)
{
    const shares *h = s->shares;
    int64_t client, sequence, most = 0;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    uint64_t key =
        from->origin ? key_of_share(KEY_ORIGIN, (uint64_t)from->origin) : key_of_share(KEY_CLIENT, (uint64_t)client);
    uint32_t place = pair_map_get(&h->purse_of, key);
    for (const purse *p = place == PAIR_MAP_NONE ? NULL : h->purses.at[place]; p; p = p->parent)
        if (bytes_of_holdings(p) > most) most = bytes_of_holdings(p);
    return most;
}

flow *shares_flow(service *s, const struct link *from, int64_t client, shares_flow_kind kind)
{
    return &purse_of(s, from, from->origin, client)->flows[kind];
}

static void fill_purse(purse *p, int64_t now_ns)
{
    double most = p->rate * BURST_S, more = 1e-9 * (double)(now_ns - p->filled_ns) * p->rate;
    p->left_us = fmin(p->left_us + fmax(more, 0), most);
    p->filled_ns = now_ns;
}

static bool can_pay(service *s, purse *p)
{
    bool can = true;
    for (purse *at = p; at; at = at->parent) {
        fill_purse(at, s->monotonic_ns);
        can &= at->left_us > 0;
    }
    return can;
}

static void pay(purse *p, double us)
{
    for (purse *at = p; at; at = at->parent) at->left_us -= us;
}

/* A goodbye, or an older word than the newest: all that the client has is looked through. */
static double looked_through_us(service *s, const wire_message *m)
{
    static const double AN_OBJECT = 0.01;
    const session *c = m->kind == WIRE_CLIENT ? session_find(s, m->client.client) : NULL;
    bool looks = c && (m->client.removed || m->client.sequence < c->sequence);
    return looks ? AN_OBJECT * (double)(c->bodies.count + c->subscriptions.count) : 0;
}

/* A frame is all vertices of its body, whichever it names; of a frame in parts each pays for its own. */
static double frame_us(service *s, const wire_message *m)
{
    static const double A_VERTEX_KEPT = 0.02;
    if (m->kind != WIRE_VERTEX_BATCH) return 0;
    wire_soft_frame f;
    const session *c = session_find(s, m->vertex_batch.client);
    const owned_body *b = c ? session_body((session *)c, m->vertex_batch.body) : NULL;
    size_t all = b && b->world_id != WORLD_NONE ? world_soft_vertices(s->world, b->world_id) : 0;
    bool read = wire_soft_read_frame(&m->vertex_batch, &f);
    return read && all ? A_VERTEX_KEPT * ((double)all / f.parts + f.vertices) : 0;
}

static price price_for(service *s, const purse *p, const wire_message *m)
{
    price cost = price_of(m, s->shares->bodies);
    bool command = m->kind != WIRE_QUERY && m->kind != WIRE_POSE_BATCH;
    double factor = m->kind == WIRE_QUERY ? p->factor : 1, slower = command ? s->shares->dear : 1,
           more = looked_through_us(s, m) + frame_us(s, m);
    return (price){factor * slower * cost.in_tick + more, factor * cost.in_all + more};
}

/* ---- what a purse has ---- */

static const char *const names[GOODS] = {
    "clients", "bodies", "shapes", "subscriptions", "geometries", "soft_vertices", "geometry"};

static long most_of_world(const service *s, goods g)
{
    const config *c = &s->config;
    const long most[GOODS] = {c->max_clients, c->max_bodies, c->max_shapes, c->max_subscriptions, c->max_geometries,
        c->max_soft_vertices, LONG_MAX};
    return most[g];
}

/* 0: as the share says. */
static long most_of_one(const service *s, goods g)
{
    const config *c = &s->config;
    const long most[GOODS] = {0, c->max_client_bodies, c->max_client_shapes, c->max_client_subscriptions, 0, 0,
        c->max_client_geometry * (1L << 20)};
    return most[g];
}

static long share_of(const service *s, long most)
{
    long share = most == LONG_MAX ? most : (long)((double)most * (double)s->config.share / 100);
    return share < 1 ? 1 : share;
}

static long share_in(const service *s, const purse *p, goods g)
{
    return share_of(s, p->parent ? share_in(s, p->parent, g) : most_of_world(s, g));
}

static bool refuse_share(service *s, const purse *p, const purse *owner, goods g, long most, wire_refusal *why)
{
    char option[32];
    bool own = most_of_one(s, g) == most && p == owner;
    snprintf(option, sizeof option, "max_%s%s", own ? "client_" : "", names[g]);
    why->reason = WIRE_LIMIT;
    if (own)
        snprintf(why->text, sizeof why->text, "%s = %ld%s is reached by this participant, all its clients together",
            option, g == GEOMETRY_BYTES ? most >> 20 : most, g == GEOMETRY_BYTES ? " MiB" : "");
    else
        snprintf(why->text, sizeof why->text, "%s: %ld of %ld are the share of %s; the rest stays free for others",
            option, most, most_of_world(s, g),
            p == owner ? "one participant, all its clients together" : "all by this link, which tells nobody apart");
    apply_name_limit(s, option);
    metric_count(s->shares->refused, 1);
    return false;
}

/* May it have so many more? */
static bool may_have(service *s, const purse *owner, goods g, size_t more, wire_refusal *why)
{
    if (!more) return true;
    for (const purse *p = owner; p; p = p->parent) {
        long most = share_in(s, p, g), own = most_of_one(s, g);
        if (p == owner && own && own < most) most = own;
        if (s->config.share == 100 && !(p == owner && own)) continue; /* the world's own limit says so */
        if (p->has[g] + more > (size_t)most) return refuse_share(s, p, owner, g, most, why);
    }
    return true;
}

static void give(purse *p, goods g, size_t more, size_t less)
{
    for (; p; p = p->parent) p->has[g] = p->has[g] + more > less ? p->has[g] + more - less : 0;
}

static void comes(service *s, uint64_t key, there t)
{
    pair_map_put(&s->shares->come, key, (t.size << 1 | t.is) & (UINT32_MAX >> 1));
    s->shares->dirty = true;
}

static bool admit_body(service *s, purse *p, session *c, const wire_message *m, wire_refusal *why)
{
    const wire_body *b = &m->body;
    const owned_body *had = c ? session_body(c, b->body) : NULL;
    uint64_t key = key_of_object(m, b->client, b->body);
    there now = {had && had->world_id != WORLD_NONE, had ? had->shapes : 0};
    if (had && b->sequence <= had->sequence) return true; /* a late copy changes nothing */
    (void)came(s, key, &now);
    uint32_t had_shapes = now.is ? now.size : 0, shapes = b->removed ? 0 : b->shape_types.count;
    size_t soft = vertices_of_body(s, b), had_soft = had && now.is ? had->soft : 0;
    bool fits = may_have(s, p, BODIES, !now.is && !b->removed, why) &&
                may_have(s, p, SHAPES, shapes > had_shapes ? shapes - had_shapes : 0, why) &&
                may_have(s, p, SOFT_VERTICES, soft > had_soft ? soft - had_soft : 0, why);
    if (!fits) return false;
    give(p, SOFT_VERTICES, soft, had_soft);
    give(p, BODIES, !now.is && !b->removed, now.is && b->removed);
    give(p, SHAPES, shapes, had_shapes);
    comes(s, key, (there){!b->removed, shapes});
    return true;
}

static bool admit_subscription(service *s, purse *p, session *c, const wire_message *m, wire_refusal *why)
{
    const wire_subscription *i = &m->subscription;
    const owned_subscription *had = c ? session_subscription(c, i->subscription) : NULL;
    uint64_t key = key_of_object(m, i->client, i->subscription);
    there now = {had && had->live, 0};
    if (had && i->sequence <= had->sequence) return true;
    (void)came(s, key, &now);
    if (!may_have(s, p, SUBSCRIPTIONS, !now.is && !i->removed, why)) return false;
    give(p, SUBSCRIPTIONS, !now.is && !i->removed, now.is && i->removed);
    comes(s, key, (there){!i->removed, 0});
    return true;
}

/* Charged as a whole with whichever piece comes first. */
static bool admit_geometry(service *s, purse *p, const wire_message *m, wire_refusal *why)
{
    const wire_geometry *g = &m->geometry;
    uint64_t key = key_of_object(m, g->client, g->hash);
    int64_t id = geometry_claimed(s, g->client, g->hash);
    there now = {id != 0, 0};
    (void)came(s, key, &now);
    size_t bytes = g->removed || now.is ? 0 : (size_t)geometry_bytes(g->vertex_numbers, g->index_numbers);
    bool fits = may_have(s, p, GEOMETRIES, !now.is && !g->removed, why) && may_have(s, p, GEOMETRY_BYTES, bytes, why);
    if (!fits) return false;
    give(p, GEOMETRIES, !now.is && !g->removed, now.is && g->removed);
    const geometry *had = g->removed ? geometry_at(s, id) : NULL;
    give(p, GEOMETRY_BYTES, bytes,
        had ? (size_t)geometry_bytes((int64_t)had->vertex_numbers, (int64_t)had->index_numbers) : 0);
    comes(s, key, (there){!g->removed, 0});
    return true;
}

static bool admit_client(service *s, purse *p, int64_t client, int64_t origin, const wire_message *m, wire_refusal *why)
{
    shares *h = s->shares;
    uint64_t key = key_of_object(&(wire_message){.kind = WIRE_CLIENT}, client, 0);
    if (m->kind == WIRE_CLIENT) h->dirty = true; /* it may leave, or be back */
    if (!begins_session(m) || is_client(s, client)) return true;
    if (!may_have(s, p, CLIENTS, 1, why)) return false;
    give(p, CLIENTS, 1, 0);
    comes(s, key, (there){true, 0});
    array_push(&h->newcomers, ((newcomer){client, origin}));
    return true;
}

static void spend(shares *h, const wire_message *m, double us)
{
    if (m->kind != WIRE_POSE_BATCH && m->kind != WIRE_QUERY) h->commands_us += us;
    double least = m->kind == WIRE_POSE_BATCH ? fmin(h->left_us, BESIDE_POSES_US) : -INFINITY;
    h->left_us = fmax(h->left_us - us, least);
}

/* It goes to the world now, and counts, if its purse has room. */
static bool admit(service *s, purse *p, const struct link *from, const wire_message *m, wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    session *c = session_find(s, client);
    if (!admit_client(s, p, client, from->origin, m, why)) return false;
    if (m->kind == WIRE_BODY && !admit_body(s, p, c, m, why)) return false;
    if (m->kind == WIRE_SUBSCRIPTION && !admit_subscription(s, p, c, m, why)) return false;
    if (m->kind == WIRE_GEOMETRY && !admit_geometry(s, p, m, why)) return false;
    price cost = price_for(s, p, m);
    pay(p, cost.in_all);
    spend(s->shares, m, cost.in_tick);
    if (c) c->spent_us += cost.in_all;
    if (c && m->kind != WIRE_QUERY) c->origin = from->origin; /* anybody may ask in any name */
    return true;
}

/* ---- counting anew ---- */

static void count_session(service *s, const session *c)
{
    const size_t has[GOODS] = {1, c->body_count, c->shape_count, c->subscription_count, c->geometry_count,
        c->soft_vertices, (size_t)c->geometry_bytes};
    purse *own = purse_of(s, c->link, c->origin, c->client);
    for (purse *p = own; p; p = p->parent)
        for (int g = 0; g < GOODS; g++) p->has[g] += has[g];
    own->is_held = true;
}

/* Who has nothing, waits for nothing and owes nothing needs no purse. */
static void drop_idle(service *s)
{
    shares *h = s->shares;
    for (size_t i = h->purses.count; i-- > 0;) {
        purse *p = h->purses.at[i], *last = h->purses.at[h->purses.count - 1];
        fill_purse(p, s->monotonic_ns);
        if (p->is_held || p->is_parent || p->queue.count || p->left_us < p->rate * BURST_S) continue;
        pair_map_remove(&h->purse_of, p->key);
        h->purses.at[i] = last;
        h->purses.count--;
        if (last != p) pair_map_put(&h->purse_of, last->key, (uint32_t)i);
        free_purse(p);
    }
}

/* Who is refused may have got one, each time under another name, and with nothing taken there is no tick. */
static void drop_some_idle(service *s)
{
    enum { MANY_IDLE = 4096 };
    shares *h = s->shares;
    if (h->purses.count < h->crowded_at) return;
    drop_idle(s);
    h->crowded_at = 2 * h->purses.count + MANY_IDLE;
    metric_set(h->purses_now, h->purses.count);
}

static void count_anew(service *s)
{
    shares *h = s->shares;
    for (size_t i = 0; i < h->newcomers.count; i++) {
        session *c = session_find(s, h->newcomers.at[i].client);
        if (c) c->origin = h->newcomers.at[i].origin;
    }
    h->newcomers.count = 0;
    for (size_t i = 0; i < h->purses.count; i++) {
        memset(h->purses.at[i]->has, 0, sizeof h->purses.at[i]->has);
        h->purses.at[i]->is_held = false;
    }
    for (size_t i = 0; i < s->sessions.count; i++) count_session(s, s->sessions.at[i]);
    if (h->come.count) {
        pair_map_free(&h->come);
        pair_map_init(&h->come);
    }
    h->dirty = false;
    drop_idle(s);
}

void shares_ticked(service *s)
{
    shares *h = s->shares;
    if (s->replaying || standby_waits(s)) return;
    if (h->dirty || h->purses.count > s->sessions.count + PURSES_IDLE) count_anew(s);
    h->bodies = world_get_figures(s->world).bodies;
    metric_set(h->purses_now, h->purses.count);
    h->left_us = TICK_US;
    h->commands_us = 0;
    for (size_t i = 0; i < h->purses.count; i++) h->purses.at[i]->direct_us = 0;
}

/* ---- what waits ---- */

static void count_waiting(shares *h)
{
    metric_set(h->waiting_now, h->waiting);
    metric_set(h->bytes_now, h->bytes);
}

static bool refuse_waiting(service *s, const wire_message *m, const purse *p, wire_refusal *why)
{
    const purse *visitors = visitors_purse(s);
    bool visits = p == visitors || p->parent == visitors;
    why->reason = WIRE_LIMIT;
    snprintf(why->text, sizeof why->text,
        "max_waiting: %zu messages wait for this participant's share of work (%s = %ld ms/s); %s is refused: send it "
        "later",
        p->queue.count - p->first, visits ? "max_query_work" : "max_client_work",
        visits ? s->config.max_query_work : s->config.max_client_work, wire_kind_name(m->kind));
    apply_name_limit(s, visits ? "max_query_work" : "max_waiting");
    metric_count(s->shares->refused, 1);
    return false;
}

/* 0 of who is not in it. */
static uint32_t count_in(const pair_map *m, int64_t client)
{
    uint32_t count = client ? pair_map_get(m, (uint64_t)client) : PAIR_MAP_NONE;
    return count == PAIR_MAP_NONE ? 0 : count;
}

/* Who comes again after he has left may count from 1 again. */
static uint64_t key_of_message(const shares *h, const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    const uint64_t words[2] = {key_of_object(m, client, sequence), count_in(&h->lives, client)};
    uint64_t key = hash_words(secret(), words, sizeof words);
    return key ? key : 1;
}

static held hold_message(shares *h, struct link *from, int64_t client, const wire_message *m)
{
    held l = {.link = from,
        .client = client,
        .origin = from->origin,
        .key = key_of_message(h, m),
        .life = count_in(&h->lives, client),
        .kind = m->kind,
        .size = wire_lcm_size(m)};
    uint32_t before = pair_map_get(&h->waits, l.key);
    l.data = base_alloc(l.size, 1);
    l.size = wire_lcm_encode(m, l.data, l.size);
    pair_map_put(&h->waits, l.key, before == PAIR_MAP_NONE ? 1 : before + 1);
    pair_map_put(&h->waits_of, (uint64_t)client, count_in(&h->waits_of, client) + 1);
    return l;
}

static void forget_held(shares *h, const held *l)
{
    uint32_t times = pair_map_remove(&h->waits, l->key), left = count_in(&h->waits_of, l->client) - 1;
    if (times != PAIR_MAP_NONE && times > 1) pair_map_put(&h->waits, l->key, times - 1);
    if (left) {
        pair_map_put(&h->waits_of, (uint64_t)l->client, left);
    } else {
        pair_map_remove(&h->waits_of, (uint64_t)l->client);
        pair_map_remove(&h->lives, (uint64_t)l->client);
    }
}

/* Who is not acknowledged sends it again (LCM), and may do so while it waits. */
static bool is_copy(service *s, const wire_message *m)
{
    bool keeps = m->kind == WIRE_GEOMETRY || m->kind == WIRE_BODY || m->kind == WIRE_SUBSCRIPTION;
    bool copy = keeps && pair_map_get(&s->shares->waits, key_of_message(s->shares, m)) != PAIR_MAP_NONE;
    if (copy) metric_count(s->count.duplicates, 1);
    return copy;
}

static bool wait(service *s, purse *p, struct link *from, int64_t client, const wire_message *m, wire_refusal *why)
{
    shares *h = s->shares;
    size_t size = wire_lcm_size(m), most = (size_t)s->config.max_waiting << 20;
    session_heard(s, m);
    if (is_copy(s, m)) return true;
    bool full = p->bytes + size > (size_t)share_of(s, (long)most) || h->bytes + size > most ||
                p->queue.count - p->first >= (size_t)share_of(s, WAITING_MAX) || h->waiting >= WAITING_MAX;
    if (full) return refuse_waiting(s, m, p, why);
    array_push(&p->queue, hold_message(h, from, client, m));
    p->bytes += size;
    h->bytes += size;
    h->waiting++;
    metric_count(h->waited, 1);
    count_waiting(h);
    return true;
}

static void drop_first(shares *h, purse *p)
{
    held *l = &p->queue.at[p->first++];
    free(l->data);
    forget_held(h, l);
    p->bytes -= l->size;
    h->bytes -= l->size;
    h->waiting--;
    if (p->first == p->queue.count) {
        p->first = p->queue.count = 0;
    } else if (p->first > 1024 && p->first > p->queue.count / 2) {
        p->queue.count -= p->first;
        memmove(p->queue.at, p->queue.at + p->first, p->queue.count * sizeof *p->queue.at);
        p->first = 0;
    }
}

static bool open_held(service *s, const held *l, wire_message *m)
{
    wire_refusal why;
    wire_memory_reset(s->shares->memory);
    l->link->origin = l->origin;
    return wire_lcm_decode(l->data, l->size, s->shares->memory, m, &why) == WIRE_OK;
}

static void refuse_held(service *s, const held *l, const wire_message *m, const wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    apply_reject(s, l->link, m->kind, client, sequence, object, why);
}

/* The price of what went, or below 0: nothing goes. */
static double pass_first(service *s, purse *p)
{
    shares *h = s->shares;
    held l = p->queue.at[p->first];
    wire_message m;
    wire_refusal why;
    bool gone = l.life != count_in(&h->lives, l.client);
    if (!gone && l.kind != WIRE_POSE_BATCH && !can_pay(s, p)) return -1;
    double before = h->left_us;
    if (gone || !open_held(s, &l, &m)) {
        h->left_us -= LEFT_OUT_US;
    } else if (admit(s, p, l.link, &m, &why)) {
        service_take(s, l.link, &m);
    } else {
        refuse_held(s, &l, &m, &why);
    }
    drop_first(h, p);
    return before - h->left_us;
}

static bool take_turn(service *s, purse *p)
{
    double spent = 0;
    bool some = false;
    while (p->first < p->queue.count && spent < TURN_US && s->shares->left_us > 0) {
        double cost = pass_first(s, p);
        if (cost < 0) break;
        spent += cost;
        some = true;
    }
    return some;
}

static void clear(shares *h)
{
    for (size_t i = 0; i < h->purses.count; i++)
        while (h->purses.at[i]->first < h->purses.at[i]->queue.count) drop_first(h, h->purses.at[i]);
    count_waiting(h);
}

void shares_release(service *s)
{
    shares *h = s->shares;
    if (s->replaying || !h->waiting) return;
    if (standby_waits(s)) { /* what it owes is the active one's business */
        clear(h);
        return;
    }
    for (size_t idle = 0; h->waiting && h->left_us > 0 && idle < h->purses.count;) {
        purse *p = h->purses.at[h->turn++ % h->purses.count];
        idle = take_turn(s, p) ? 0 : idle + 1;
    }
    count_waiting(h);
}

double shares_expected_us(const service *s)
{
    return s->shares->commands_us;
}

/* Prices are those of a quick machine that has memory to give. Where others use the processor's caches, or the host of
 * a virtual machine has yet to find the memory, a tick takes fewer commands. What they pay stays the same. */
static const double LEARN_FROM_US = 1000, DEAREST = 16, FORGET = 0.1;

bool shares_learn(const service *s)
{
    return !s->replaying && s->shares->commands_us >= LEARN_FROM_US;
}

void shares_carried_out(service *s, int64_t took_ns)
{
    shares *h = s->shares;
    double ratio = h->dear * 1e-3 * (double)took_ns / h->commands_us;
    h->dear = fmin(fmax(1, fmax(ratio, h->dear + FORGET * (ratio - h->dear))), DEAREST);
}

bool shares_want_tick(const service *s)
{
    const shares *h = s->shares;
    return h->waiting && h->left_us < TICK_US;
}

static double seconds_until_paid(const purse *p)
{
    double wait_s = 0;
    for (; p; p = p->parent)
        if (p->left_us <= 0 && p->rate > 0) wait_s = fmax(wait_s, -p->left_us / p->rate + 1e-6);
    return wait_s;
}

int64_t shares_next_ns(const service *s)
{
    const shares *h = s->shares;
    if (s->replaying || !h->waiting || (h->left_us <= 0 && s->config.rate > 0)) return INT64_MAX;
    double next_s = 1;
    for (size_t i = 0; i < h->purses.count; i++)
        if (h->purses.at[i]->queue.count) next_s = fmin(next_s, seconds_until_paid(h->purses.at[i]));
    return s->monotonic_ns + (int64_t)(1e9 * next_s);
}

void shares_forget(service *s, int64_t client)
{
    shares *h = s->shares;
    h->dirty = true;
    bool waits = count_in(&h->waits_of, client) > 0; /* each of these is left out when its turn comes */
    if (waits) pair_map_put(&h->lives, (uint64_t)client, count_in(&h->lives, client) + 1);
}

/* ---- what comes ---- */

/* Poses of bodies that are there do not wait: they have rates of their own, and the newest wins. */
static bool is_known(service *s, const wire_message *m)
{
    session *c = session_find(s, m->pose_batch.client);
    bool known = c != NULL;
    for (uint32_t i = 0; known && i < m->pose_batch.bodies.count; i++)
        known = session_body(c, m->pose_batch.bodies.at[i]) != NULL;
    return known && models_are_known(c, &m->pose_batch);
}

static bool must_wait(service *s, purse *p, const wire_message *m)
{
    shares *h = s->shares;
    bool some_wait = p->first < p->queue.count;
    if (m->kind == WIRE_CLIENT) return looked_through_us(s, m) > DEAR_US && (!can_pay(s, p) || h->left_us <= 0);
    if (m->kind == WIRE_POSE_BATCH) return some_wait && !is_known(s, m);
    if (some_wait || !can_pay(s, p) || h->left_us <= 0 || p->direct_us >= DIRECT_US) return true;
    p->direct_us += price_for(s, p, m).in_tick;
    return false;
}

/* The operator's tool must be able to ask in any crowd. It is let in by its name, which anybody may take: what it gets
 * is an acknowledgement, which costs nobody a place. */
static bool greet(service *s, struct link *from, const wire_message *m)
{
    if (m->kind != WIRE_CLIENT || m->client.removed || session_find(s, m->client.client)) return false;
    if (strncmp(m->client.name, OPERATOR, GREETED_BY) != 0) return false;
    const wire_message ack = {
        .kind = WIRE_ACK, .ack = {WIRE_VERSION, m->client.client, s->epoch, .sequences = {1, &m->client.sequence}}};
    from->ops->publish(from, &ack);
    metric_count(s->shares->greeted, 1);
    return true;
}

/* Its own share is the reason, or that of all is used up. */
static void refuse_place(service *s, struct link *from, int64_t client, wire_refusal *why)
{
    if (may_have(s, purse_of(s, from, from->origin, client), CLIENTS, 1, why))
        apply_limit(s, (size_t)s->config.max_clients, s->config.max_clients, "max_clients", why);
}

shares_verdict shares_admit(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    if (s->replaying) return SHARES_GO;
    wire_origin(m, &client, &sequence, &object);
    if (!client) return SHARES_GO; /* refused where it is carried out */
    drop_some_idle(s);
    bool is_new = begins_session(m) && !session_find(s, client);
    bool no_place = is_new && (s->sessions.count >= (size_t)s->config.max_clients || from->unclaimed);
    if (no_place && greet(s, from, m)) return SHARES_DONE;
    if (no_place) {
        refuse_place(s, from, client, why);
        return SHARES_REFUSED;
    }
    purse *p = payer_of(s, from, from->origin, m);
    if (must_wait(s, p, m)) return wait(s, p, from, client, m, why) ? SHARES_WAIT : SHARES_REFUSED;
    if (admit(s, p, from, m, why)) return SHARES_GO;
    return is_new && greet(s, from, m) ? SHARES_DONE : SHARES_REFUSED;
}

/* ---- queries ---- */

void shares_answered(service *s, const command *l, const wire_message *m, int64_t took_ns)
{
    if (s->replaying) return;
    session *c = session_find(s, l->client);
    purse *p = payer_of(s, l->link, l->origin, m);
    double took_us = 1e-3 * (double)took_ns, more = took_us - price_for(s, p, m).in_all;
    double ratio = took_us / price_of(m, s->shares->bodies).in_all;
    p->factor = fmax(1, fmax(ratio, 0.9 * p->factor + 0.1 * ratio));
    if (!(more > 0)) return;
    pay(p, more);
    if (c) c->spent_us += more;
}

/* What is put back often, one after the other, is not to move the whole queue each time: room for more is made. */
static void put_first(purse *p, held first)
{
    enum { ROOM = 1024 };
    if (p->first == p->queue.count) p->first = p->queue.count = 0;
    if (p->first == 0) {
        array_reserve(&p->queue, p->queue.count + ROOM);
        memmove(p->queue.at + ROOM, p->queue.at, p->queue.count * sizeof *p->queue.at);
        p->queue.count += ROOM;
        p->first = ROOM;
    }
    p->queue.at[--p->first] = first;
}

void shares_defer(service *s, const command *l, const wire_message *m)
{
    shares *h = s->shares;
    purse *p = payer_of(s, l->link, l->origin, m);
    l->link->origin = l->origin;
    held first = hold_message(h, l->link, l->client, m);
    pay(p, -price_for(s, p, m).in_all);
    put_first(p, first);
    p->bytes += first.size;
    h->bytes += first.size;
    h->waiting++;
    metric_count(h->deferrals, 1);
}
