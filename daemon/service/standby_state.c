/* The state of a daemon between two ticks, for a standby, or a recording, that begins: clients, streams, geometries,
 * what waits for its hull, and the world (world/saved.h). Structs are written as they are, with what they point to
 * behind them; links by their place: a replay has one for all. Tick thread. */
#include "base/hash.h"
#include "clients.h"
#include "commands.h"
#include "geom/mesh.h"
#include "geometries.h"
#include "models.h"
#include "recordings.h"
#include "standby_parts.h"
#include "streams.h"
#include "vertices.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct state_head {
    char release[32];
    uint64_t layout; /* of what is written as it lies: another build is told */
    int64_t epoch, tick, now_ns, monotonic_ns, latest_pose_ns;
    uint64_t events_hash, links;
    step_mark latest_step;
    simulation_mark simulation;
    lock_step lock_step;
    int64_t wall_ahead_ns, last_batch;
    lost_client lost_clients[LOST_KEPT];
    uint64_t lost_count, left_count;
    left_client left_clients[LOST_KEPT];
    bool hull_came, geometries_loose, whole, budgeted;
    int64_t geometry_last;
} state_head;

static uint64_t layout_here(void)
{
    const uint64_t all[7] = {sizeof(session), sizeof(stream), sizeof(geometry), sizeof(geometry_claim),
        sizeof(pending_body), sizeof(owned_body), world_saved_layout()};
    return hash_bytes(HASH_START, all, sizeof all);
}

static struct link *link_at(const service *s, uint64_t place)
{
    if (s->replaying) return s->links[0];
    return place < s->link_count ? s->links[place] : NULL;
}

#define NO_ARRAY(a) ((a)->at = NULL, (a)->count = (a)->capacity = 0)
#define PUT_ARRAY(to, a) (bytes_put_count((to), (a)->count), bytes_put((to), (a)->at, (a)->count * sizeof *(a)->at))
#define GET_ARRAY(from, a)                                                                                             \
    do {                                                                                                               \
        NO_ARRAY(a);                                                                                                   \
        size_t array_count = bytes_get_count((from), sizeof *(a)->at);                                                 \
        array_reserve((a), array_count + 1);                                                                           \
        bytes_get((from), (a)->at, array_count * sizeof *(a)->at);                                                     \
        (a)->count = array_count;                                                                                      \
    } while (0)

/* ---- clients ---- */

static void put_session(const service *s, const session *c, bytes_out *to)
{
    session bare = *c;
    bare.name = NULL;
    bare.link = NULL;
    NO_ARRAY(&bare.held.bytes);
    NO_ARRAY(&bare.owed);
    NO_ARRAY(&bare.held.digests.list);
    NO_ARRAY(&bare.done.list);
    NO_ARRAY(&bare.bodies);
    NO_ARRAY(&bare.subscriptions);
    NO_ARRAY(&bare.acks);
    NO_ARRAY(&bare.claims);
    bare.rows = (pose_rows){.next = 0};
    bare.claim_of = bare.body_of = bare.pending_of = bare.pending_needs = (pair_map){0};
    bare.pending_bytes = 0;
    bare.pending_count = 0;
    bytes_put(to, &bare, sizeof bare);
    bytes_put_text(to, c->name);
    bytes_put_count(to, standby_place_of(s, c->link));
    PUT_ARRAY(to, &c->held.bytes);
    PUT_ARRAY(to, &c->owed);
    PUT_ARRAY(to, &c->held.digests.list);
    PUT_ARRAY(to, &c->done.list);
    bytes_put_count(to, c->bodies.count);
    for (size_t i = 0; i < c->bodies.count; i++) {
        owned_body b = c->bodies.at[i];
        NO_ARRAY(&b.geometries);
        b.model = NULL;
        bytes_put(to, &b, sizeof b);
        bytes_put(to, &c->rows.sequences.at[i], sizeof c->rows.sequences.at[i]);
        PUT_ARRAY(to, &c->bodies.at[i].geometries);
        wire_u8s robot = model_extensions(c->bodies.at[i].model);
        PUT_ARRAY(to, &robot);
    }
    PUT_ARRAY(to, &c->subscriptions);
    PUT_ARRAY(to, &c->claims);
}

