/* record_state: the world as messages: what clients have announced and not taken back, with the newest poses. A
 * recording that begins in the middle begins with it. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "recordings.h"
#include "service.h"

#include "base/clock.h"
#include "geom/compound.h"
#include "geom/mesh.h"

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

static void pose_numbers(double at[7], pose p)
{
    const double numbers[7] = {p.p.x, p.p.y, p.p.z, p.q.w, p.q.x, p.q.y, p.q.z};
    for (int i = 0; i < 7; i++) at[i] = numbers[i];
}

typedef struct columns { /* of the shapes and rules of one body */
    uint8_t types[WIRE_SHAPES_MAX], actions[WIRE_RULES_MAX];
    double sizes[3 * WIRE_SHAPES_MAX], radii[WIRE_SHAPES_MAX], deviations[WIRE_SHAPES_MAX], poses[7 * WIRE_SHAPES_MAX],
        pose[7];
    double paddings[WIRE_RULES_MAX], margins[WIRE_RULES_MAX];
    int64_t geometries[WIRE_SHAPES_MAX];
    const char *patterns[WIRE_RULES_MAX], *reasons[WIRE_RULES_MAX];
    world_shape shapes[WIRE_SHAPES_MAX];
} columns;

static uint8_t wire_type_of(const shape *s)
{
    bool field = s->type == SHAPE_MESH && s->mesh->rows;
    return field ? WIRE_SHAPE_HEIGHT_FIELD : (uint8_t)s->type;
}

typedef struct shape_writer {
    columns *c;
    const service *s;
    const owned_body *b;
    uint32_t count;
    size_t lent; /* of the body's geometries */
} shape_writer;

static void put_shape(shape_writer *w, const shape *s, pose local)
{
    uint32_t i = w->count++;
    columns *c = w->c;
    bool lent = s->type == SHAPE_HULL || s->type == SHAPE_MESH || s->type == SHAPE_SOFT,
         whole = s->type == SHAPE_COMPOUND;
    c->types[i] = wire_type_of(s);
    c->sizes[3 * i] = whole ? s->compound->child_count : s->half.x;
    c->sizes[3 * i + 1] = s->half.y;
    c->sizes[3 * i + 2] = s->half.z;
    c->radii[i] = s->radius;
    c->deviations[i] = s->deviation;
    pose_numbers(c->poses + 7 * (size_t)i, local);
    c->geometries[i] = lent ? geometry_at(w->s, w->b->geometries.at[w->lent++])->hash : 0;
}

static void fill_shapes(const service *of, columns *c, const world_body *def, const owned_body *b, wire_body *m)
{
    shape_writer w = {c, of, b, 0, 0};
    for (size_t i = 0; i < def->shape_count; i++) {
        const shape *s = &c->shapes[i].shape;
        put_shape(&w, s, c->shapes[i].local);
        for (uint32_t k = 0; s->type == SHAPE_COMPOUND && k < s->compound->child_count; k++)
            put_shape(&w, &s->compound->children[k].shape, s->compound->children[k].local);
    }
    uint32_t n = w.count;
    m->shape_types = (wire_u8s){n, c->types};
    m->shape_sizes = (wire_f64s){3 * n, c->sizes};
    m->shape_radii = (wire_f64s){n, c->radii};
    m->shape_deviations = (wire_f64s){n, c->deviations};
    m->shape_poses = (wire_f64s){7 * n, c->poses};
    m->shape_geometries = (wire_i64s){n, c->geometries};
}

static void fill_rules(columns *c, const world_body *def, wire_body *m)
{
    uint32_t n = (uint32_t)def->rule_count;
    for (uint32_t i = 0; i < n; i++) {
        c->patterns[i] = def->rules[i].pattern;
        c->actions[i] = def->rules[i].allow ? WIRE_RULE_ALLOW : WIRE_RULE_CHECK;
        c->reasons[i] = def->rules[i].reason;
        c->paddings[i] = def->rules[i].padding;
        c->margins[i] = def->rules[i].margin;
    }
    m->rule_patterns = (wire_strings){n, c->patterns};
    m->rule_actions = (wire_u8s){n, c->actions};
    m->rule_reasons = (wire_strings){n, c->reasons};
    m->rule_paddings = (wire_f64s){n, c->paddings};
    m->rule_margins = (wire_f64s){n, c->margins};
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

static void report_body(service *s, session *c, const owned_body *b, columns *scratch)
{
    world_body def;
    if (b->world_id == WORLD_NONE) report_removed_body(s, c, b);
    if (b->world_id == WORLD_NONE || world_get_body(s->world, b->world_id, &def, scratch->shapes) != WORLD_OK) return;
    pose_numbers(scratch->pose, def.pose);
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = b->sequence,
            .body = b->number,
            .motion = def.fixed ? WIRE_MOTION_FIXED : WIRE_MOTION_MOVING,
            .name = def.name,
            .group = def.group,
            .category = (int64_t)def.category,
            .mask = (int64_t)def.mask,
            .one_way = def.one_way,
            .ccd = (uint8_t)def.ccd,
            .acceleration_m_s2 = def.acceleration,
            .angular_acceleration_rad_s2 = def.angular_acceleration,
            .deadline_ns = def.deadline_ns,
            .stamp_ns = def.stamp_ns,
            .stamp_is_now = def.stamp_is_now,
            .pose = {7, scratch->pose}}};
    fill_shapes(s, scratch, &def, b, &m.body);
    fill_rules(scratch, &def, &m.body);
    record_message(s, &m);
    report_pose(s, c, b, &def, scratch->pose);
}

static void report_subscription(service *s, const session *c, const owned_subscription *i)
{
    world_subscription def;
    if (!i->live) report_removed_subscription(s, c, i);
    if (!i->live || world_get_subscription(s->world, i->world_id, &def) != WORLD_OK) return;
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = i->sequence,
            .subscription = i->number,
            .facts = (int32_t)def.facts,
            .stream = s->streams.at[i->world_id].name,
            .select_a = def.select_a,
            .select_b = def.select_b,
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
static bool report_client(service *s, session *c, columns *scratch, int64_t until_ns)
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
    columns *scratch = base_alloc(1, sizeof *scratch);
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
