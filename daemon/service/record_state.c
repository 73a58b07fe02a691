/* record_state: the world as messages: what clients have announced and not taken back, with the newest poses. A
 * recording that begins in the middle begins with it. Tick thread. */
#include "body_message.h"
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "recordings.h"
#include "service.h"

#include "base/clock.h"

#include <stdlib.h>

static void report_geometry(service *s, const geometry *g, int64_t client)
{
    for (int32_t piece = 0; piece < g->pieces; piece++) {
        if (g->has && !g->has[piece]) continue; /* the recording will see it come */
        geometry_share share = geometry_share_of(g, piece);
        wire_message m = {.kind = WIRE_GEOMETRY,
            .geometry = {.version = WIRE_VERSION,
                .client = client,
                .sequence = 1,
                .kind = g->kind,
                .hash = g->hash,
                .vertex_numbers = (int32_t)g->vertex_numbers,
                .index_numbers = (int32_t)g->index_numbers,
                .piece = piece,
                .pieces = g->pieces,
                .vertices = {(uint32_t)share.vertices, g->vertices + share.first_vertex},
                .indices = {(uint32_t)share.indices, g->indices + share.first_index}}};
        record_message(s, &m);
    }
}

static void report_taken_back(service *s, const geometry_claim *c)
{
    const wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = c->sequence,
            .removed = 1,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = c->hash,
            .pieces = 1}};
    record_message(s, &m);
}

/* Late copies of what was before do not bring it back, here as there. */
static void report_removed_body(service *s, const session *c, const owned_body *b)
{
    const wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = b->sequence,
            .body = b->number,
            .removed = 1,
            .name = "",
            .group = ""}};
    record_message(s, &m);
}

static void report_removed_subscription(service *s, const session *c, const owned_subscription *i)
{
    const wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = i->sequence,
            .subscription = i->number,
            .removed = 1,
            .stream = "",
            .select_a = "",
            .select_b = ""}};
    record_message(s, &m);
}

/* Older poses that come late do not count: the number of the one that it has is told with that. */
static void report_pose(service *s, session *c, const owned_body *b, const world_body *def, const double pose[7])
{
    int64_t sequence = *session_pose_sequence(c, b);
    const uint8_t teleport = 1;
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = sequence,
            .stamp_ns = def->stamp_ns,
            .bodies = {1, &b->number},
            .positions = {3, pose},
            .orientations = {4, pose + 3},
            .teleports = {1, &teleport}}};
    if (sequence > b->sequence && sequence != STEP_IN_ITS_NAME) record_message(s, &m);
}

static void report_body(service *s, session *c, const owned_body *b, body_columns *scratch)
{
    world_body def;
    if (b->world_id == WORLD_NONE) report_removed_body(s, c, b);
    if (b->world_id == WORLD_NONE || world_get_body(s->world, b->world_id, &def, scratch->shapes) != WORLD_OK) return;
    wire_message m = body_message_of(s, c->client, b, &def, scratch);
    record_message(s, &m);
    report_pose(s, c, b, &def, scratch->pose);
}

static void report_subscription(service *s, const session *c, const owned_subscription *i)
{
    world_subscription def;
    if (!i->live) report_removed_subscription(s, c, i);
    if (!i->live || world_get_subscription(s->world, i->world_id, &def) != WORLD_OK) return;
    const stream *to = &s->streams.at[i->world_id];
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = i->sequence,
            .subscription = i->number,
            .facts = to->scene ? WIRE_FACT_SCENE : (int32_t)def.facts | (to->tells_poses ? WIRE_FACT_POSES : 0),
            .stream = to->name,
            .select_a = to->scene ? to->scene_select : def.select_a,
            .select_b = to->scene ? "*" : def.select_b,
            .threshold_m = def.threshold,
            .range_m = def.range,
            .tolerance_m = def.tolerance,
            .relative_tolerance = def.relative_tolerance,
            .hysteresis_m = def.hysteresis,
            .accuracy = (uint8_t)def.accuracy,
            .horizon_s = def.horizon,
            .rate_hz = def.period_ns ? 1e9 / (double)def.period_ns : 0}};
    record_message(s, &m);
}