static void confirm(service *s, const session *c)
{
    if (!s->standby) return;
    kept *k = &s->standby->kept;
    wire_message m = {.kind = WIRE_CLIENT, .client = {.client = c->client, .sequence = c->sequence}};
    kept_confirm(k, &m);
    for (size_t i = 0; i < c->bodies.count; i++) {
        const owned_body *b = &c->bodies.at[i];
        m = (wire_message){.kind = WIRE_BODY, .body = {.client = c->client, .sequence = b->sequence}};
        kept_confirm(k, &m);
        m = (wire_message){
            .kind = WIRE_POSE_BATCH, .pose_batch = {.client = c->client, .sequence = c->rows.sequences.at[i]}};
        kept_confirm(k, &m);
    }
    for (size_t i = 0; i < c->subscriptions.count; i++) {
        m = (wire_message){.kind = WIRE_SUBSCRIPTION,
            .subscription = {.client = c->client, .sequence = c->subscriptions.at[i].sequence}};
        kept_confirm(k, &m);
    }
}

static bool get_robot(bytes_in *from, owned_body *b)
{
    ARRAY(uint8_t) bytes = {0};
    wire_refusal why;
    GET_ARRAY(from, &bytes);
    bool good = !from->broken && model_of((wire_u8s){(uint32_t)bytes.count, bytes.at}, &b->model, &why) == WIRE_OK;
    array_free(&bytes);
    return good;
}

static const char *get_session(service *s, bytes_in *from)
{
    session *c = base_zalloc(1, sizeof *c);
    bytes_get(from, c, sizeof *c);
    c->name = base_strdup(bytes_get_text(from));
    NO_ARRAY(&c->bodies);
    c->rows = (pose_rows){.next = 0};
    NO_ARRAY(&c->subscriptions);
    NO_ARRAY(&c->acks);
    NO_ARRAY(&c->claims);
    NO_ARRAY(&c->held.bytes);
    NO_ARRAY(&c->owed);
    NO_ARRAY(&c->held.digests.list);
    NO_ARRAY(&c->done.list);
    pair_map_init(&c->claim_of);
    pair_map_init(&c->body_of);
    pair_map_init(&c->subscription_of);
    pair_map_init(&c->pending_of);
    pair_map_init(&c->pending_needs);
    array_push(&s->sessions, c); /* from here on it is freed with the others */
    uint64_t link;
    bytes_get(from, &link, sizeof link);
    c->link = link_at(s, link);
    if (from->broken || !c->link || !c->client) return "a client is cut off";
    pair_map_put(&s->session_of, (uint64_t)c->client, (uint32_t)(s->sessions.count - 1));
    GET_ARRAY(from, &c->held.bytes);
    GET_ARRAY(from, &c->owed);
    GET_ARRAY(from, &c->held.digests.list);
    GET_ARRAY(from, &c->done.list);
    size_t bodies = bytes_get_count(from, sizeof(owned_body));
    for (size_t i = 0; i < bodies; i++) {
        owned_body b;
        int64_t pose_sequence;
        bytes_get(from, &b, sizeof b);
        bytes_get(from, &pose_sequence, sizeof pose_sequence);
        GET_ARRAY(from, &b.geometries);
        if (!get_robot(from, &b)) return "a robot is not one";
        pair_map_put(&c->body_of, (uint64_t)b.number + 1, (uint32_t)i);
        array_push_long(&c->bodies, b);
        session_add_row(c, b.number, b.world_id, pose_sequence);
    }
    GET_ARRAY(from, &c->subscriptions);
    session_find_subscriptions(c);
    GET_ARRAY(from, &c->claims);
    for (size_t i = 0; i < c->claims.count; i++)
        if (c->claims.at[i].hash) pair_map_put(&c->claim_of, (uint64_t)c->claims.at[i].hash, (uint32_t)i);
    confirm(s, c);
    return from->broken ? "a client is cut off" : NULL;
}

