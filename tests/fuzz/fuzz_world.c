/* Messages whose fields are any bytes, as DDS samples: each is refused by the decoder of samples for the reason that
 * wire_check has, or goes to the service and its world, as from a client; what these tell is in order. */
#include "one_daemon.h"
#include "take.h"

#include "wire_dds/wire_dds.h"

#include <stdlib.h>

enum { THINGS = 4, MESSAGES_MAX = 64 };

typedef struct room { /* what a message borrows */
    double numbers[64];
    int64_t longs[THINGS];
    int32_t ints[3 * THINGS];
    uint8_t bytes[THINGS], actions[THINGS];
    const char *texts[2 * THINGS];
} room;

typedef struct world_of {
    one_daemon daemon;
    taking bytes;
    room room;
    size_t used; /* of room.numbers */
    int64_t sequence;
} world_of;

static const char *take_text(taking *t)
{
    static const char *const TEXTS[] = {"a", "b", "a1", "*", "a*", "?", "group:g", "group:*", "g", "", "group:", "b\n"};
    return TEXTS[take_byte(t) % (sizeof TEXTS / sizeof *TEXTS)];
}

static wire_f64s numbers(world_of *w, size_t count)
{
    uint8_t lies = take_byte(&w->bytes);
    if (lies == 255) count = lies % 3;
    if (w->used + count > sizeof w->room.numbers / sizeof(double)) return (wire_f64s){0, NULL};
    double *at = w->room.numbers + w->used;
    for (size_t i = 0; i < count; i++) at[i] = take_number(&w->bytes);
    w->used += count;
    return (wire_f64s){(uint32_t)count, at};
}

/* Position and orientation; mostly a good one. */
static wire_f64s poses(world_of *w, size_t count)
{
    wire_f64s p = numbers(w, 7 * count);
    double *at = w->room.numbers + w->used - p.count;
    for (size_t i = 0; i + 7 <= p.count; i += 7)
        if (take_byte(&w->bytes) < 250) memcpy(at + i + 3, (double[]){1, 0, 0, 0}, 4 * sizeof(double));
    return p;
}

static wire_strings texts(world_of *w, size_t first, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) w->room.texts[first + i] = take_text(&w->bytes);
    return (wire_strings){count, w->room.texts + first};
}

static wire_message take_body(world_of *w)
{
    taking *t = &w->bytes;
    uint32_t shapes = take_byte(t) % (THINGS + 1), rules = take_byte(t) % THINGS;
    for (uint32_t i = 0; i < THINGS; i++) {
        w->room.bytes[i] = take_byte(t) % 12;
        w->room.longs[i] = take_byte(t) % 4 ? 0 : w->room.longs[THINGS - 1];
        w->room.actions[i] = take_byte(t) % 3;
    }
    wire_message m = {.kind = WIRE_BODY,
        .body = {.body = take_byte(t) % 4,
            .removed = take_byte(t) > 240,
            .motion = take_byte(t) % 3,
            .ccd = take_byte(t) % 4,
            .acceleration_m_s2 = take_byte(t) < 200 ? 0 : take_number(t),
            .angular_acceleration_rad_s2 = take_byte(t) < 200 ? 0 : take_number(t),
            .name = take_text(t),
            .group = take_byte(t) % 2 ? "g" : "",
            .category = take_byte(t) % 4,
            .mask = take_byte(t) < 200 ? -1 : take_byte(t),
            .one_way = take_byte(t) > 200,
            .deadline_ns = take_byte(t) < 200 ? 0 : take_byte(t) * INT64_C(1000000),
            .stamp_ns = take_byte(t) < 100 ? 0 : w->daemon.now_ns - take_byte(t) * INT64_C(1000000)}};
    m.body.pose = poses(w, 1);
    m.body.shape_types = (wire_u8s){shapes, w->room.bytes};
    m.body.shape_sizes = numbers(w, 3 * shapes);
    m.body.shape_radii = numbers(w, shapes);
    if (take_byte(t) > 200) m.body.shape_deviations = numbers(w, shapes);
    m.body.shape_poses = poses(w, shapes);
    m.body.shape_geometries = (wire_i64s){shapes, w->room.longs};
    m.body.rule_patterns = texts(w, 0, rules);
    m.body.rule_reasons = texts(w, THINGS, rules);
    m.body.rule_actions = (wire_u8s){rules, w->room.actions};
    m.body.rule_paddings = numbers(w, rules);
    m.body.rule_margins = numbers(w, rules);
    return m;
}

static wire_message take_poses(world_of *w)
{
    taking *t = &w->bytes;
    uint32_t count = take_byte(t) % (THINGS + 1);
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.stamp_ns = take_byte(t) < 100 ? 0 : w->daemon.now_ns - take_byte(t) * INT64_C(1000000),
            .step = take_byte(t) < 200 ? 0 : take_byte(t)}};
    for (uint32_t i = 0; i < THINGS; i++) w->room.ints[i] = take_byte(t) % 5;
    m.pose_batch.bodies = (wire_i32s){count, w->room.ints};
    m.pose_batch.positions = numbers(w, 3 * count);
    double *q = w->room.numbers + w->used;
    m.pose_batch.orientations = numbers(w, 4 * count);
    for (uint32_t i = 0; i + 4 <= m.pose_batch.orientations.count; i += 4)
        if (take_byte(t) < 200) memcpy(q + i, (double[]){1, 0, 0, 0}, 4 * sizeof(double));
    if (take_byte(t) > 128) m.pose_batch.linear = numbers(w, 3 * count);
    if (take_byte(t) > 128) m.pose_batch.angular = numbers(w, 3 * count);
    for (uint32_t i = 0; i < THINGS; i++) w->room.bytes[i] = take_byte(t) % 2;
    if (take_byte(t) > 200) m.pose_batch.teleports = (wire_u8s){count, w->room.bytes};
    return m;
}

