/* session: clients, what is theirs, and what becomes of it when they are lost. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "models.h"
#include "service.h"
#include "streams.h"
#include "vertices.h"

#include "base/log.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { REMOVED_KEPT = 4096 }; /* removed bodies (subscriptions) that a session remembers, against late copies */
enum { REMINDERS = 8 };       /* a lost client that comes back hears of it at most so often */

session *session_find(service *s, int64_t client)
{
    uint32_t index = client ? pair_map_get(&s->session_of, (uint64_t)client) : PAIR_MAP_NONE; /* 0: nobody */
    return index == PAIR_MAP_NONE ? NULL : s->sessions.at[index];
}

/* How many bodies and subscriptions it had, the last time; 0: it was not lost. */
static uint32_t had_when_lost(const service *s, int64_t client)
{
    for (size_t i = s->lost_count; i-- > 0 && s->lost_count - i <= LOST_KEPT;)
        if (s->lost_clients[i % LOST_KEPT].client == client) return s->lost_clients[i % LOST_KEPT].had;
    return 0;
}

void session_remember_left(service *s, int64_t client, int64_t sequence)
{
    for (size_t i = 0; i < LOST_KEPT; i++) {
        left_client *l = &s->left_clients[i];
        if (l->client != client) continue;
        if (sequence > l->sequence) *l = (left_client){client, sequence, s->monotonic_ns};
        return;
    }
    s->left_clients[s->left_count++ % LOST_KEPT] = (left_client){client, sequence, s->monotonic_ns};
}

int64_t session_left_at(service *s, int64_t client)
{
    const session *c = session_find(s, client);
    if (c) return c->left_sequence;
    for (size_t i = 0; i < LOST_KEPT && s->left_count; i++) {
        const left_client *l = &s->left_clients[i];
        if (l->client == client) return s->monotonic_ns - l->since_ns < LATE_NS ? l->sequence : 0;
    }
    return 0;
}

/* A client is known from its first message on, whichever this is: topics have no order among each other. Its Client
 * message fills in name, lease and wishes. */
session *session_get(service *s, int64_t client, struct link *from)
{
    session *c = session_find(s, client);
    if (!c && s->sessions.count >= (size_t)s->config.max_clients) return NULL;
    if (!c) {
        int64_t left = session_left_at(s, client);
        c = base_zalloc(1, sizeof *c);
        c->client = client;
        c->left_sequence = left;
        c->name = base_strdup("");
        c->lease_ns = (int64_t)(s->config.lease * 1e9);
        c->commands_tick = -1;
        c->had = had_when_lost(s, client);
        c->reminders = REMINDERS;
        pair_map_init(&c->body_of);
        pair_map_init(&c->subscription_of);
        pair_map_init(&c->pending_of);
        pair_map_init(&c->pending_needs);
        pair_map_init(&c->claim_of);
        pair_map_put(&s->session_of, (uint64_t)client, (uint32_t)s->sessions.count);
        array_push(&s->sessions, c);
    }
    c->link = from;
    c->last_seen_ns = s->monotonic_ns;
    return c;
}

void session_heard(service *s, const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    session *c = session_find(s, client);
    if (c) c->last_seen_ns = s->monotonic_ns;
}

owned_body *session_body(session *c, int32_t number)
{
    uint32_t index = pair_map_get(&c->body_of, (uint64_t)number + 1);
    return index == PAIR_MAP_NONE ? NULL : &c->bodies.at[index];
}

/* Removed bodies make room for new ones once there are many. */
static void forget_removed(session *c)
{
    size_t kept = 0;
    if (c->bodies.count - c->body_count < REMOVED_KEPT) return;
    pair_map_free(&c->body_of);
    pair_map_init(&c->body_of);
    for (size_t i = 0; i < c->bodies.count; i++) {
        owned_body *b = &c->bodies.at[i];
        if (b->world_id == WORLD_NONE) {
            array_free(&b->geometries);
            continue;
        }
        pair_map_put(&c->body_of, (uint64_t)b->number + 1, (uint32_t)kept);
        c->rows.numbers.at[kept] = b->number;
        c->rows.world_ids.at[kept] = b->world_id;
        c->rows.sequences.at[kept] = c->rows.sequences.at[i];
        c->bodies.at[kept++] = *b;
    }
    c->bodies.count = c->rows.numbers.count = c->rows.world_ids.count = c->rows.sequences.count = kept;
}