/* ---- streams ---- */

static void put_stream(const service *s, const stream *at, bytes_out *to)
{
    stream bare = *at;
    bare.name = NULL;
    bare.link = NULL;
    bare.view = NULL;
    bare.backlog = (backlog){.anew = false}; /* whose reader will say what it lacks */
    bytes_put(to, &bare, sizeof bare);
    if (!at->live) return;
    bytes_put_text(to, at->name);
    bytes_put_count(to, standby_place_of(s, at->link));
}

/* Its readers find it at once, long before it has to tell anything. */
static const char *get_stream(service *s, bytes_in *from)
{
    stream at;
    uint64_t link;
    bytes_get(from, &at, sizeof at);
    at.name = NULL;
    at.link = NULL;
    at.view = NULL;
    if (at.live) {
        const char *name = bytes_get_text(from);
        bytes_get(from, &link, sizeof link);
        at.link = link_at(s, link);
        if (from->broken || !at.link) return "a stream is cut off";
        at.name = base_strdup(name);
        at.link->ops->stream_open(at.link, at.name, at.client);
    }
    array_push(&s->streams, at);
    s->scenes += at.live && at.scene;
    if (at.live) stream_names_add(s, (uint32_t)(s->streams.count - 1));
    return from->broken ? "a stream is cut off" : NULL;
}

/* ---- geometries ---- */

static void put_geometry(const geometry *g, state_parts *all)
{
    bytes_out *to = &all->own;
    geometry bare = *g;
    bare.numbers = NULL;
    bare.build = NULL;
    bare.vertices = NULL;
    bare.indices = NULL;
    bare.hull = NULL;
    bare.mesh = NULL;
    bare.has = NULL;
    uint8_t comes = g->has != NULL;
    bytes_put(to, &bare, sizeof bare);
    bytes_put(to, &comes, 1);
    if (comes) bytes_put(to, g->has, (size_t)g->pieces);
    state_parts_borrow(all, g->numbers, g->has, (size_t)g->pieces);
}

static const char *get_geometry(service *s, bytes_in *from)
{
    geometry g;
    uint8_t comes;
    wire_refusal why = {0};
    bytes_get(from, &g, sizeof g);
    bytes_get(from, &comes, 1);
    bool fits = !from->broken && g.pieces > 0 && g.vertex_numbers <= from->left / sizeof(double) &&
                g.index_numbers <= from->left / sizeof(int32_t) && (size_t)g.pieces <= from->left + 1;
    if (!fits) return "a geometry is cut off";
    g.hull = NULL;
    g.mesh = NULL;
    g.soft = NULL;
    g.build = NULL;
    g.has = comes ? base_zalloc((size_t)g.pieces, 1) : NULL;
    g.numbers = geometry_numbers_create(g.kind, g.hash, g.vertex_numbers, g.index_numbers);
    g.vertices = g.numbers->vertices;
    g.indices = g.numbers->indices;
    if (g.completed > s->geometries_completed) s->geometries_completed = g.completed;
    if (comes) bytes_get(from, g.has, (size_t)g.pieces);
    bytes_get(from, g.vertices, g.vertex_numbers * sizeof *g.vertices);
    bytes_get(from, g.indices, g.index_numbers * sizeof *g.indices);
    if (!from->broken && geometry_restore(s, &g, &why) == WIRE_OK) return NULL;
    free(g.has);
    geometry_numbers_release(g.numbers);
    return "a geometry cannot be built";
}

/* ---- what waits for a hull ---- */

static void put_pending(const service *s, const pending_body *p, bytes_out *to)
{
    pending_body bare = *p;
    bare.link = NULL;
    bare.name = NULL;
    NO_ARRAY(&bare.hashes);
    NO_ARRAY(&bare.bytes);
    bytes_put(to, &bare, sizeof bare);
    bytes_put_count(to, standby_place_of(s, p->link));
    bytes_put_text(to, p->name);
    PUT_ARRAY(to, &p->hashes);
    PUT_ARRAY(to, &p->bytes);
}