static wire_message take_subscription(world_of *w)
{
    taking *t = &w->bytes;
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {.subscription = take_byte(t) % 4,
            .removed = take_byte(t) > 220,
            .facts = take_byte(t) % 33,
            .stream = take_byte(t) % 4 ? "" : take_text(t),
            .select_a = take_text(t),
            .select_b = take_text(t),
            .threshold_m = take_byte(t) < 200 ? 0 : take_number(t),
            .range_m = take_byte(t) < 128 ? 1 : take_number(t),
            .tolerance_m = take_byte(t) < 128 ? 1e-6 : take_number(t),
            .relative_tolerance = take_byte(t) < 200 ? 0 : take_number(t),
            .accuracy = take_byte(t) % 4,
            .hysteresis_m = take_byte(t) < 200 ? 0 : take_number(t),
            .horizon_s = take_byte(t) < 200 ? 0.5 : take_number(t),
            .rate_hz = take_byte(t) < 200 ? 0 : take_number(t)}};
}

static wire_message take_query(world_of *w)
{
    taking *t = &w->bytes;
    wire_message m = {.kind = WIRE_QUERY,
        .query = {.kind = take_byte(t) % 11,
            .name_a = take_text(t),
            .name_b = take_text(t),
            .length_m = take_number(t),
            .tolerance_m = take_byte(t) < 128 ? 1e-6 : take_number(t),
            .most = take_byte(t),
            .span_s = take_number(t)}};
    if (m.query.kind == WIRE_QUERY_RECORD) m.query.kind = WIRE_QUERY_BODIES; /* files are not for fuzzers */
    wire_f64s *threes[] = {
        &m.query.origin, &m.query.half, &m.query.direction, &m.query.linear, &m.query.angular, &m.query.orientation};
    for (size_t i = 0; i < sizeof threes / sizeof *threes; i++)
        if (take_byte(t) < 200) *threes[i] = numbers(w, i == 5 ? 4 : 3);
    return m;
}

/* Eight points, and triangles over them or none, under their true hash. */
static wire_message take_geometry(world_of *w)
{
    taking *t = &w->bytes;
    for (uint32_t i = 0; i < 3 * THINGS; i++) w->room.ints[i] = take_byte(t) % 9;
    wire_message m = {
        .kind = WIRE_GEOMETRY, .geometry = {.removed = take_byte(t) > 240, .kind = take_byte(t) % 4, .pieces = 1}};
    m.geometry.vertices = numbers(w, 24);
    m.geometry.indices = (wire_i32s){m.geometry.kind == WIRE_GEOMETRY_HULL ? 0 : 3 * THINGS, w->room.ints};
    m.geometry.vertex_numbers = (int32_t)m.geometry.vertices.count;
    m.geometry.index_numbers = (int32_t)m.geometry.indices.count;
    m.geometry.hash = wire_geometry_hash(m.geometry.kind, m.geometry.vertices, m.geometry.indices);
    w->room.longs[THINGS - 1] = m.geometry.hash;
    return m;
}

static wire_message take_message(world_of *w, uint8_t kind)
{
    switch (kind) {
    case 0:
        return (wire_message){.kind = WIRE_CLIENT,
            .client = {.on_loss = take_byte(&w->bytes) % 4,
                .removed = take_byte(&w->bytes) > 240,
                .lease_ns = take_byte(&w->bytes) * INT64_C(10000000),
                .lock_step = take_byte(&w->bytes) > 200,
                .name = take_text(&w->bytes)}};
    case 1:
    case 2:
        return take_body(w);
    case 3:
    case 4:
        return take_poses(w);
    case 5:
        return take_subscription(w);
    case 6:
        return take_geometry(w);
    default:
        return take_query(w);
    }
}

/* Client, version and sequence stand first in each of them. */
static void send(world_of *w, wire_message *m)
{
    uint8_t from = take_byte(&w->bytes);
    m->client.version = from == 255 ? 0 : WIRE_VERSION;
    m->client.client = from % 3 + (from < 250);
    m->client.sequence = take_byte(&w->bytes) < 250 ? ++w->sequence : 1;
    wire_refusal why, why_decoded;
    wire_message decoded = {.kind = m->kind};
    void *sample = calloc(1, wire_dds_sample_size(m->kind));
    wire_dds_encode(m, sample);
    wire_reason reason = wire_check(m, &why), got = wire_dds_decode(m->kind, sample, &decoded, &why_decoded);
    PROMISE(got == reason);
    if (got == WIRE_OK) one_daemon_give(&w->daemon, &decoded);
    free(sample);
}

static void tick(world_of *w)
{
    wire_message m;
    one_daemon_tick(&w->daemon, (1 + take_byte(&w->bytes)) * INT64_C(1000000));
    while (one_daemon_hear(&w->daemon, &m)) continue;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static world_of w;
    w = (world_of){.bytes = {data, size, 1}};
    one_daemon_begin(&w.daemon);
    for (int i = 0; i < MESSAGES_MAX && w.bytes.left; i++) {
        uint8_t what = take_byte(&w.bytes) % 12;
        w.used = 0;
        if (what < 8) {
            wire_message m = take_message(&w, what);
            send(&w, &m);
        } else {
            tick(&w);
        }
    }
    tick(&w);
    tick(&w);
    one_daemon_end(&w.daemon);
    return 0;
}