void session_add_row(session *c, int32_t number, uint32_t world_id, int64_t pose_sequence)
{
    array_push_long(&c->rows.numbers, number);
    array_push_long(&c->rows.world_ids, world_id);
    array_push_long(&c->rows.sequences, pose_sequence);
}

owned_body *session_add_body(session *c, int32_t number)
{
    if (c->bodies.count % REMOVED_KEPT == REMOVED_KEPT - 1) forget_removed(c);
    pair_map_put(&c->body_of, (uint64_t)number + 1, (uint32_t)c->bodies.count);
    array_push_long(&c->bodies, ((owned_body){.number = number, .world_id = WORLD_NONE}));
    session_add_row(c, number, WORLD_NONE, 0);
    return &c->bodies.at[c->bodies.count - 1];
}

/* Its place in the world (WORLD_NONE: it has none any more), and how many shapes it has there. */
void session_count_body(session *c, owned_body *b, uint32_t world_id, size_t shapes)
{
    c->body_count += (size_t)(world_id != WORLD_NONE) - (size_t)(b->world_id != WORLD_NONE);
    c->shape_count += shapes - b->shapes;
    if (world_id == WORLD_NONE) {
        model_destroy(b->model);
        b->model = NULL;
    }
    c->soft_vertices -= b->soft;
    b->soft = 0;
    b->world_id = c->rows.world_ids.at[b - c->bodies.at] = world_id;
    b->shapes = (uint32_t)shapes;
}

void session_find_subscriptions(session *c)
{
    pair_map_free(&c->subscription_of);
    pair_map_init(&c->subscription_of);
    for (size_t i = 0; i < c->subscriptions.count; i++)
        pair_map_put(&c->subscription_of, (uint64_t)(uint32_t)c->subscriptions.at[i].number + 1, (uint32_t)i);
}

/* As with bodies: removed ones are remembered for a while only. */
owned_subscription *session_add_subscription(session *c, int32_t number)
{
    size_t kept = 0;
    if (c->subscriptions.count % REMOVED_KEPT == REMOVED_KEPT - 1) {
        for (size_t i = 0; i < c->subscriptions.count; i++)
            if (c->subscriptions.at[i].live) c->subscriptions.at[kept++] = c->subscriptions.at[i];
        c->subscriptions.count = kept;
        session_find_subscriptions(c);
    }
    pair_map_put(&c->subscription_of, (uint64_t)(uint32_t)number + 1, (uint32_t)c->subscriptions.count);
    array_push(&c->subscriptions, (owned_subscription){.number = number});
    return &c->subscriptions.at[c->subscriptions.count - 1];
}

owned_subscription *session_subscription(session *c, int32_t number)
{
    uint32_t index = pair_map_get(&c->subscription_of, (uint64_t)(uint32_t)number + 1);
    return index == PAIR_MAP_NONE ? NULL : &c->subscriptions.at[index];
}

int64_t session_newest_sequence(const session *c)
{
    int64_t newest = c->ended > c->sequence ? c->ended : c->sequence;
    if (c->geometry_sequence > newest) newest = c->geometry_sequence;
    for (size_t i = 0; i < c->bodies.count; i++) {
        const owned_body *b = &c->bodies.at[i];
        if (b->sequence > newest) newest = b->sequence;
        int64_t pose = c->rows.sequences.at[i];
        if (pose > newest && pose != STEP_IN_ITS_NAME) newest = pose;
    }
    for (size_t i = 0; i < c->subscriptions.count; i++)
        if (c->subscriptions.at[i].sequence > newest) newest = c->subscriptions.at[i].sequence;
    return newest;
}

/* ---- the end of a session ---- */

static void end_body(service *s, session *c, owned_body *b, uint8_t cause)
{
    if (b->world_id == WORLD_NONE) return;
    world_remove_soon(s->world, b->world_id, cause);
    for (size_t k = 0; k < b->geometries.count; k++) geometry_release(s, b->geometries.at[k]);
    b->geometries.count = 0;
    session_count_body(c, b, WORLD_NONE, 0);
}

static void end_bodies(service *s, session *c, uint8_t cause)
{
    for (size_t i = 0; i < c->bodies.count; i++) end_body(s, c, &c->bodies.at[i], cause);
}