static const char *get_pending(service *s, bytes_in *from)
{
    pending_body p;
    uint64_t link;
    if (!bytes_get(from, &p, sizeof p) || !bytes_get(from, &link, sizeof link)) return "a message is cut off";
    p.link = link_at(s, link);
    p.name = base_strdup(bytes_get_text(from));
    GET_ARRAY(from, &p.hashes);
    GET_ARRAY(from, &p.bytes);
    pending_restore(s, &p);
    return from->broken || !p.link ? "a message is cut off" : NULL;
}

/* ---- the world's hulls and meshes, by their ids ---- */

typedef struct naming {
    const service *s;
    pair_map place_of; /* where a hull or a mesh lies -> its place among the geometries */
} naming;

static uint64_t key_of(const void *built)
{
    return (uint64_t)(uintptr_t)built;
}

static void begin_naming(naming *n, const service *s)
{
    *n = (naming){.s = s};
    pair_map_init(&n->place_of);
    for (size_t i = s->geometries.count; i-- > 0;) { /* the first of several has the last word */
        const geometry *g = &s->geometries.at[i];
        if (g->id && g->mesh) pair_map_put(&n->place_of, key_of(g->mesh), (uint32_t)i);
        if (g->id && g->soft) pair_map_put(&n->place_of, key_of(g->soft), (uint32_t)i);
        if (g->id && g->hull) pair_map_put(&n->place_of, key_of(g->hull), (uint32_t)i);
    }
}

static int64_t name_of(const void *context, const shape *of)
{
    const naming *n = context;
    const void *built = of->mesh ? (const void *)of->mesh : of->soft ? (const void *)of->soft : of->hull;
    uint32_t place = built ? pair_map_get(&n->place_of, key_of(built)) : PAIR_MAP_NONE;
    return place == PAIR_MAP_NONE ? 0 : n->s->geometries.at[place].id;
}

static bool lend(const void *context, int64_t id, shape *to)
{
    const geometry *g = geometry_at(context, id);
    if (!g) return false;
    to->mesh = g->mesh;
    to->hull = g->mesh ? g->mesh->hull : g->hull;
    to->soft = g->soft;
    if (to->type == SHAPE_SOFT) return to->soft != NULL;
    return to->hull != NULL && (to->type == SHAPE_MESH) == (g->mesh != NULL);
}

/* ---- the whole ---- */

void state_put(service *s, state_parts *all)
{
    bytes_out *to = &all->own;
    state_head h = {.layout = layout_here(),
        .epoch = s->epoch,
        .tick = s->tick,
        .now_ns = s->now_ns,
        .monotonic_ns = s->monotonic_ns,
        .latest_pose_ns = s->latest_pose_ns,
        .events_hash = s->events_hash,
        .links = s->link_count,
        .latest_step = s->latest_step,
        .simulation = s->simulation,
        .lock_step = s->lock_step,
        .wall_ahead_ns = s->wall_ahead_ns,
        .last_batch = s->last_batch,
        .lost_count = s->lost_count,
        .left_count = s->left_count,
        .whole = s->whole,
        .budgeted = s->config.budget_us > 0,
        .hull_came = s->hull_came,
        .geometries_loose = s->geometries_loose,
        .geometry_last = s->geometry_last};
    size_t used = 0;
    snprintf(h.release, sizeof h.release, "%s", health_release());
    memcpy(h.lost_clients, s->lost_clients, sizeof h.lost_clients);
    memcpy(h.left_clients, s->left_clients, sizeof h.left_clients);
    bytes_put(to, &h, sizeof h);
    for (size_t i = 0; i < s->geometries.count; i++) used += s->geometries.at[i].id != 0;
    bytes_put_count(to, used);
    for (size_t i = 0; i < s->geometries.count; i++)
        if (s->geometries.at[i].id) put_geometry(&s->geometries.at[i], all);
    bytes_put_count(to, s->sessions.count);
    for (size_t i = 0; i < s->sessions.count; i++) put_session(s, s->sessions.at[i], to);
    bytes_put_count(to, s->streams.count);
    for (size_t i = 0; i < s->streams.count; i++) put_stream(s, &s->streams.at[i], to);
    bytes_put_count(to, s->pending.count);
    for (size_t i = 0; i < s->pending.count; i++) put_pending(s, &s->pending.at[i], to);
    vertices_save(s, to);
    naming names;
    begin_naming(&names, s);
    world_save(s->world, &(world_lender){.context = &names, .name_of = name_of}, to);
    pair_map_free(&names.place_of);
    state_parts_end(all);
}