static void report_kept_pose(service *s, const pending_body *p)
{
    const uint8_t teleport = 1;
    const kept_pose *k = &p->pose;
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = p->client,
            .sequence = k->sequence,
            .stamp_ns = k->stamp_ns,
            .bodies = {1, &p->body},
            .positions = {3, k->position},
            .orientations = {4, k->orientation},
            .linear = {k->has_linear ? 3 : 0, k->linear},
            .angular = {k->has_angular ? 3 : 0, k->angular},
            .teleports = {1, &teleport}}};
    if (k->sequence) record_message(s, &m);
}

/* Bodies that wait for their hulls. */
static void report_waiting_bodies(service *s)
{
    wire_memory *memory = wire_memory_create();
    for (size_t i = 0; i < s->pending.count; i++) {
        const pending_body *p = &s->pending.at[i];
        wire_message m;
        wire_refusal why;
        wire_memory_reset(memory);
        if (wire_lcm_decode(p->bytes.at, p->bytes.count, memory, &m, &why) == WIRE_OK) record_message(s, &m);
        report_kept_pose(s, p);
    }
    wire_memory_destroy(memory);
}

/* Clients that left so short a time ago that copies of what they said may yet come: each comes, and leaves. */
static void report_left(service *s)
{
    for (size_t i = 0; i < LOST_KEPT; i++) {
        const left_client *l = &s->left_clients[i];
        bool late = s->monotonic_ns - l->since_ns < LATE_NS && !session_find(s, l->client);
        wire_message m = {.kind = WIRE_CLIENT,
            .client = {
                .version = WIRE_VERSION, .client = l->client, .sequence = l->sequence, .lease_ns = 1, .name = ""}};
        for (uint8_t leaves = 0; leaves < 2 && late && l->client; leaves++) {
            m.client.removed = leaves;
            record_message(s, &m);
        }
    }
}

/* What the bodies of a client hold, though it has taken it back: each once. */
static void report_held(service *s, const session *c)
{
    pair_map reported;
    pair_map_init(&reported);
    for (size_t k = 0; k < c->bodies.count; k++)
        for (size_t n = 0; n < c->bodies.at[k].geometries.count; n++) {
            const geometry *g = geometry_at(s, c->bodies.at[k].geometries.at[n]);
            bool claimed = geometry_claimed(s, c->client, g->hash) == g->id;
            if (claimed || pair_map_get(&reported, (uint64_t)g->id) != PAIR_MAP_NONE) continue;
            pair_map_put(&reported, (uint64_t)g->id, 0);
            report_geometry(s, g, c->client);
        }
    pair_map_free(&reported);
}

static bool time_is_up(int64_t until_ns)
{
    return until_ns != INT64_MAX && clock_monotonic_ns() >= until_ns;
}

/* From the one on that follows what was reported last: claims come and go meanwhile, but keep their order. True: all of
 * them were told. */
static bool report_claimed(service *s, const session *c, int64_t until_ns)
{
    record_telling *t = &s->record_telling;
    uint32_t last = t->hash ? pair_map_get(&c->claim_of, (uint64_t)t->hash) : PAIR_MAP_NONE;
    for (size_t k = last == PAIR_MAP_NONE ? 0 : last + 1; k < c->claims.count; k++) {
        const geometry_claim *claim = &c->claims.at[k];
        const geometry *g = claim->geometry ? geometry_at(s, claim->geometry) : NULL;
        if (!g) continue;
        t->hash = claim->hash;
        report_geometry(s, g, c->client);
        if (g->is_building) record_build(s, c->client, g->hash, false);
        if (time_is_up(until_ns)) return false;
    }
    return true;
}