/* The entries stay, so that late copies do not bring back what nobody would end: who leaves bodies behind has no lease
 * that could run out. */
static void end_subscriptions(service *s, session *c, uint8_t cause)
{
    for (size_t i = 0; i < c->subscriptions.count; i++) {
        owned_subscription *at = &c->subscriptions.at[i];
        if (at->live) stream_end(s, at->world_id, cause);
        at->live = false;
    }
    c->subscription_count = 0;
}

static void free_session(session *c)
{
    for (size_t i = 0; i < c->bodies.count; i++) {
        array_free(&c->bodies.at[i].geometries);
        model_destroy(c->bodies.at[i].model);
    }
    array_free_long(&c->bodies);
    array_free_long(&c->rows.numbers);
    array_free_long(&c->rows.world_ids);
    array_free_long(&c->rows.sequences);
    array_free(&c->subscriptions);
    array_free(&c->acks);
    steps_free(c);
    array_free(&c->claims);
    pair_map_free(&c->claim_of);
    pair_map_free(&c->body_of);
    pair_map_free(&c->subscription_of);
    pair_map_free(&c->pending_of);
    pair_map_free(&c->pending_needs);
    free(c->name);
    free(c);
}

static void forget(service *s, session *c)
{
    pending_forget(s, c->client, INT64_MAX);
    vertices_forget(s, c->client);
    uint32_t index = pair_map_remove(&s->session_of, (uint64_t)c->client);
    session *last = s->sessions.at[--s->sessions.count];
    if (last != c) {
        s->sessions.at[index] = last;
        pair_map_put(&s->session_of, (uint64_t)last->client, index);
    }
    geometry_forget(s, c);
    free_session(c);
}

size_t session_bodies(const session *c)
{
    size_t bodies = 0;
    for (size_t i = 0; i < c->bodies.count; i++) bodies += c->bodies.at[i].world_id != WORLD_NONE;
    return bodies;
}

/* Should it live after all (this process stood still, a network was down), it announces everything again. */
static void report_lost(service *s, session *c, const char *how)
{
    wire_message m = {.kind = WIRE_REJECT,
        .reject = {WIRE_VERSION, c->client, .epoch = s->epoch, .kind = WIRE_CLIENT, .object = -1,
            .reason = WIRE_UNKNOWN_CLIENT, .text = how}};
    c->link->ops->publish(c->link, &m);
}

static bool has_said_all_again(const session *c)
{
    uint32_t said = 0;
    for (size_t i = 0; i < c->bodies.count; i++) {
        const owned_body *b = &c->bodies.at[i];
        said += b->world_id != WORLD_NONE && b->sequence > c->lost_at;
    }
    for (size_t i = 0; i < c->subscriptions.count; i++)
        said += c->subscriptions.at[i].live && c->subscriptions.at[i].sequence > c->lost_at;
    return said >= c->had;
}

/* The Reject above is said once, and over LCM, or to one that cannot be reached just then, it may not arrive: the
 * client would keep its lease by heartbeats, and wait for its streams, and for what its fixed bodies meet, for ever. So
 * it is told again, a few times, until it has as much as it had: to announce something does not show that it knows, be
 * it new, or of a body whose poses were refused. */
void session_remind(service *s, session *c, wire_kind kind)
{
    if (kind != WIRE_CLIENT || !c->reminders || !c->announced || c->lost) return; /* its first word leads the others */
    if (has_said_all_again(c)) c->reminders = 0;
    if (!c->reminders) return;
    c->reminders--;
    report_lost(s, c, "it was lost, and is heard again");
}