size_t state_size(const service *s)
{
    size_t size = sizeof(state_head) + world_saved_size(s->world) + s->inbox.bytes.count +
                  s->streams.count * (sizeof(stream) + WIRE_NAME_MAX);
    size += s->geometries.count * sizeof(geometry);
    for (size_t i = 0; i < s->sessions.count; i++)
        size += sizeof(session) + s->sessions.at[i]->held.bytes.count +
                s->sessions.at[i]->bodies.count * (sizeof(owned_body) + 2 * sizeof(int64_t)) +
                s->sessions.at[i]->claims.count * sizeof(geometry_claim);
    return size;
}

bool state_fits(const uint8_t *bytes, size_t size, char *why, size_t why_size)
{
    state_head h = {.release = ""};
    memcpy(&h, bytes, size < sizeof h ? size : sizeof h);
    h.release[sizeof h.release - 1] = '\0';
    bool released = strcmp(h.release, health_release()) == 0;
    if (released && h.layout == layout_here() && size >= sizeof h) return true;
    if (released)
        snprintf(why, why_size, "it is of another build of release %s", h.release);
    else
        snprintf(why, why_size, "it is of release %s, and this is %s", h.release, health_release());
    return false;
}

static const char *take_all(service *s, bytes_in *from)
{
    state_head h;
    const char *wrong = NULL;
    if (!bytes_get(from, &h, sizeof h)) return "it is cut off";
    if (h.links != s->link_count && !s->replaying) return "its links are others: both need the same configuration";
    s->epoch = h.epoch;
    s->tick = h.tick;
    s->latest_pose_ns = s->measured_pose_ns = h.latest_pose_ns;
    s->events_hash = h.events_hash;
    s->latest_step = h.latest_step;
    s->simulation = h.simulation;
    s->lock_step = h.lock_step;
    s->wall_ahead_ns = h.wall_ahead_ns;
    if (s->standby)
        s->standby->ahead_ns = h.now_ns - s->monotonic_ns;
    else
        s->now_ns = h.now_ns, s->monotonic_ns = h.monotonic_ns; /* what comes next in a recording came then */
    s->last_batch = h.last_batch;
    memcpy(s->lost_clients, h.lost_clients, sizeof s->lost_clients);
    s->lost_count = (size_t)h.lost_count;
    memcpy(s->left_clients, h.left_clients, sizeof s->left_clients);
    s->left_count = (size_t)h.left_count;
    s->whole = h.whole;
    const char *(*const parts[])(service *, bytes_in *) = {get_geometry, get_session, get_stream, get_pending};
    for (int i = 0; i < 4; i++) {
        size_t count = bytes_get_count(from, 1);
        for (size_t k = 0; k < count; k++)
            if ((wrong = parts[i](s, from)) != NULL) return wrong;
    }
    if ((wrong = vertices_restore(s, from)) != NULL) return wrong;
    geometry_restore_builds(s);
    s->hull_came = h.hull_came;
    s->geometries_loose = h.geometries_loose;
    s->geometry_last = h.geometry_last;
    const world_lender lender = {.context = s, .lend = lend};
    service_replay_budget(s, h.budgeted, 0); /* before the world knows what ticks can do */
    return world_restore(s->world, &lender, from);
}

bool state_take(service *s, bytes_in *from, char *why, size_t why_size)
{
    if (!state_fits(from->at, from->left, why, why_size)) return false;
    const char *wrong = take_all(s, from);
    if (wrong) snprintf(why, why_size, "%s", wrong);
    return !wrong;
}