/* What is claimed meanwhile is recorded already. */
static void report_geometries(service *s, int64_t until_ns)
{
    record_telling *t = &s->record_telling;
    for (; t->next < t->clients.count; t->next++, t->hash = 0) {
        const session *c = session_find(s, t->clients.at[t->next]); /* NULL: gone since */
        if (c && !report_claimed(s, c, until_ns)) return;
    }
    for (size_t i = 0; i < s->sessions.count; i++) report_held(s, s->sessions.at[i]);
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        for (size_t k = 0; k < c->claims.count; k++)
            if (!c->claims.at[k].geometry && c->claims.at[k].sequence) report_taken_back(s, &c->claims.at[k]);
    }
    t->next = 0;
    t->geometries_reported = true;
}

size_t record_state_size(const service *s)
{
    enum { A_MESSAGE = 512, A_BODY = 640, A_SHAPE = 128 };
    size_t size = A_MESSAGE * s->streams.count + s->inbox.bytes.count;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        size += A_MESSAGE + A_BODY * c->bodies.count + A_SHAPE * c->shape_count + c->held.bytes.count +
                (size_t)(c->geometry_bytes + c->geometry_bytes / 16);
    }
    return size;
}

static wire_message greeting_of(const session *c)
{
    return (wire_message){.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = c->sequence ? c->sequence : 1,
            .on_loss = c->on_loss,
            .lease_ns = c->lease_ns,
            .lock_step = c->lock_step,
            .name = c->name}};
}

/* Its bodies have been told. */
static void report_rest(service *s, session *c)
{
    wire_message m = greeting_of(c);
    m.client.removed = 1;
    for (size_t k = 0; k < c->subscriptions.count; k++) report_subscription(s, c, &c->subscriptions.at[k]);
    steps_record(s, c);
    if (c->left)
        record_message(s, &m);
    else if (c->lost)
        record_lost(s, c->client);
}

/* Bodies stay in their places, those that have come meanwhile are recorded already. True: all of it was reported. */
static bool report_client(service *s, session *c, body_columns *scratch, int64_t until_ns)
{
    enum { AT_ONCE = 64 };
    record_telling *t = &s->record_telling;
    if (t->next_body == 0) {
        const wire_message m = greeting_of(c);
        record_message(s, &m);
    }
    while (t->next_body < c->bodies.count) {
        report_body(s, c, &c->bodies.at[t->next_body++], scratch);
        if (t->next_body % AT_ONCE == 0 && time_is_up(until_ns)) return false;
    }
    report_rest(s, c);
    return true;
}

static void report_clients(service *s, int64_t until_ns)
{
    record_telling *t = &s->record_telling;
    body_columns *scratch = base_alloc(1, sizeof *scratch);
    while (s->recording && t->next < t->clients.count) {
        session *c = session_find(s, t->clients.at[t->next]); /* NULL: gone since */
        if (c && !report_client(s, c, scratch, until_ns)) break;
        t->next++;
        t->next_body = 0;
        if (time_is_up(until_ns)) break;
    }
    free(scratch);
}

void record_state_begin(service *s)
{
    record_telling *t = &s->record_telling;
    record_state_end(s);
    *t = (record_telling){.runs = true};
    for (size_t i = 0; i < s->sessions.count; i++) array_push(&t->clients, s->sessions.at[i]->client);
    record_steps(s);
    report_left(s);
}

bool record_state_more(service *s, int64_t most_ns)
{
    record_telling *t = &s->record_telling;
    int64_t until_ns = most_ns == INT64_MAX ? most_ns : clock_monotonic_ns() + most_ns;
    if (!t->runs) return true;
    if (!t->geometries_reported) report_geometries(s, until_ns);
    if (t->geometries_reported && !time_is_up(until_ns)) report_clients(s, until_ns);
    if (t->next < t->clients.count || !t->geometries_reported) return false;
    report_waiting_bodies(s);
    record_state_end(s);
    return true;
}

void record_state_end(service *s)
{
    array_free(&s->record_telling.clients);
    s->record_telling = (record_telling){.runs = false};
}