/* Its subscriptions end with it; its bodies are removed, held or kept, as it said. */
void session_lost(service *s, session *c, const char *how)
{
    if (c->lost) return;
    log_notice("client %016" PRIx64 " \"%s\" is lost (%s): its %zu bodies are %s", (uint64_t)c->client, c->name, how,
        c->bodies.count,
        c->on_loss == WIRE_LOST_REMOVE ? "removed"
        : c->on_loss == WIRE_LOST_HOLD ? "held"
                                       : "kept");
    metric_count(s->count.clients_lost, 1);
    report_lost(s, c, how);
    bool knows = has_said_all_again(c); /* of the loss before, if there was one */
    uint32_t has = (uint32_t)(session_bodies(c) + c->subscription_count);
    if (knows || has > c->had) c->had = has;
    c->lost_at = session_newest_sequence(c);
    s->lost_clients[s->lost_count++ % LOST_KEPT] = (lost_client){c->client, c->had};
    steps_join(s, c, 0);
    end_subscriptions(s, c, CAUSE_OWNER_LOST);
    if (c->on_loss == WIRE_LOST_REMOVE || !(session_bodies(c) || c->pending_of.count)) {
        end_bodies(s, c, CAUSE_OWNER_LOST);
        forget(s, c);
        return;
    }
    c->lost = true;
    c->reminders = REMINDERS;
    if (c->on_loss == WIRE_LOST_HOLD)
        for (size_t i = 0; i < c->bodies.count; i++)
            if (c->bodies.at[i].world_id != WORLD_NONE) world_hold_body(s->world, c->bodies.at[i].world_id);
}

/* It left in order: nothing is held, but KEEP keeps. */
void session_leave(service *s, session *c)
{
    if (c->left) return;
    log_info("client %016" PRIx64 " \"%s\" left", (uint64_t)c->client, c->name);
    steps_join(s, c, 0);
    end_subscriptions(s, c, CAUSE_SUBSCRIPTION);
    if (c->on_loss == WIRE_LOST_KEEP && (session_bodies(c) || c->pending_of.count)) {
        c->lost = c->left = true;
        return;
    }
    end_bodies(s, c, CAUSE_REMOVED);
    forget(s, c);
}

void session_leave_before(service *s, session *c, int64_t sequence)
{
    for (size_t i = 0; i < c->subscriptions.count; i++) {
        owned_subscription *at = &c->subscriptions.at[i];
        if (!at->live || at->sequence >= sequence) continue;
        stream_end(s, at->world_id, CAUSE_SUBSCRIPTION);
        c->subscription_count--;
        at->live = false;
    }
    for (size_t i = 0; i < c->bodies.count && c->on_loss != WIRE_LOST_KEEP; i++) {
        owned_body *b = &c->bodies.at[i];
        bool before = b->sequence < sequence && *session_pose_sequence(c, b) < sequence;
        if (before) end_body(s, c, b, CAUSE_REMOVED);
    }
    if (c->on_loss != WIRE_LOST_KEEP) pending_forget(s, c->client, sequence);
}

/* ---- leases ---- */

/* The transport itself watches those that have announced themselves where it can; the others have to be heard. */
static bool by_heartbeat(const session *c)
{
    return !c->lost && !(c->announced && c->link->ops->has_liveliness);
}

void session_check_leases(service *s)
{
    for (size_t i = s->sessions.count; i-- > 0;) {
        session *c = s->sessions.at[i];
        if (!by_heartbeat(c) || s->monotonic_ns - c->last_seen_ns <= c->lease_ns) continue;
        inbox_put_lost(s, c->link, c->client);
        c->last_seen_ns = s->monotonic_ns; /* once, although it may wait for the next tick */
    }
}

int64_t session_next_lease_ns(const service *s)
{
    int64_t next = INT64_MAX;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        int64_t end;
        if (by_heartbeat(c) && !__builtin_add_overflow(c->last_seen_ns, c->lease_ns, &end) && end < next) next = end;
    }
    return next;
}

/* ---- acknowledgements ---- */

void session_ack(session *c, int64_t sequence)
{
    array_push(&c->acks, sequence);
}

static void send_acks(service *s, session *c, size_t first, size_t count)
{
    wire_message m = {.kind = WIRE_ACK,
        .ack = {WIRE_VERSION, c->client, s->epoch, .sequences = {(uint32_t)count, c->acks.at + first}}};
    c->link->ops->publish(c->link, &m);
}

void session_send_acks(service *s)
{
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (!c->acks.count) continue;
        for (size_t first = 0; first < c->acks.count; first += WIRE_POSES_MAX)
            send_acks(s, c, first, c->acks.count - first < WIRE_POSES_MAX ? c->acks.count - first : WIRE_POSES_MAX);
        metric_count(s->count.acks, c->acks.count);
        c->acks.count = 0;
    }
}

void session_free_all(service *s)
{
    for (size_t i = 0; i < s->sessions.count; i++) free_session(s->sessions.at[i]);
    array_free(&s->sessions);
    pair_map_free(&s->session_of);
}
