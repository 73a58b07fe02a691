/* Numbers come from all magnitudes that are allowed, texts are UTF-8 of one to four bytes a character, and any array
 * that may be empty sometimes is. */
#include "sample.h"
#include "base/prng.h"

#include "wire/wire_extensions.h"

#include <math.h>
#include <string.h>

enum { ALL = 1 << 20 };

uint64_t sample_next(sampler *s)
{
    return prng_bits(&s->random);
}

uint32_t sample_below(sampler *s, uint32_t bound)
{
    return (uint32_t)(sample_next(s) % bound);
}

static int64_t positive(sampler *s)
{
    return (int64_t)(sample_next(s) >> 1 >> sample_below(s, 62)) + 1;
}

static bool coin(sampler *s)
{
    return sample_below(s, 2);
}

static double unit(sampler *s)
{
    return (double)(sample_next(s) >> 11) * 0x1p-53;
}

/* In (0, most], its magnitude anywhere from 1e-9 m up. */
static double size(sampler *s, double most)
{
    return fmin(most, 1e-9 * pow(most * 1e9, 1 - unit(s)));
}

static double number(sampler *s, double most)
{
    return coin(s) ? size(s, most) : -size(s, most);
}

/* ---- arrays ---- */

static wire_f64s f64s(sampler *s, uint32_t count, double most)
{
    double *at = wire_memory_take(s->memory, count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) at[i] = number(s, most);
    return (wire_f64s){count, at};
}

static wire_f64s margins(sampler *s, uint32_t count)
{
    double *at = wire_memory_take(s->memory, count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) at[i] = fabs(number(s, WIRE_SIZE_MAX));
    return (wire_f64s){count, at};
}

static void turn(sampler *s, double q[4])
{
    double norm = 0;
    while (norm < 0.01) {
        for (int k = 0; k < 4; k++) q[k] = 2 * unit(s) - 1;
        norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    }
    for (int k = 0; k < 4; k++) q[k] /= norm;
}

static wire_f64s turns(sampler *s, uint32_t count)
{
    double *at = wire_memory_take(s->memory, 4 * (size_t)count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) turn(s, at + 4 * (size_t)i);
    return (wire_f64s){4 * count, at};
}

static wire_f64s poses(sampler *s, uint32_t count)
{
    wire_f64s p = f64s(s, 7 * count, WIRE_POSITION_MAX);
    for (uint32_t i = 0; i < count; i++) turn(s, (double *)p.at + 7 * (size_t)i + 3);
    return p;
}

static wire_u8s u8s(sampler *s, uint32_t count, uint8_t least, uint8_t most)
{
    uint8_t *at = wire_memory_take(s->memory, count);
    for (uint32_t i = 0; i < count; i++) at[i] = (uint8_t)(least + sample_below(s, most - least + 1u));
    return (wire_u8s){count, at};
}

static wire_i32s i32s(sampler *s, uint32_t count, uint32_t below)
{
    int32_t *at = wire_memory_take(s->memory, count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) at[i] = (int32_t)sample_below(s, below);
    return (wire_i32s){count, at};
}

static wire_i64s i64s(sampler *s, uint32_t count)
{
    int64_t *at = wire_memory_take(s->memory, count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) at[i] = (int64_t)sample_next(s);
    return (wire_i64s){count, at};
}

/* ---- texts ---- */

static const char *text(sampler *s, uint32_t most)
{
    static const char *const letters[] = {"a", "Z", "_", "7", " ", "\u00e9", "\u2192", "\U0001f916"};
    char *at = wire_memory_take(s->memory, most + 1);
    size_t used = 0;
    for (uint32_t n = sample_below(s, 24); n > 0; n--) {
        const char *letter = letters[sample_below(s, sizeof letters / sizeof *letters)];
        if (used + strlen(letter) > most) break;
        memcpy(at + used, letter, strlen(letter));
        used += strlen(letter);
    }
    at[used] = '\0';
    return at;
}

static const char *name(sampler *s)
{
    const char *t = text(s, WIRE_NAME_MAX);
    return *t ? t : "n";
}

static const char *stream(sampler *s)
{
    static const char *const streams[] = {"cell.near", "a", "00000000000000ff.3", "ns:x/y-z_9"};
    return streams[sample_below(s, 4)];
}

static wire_strings names(sampler *s, uint32_t count)
{
    const char **at = wire_memory_take(s->memory, count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) at[i] = name(s);
    return (wire_strings){count, at};
}

/* ---- messages ---- */

static wire_client client(sampler *s)
{
    return (wire_client){WIRE_VERSION, positive(s), positive(s), .on_loss = (uint8_t)sample_below(s, 3),
        .lease_ns = positive(s), .lock_step = (int32_t)sample_below(s, WIRE_LOCK_STEP_MAX + 1),
        .name = text(s, WIRE_NAME_MAX)};
}

static wire_geometry geometry(sampler *s, uint32_t most)
{
    bool mesh = coin(s);
    uint32_t vertices = 4 + sample_below(s, most), triangles = mesh ? 1 + sample_below(s, most) : 0;
    wire_geometry g = {WIRE_VERSION, positive(s), positive(s), .kind = mesh ? WIRE_GEOMETRY_MESH : WIRE_GEOMETRY_HULL,
        .vertex_numbers = (int32_t)(3 * vertices), .index_numbers = (int32_t)(3 * triangles), .pieces = 1};
    g.vertices = f64s(s, 3 * vertices, WIRE_SIZE_MAX);
    g.indices = i32s(s, 3 * triangles, vertices);
    g.hash = wire_geometry_hash(g.kind, g.vertices, g.indices);
    return g;
}

static void shape(sampler *s, uint8_t type, double sizes[3], double *radius, int64_t *geometry_hash)
{
    bool spun = type == WIRE_SHAPE_CYLINDER || type == WIRE_SHAPE_CONE;
    bool solid = spun || type == WIRE_SHAPE_BOX || type == WIRE_SHAPE_ELLIPSOID;
    for (int k = 0; k < 3; k++) sizes[k] = solid ? size(s, WIRE_SIZE_MAX) : 0;
    if (spun) sizes[1] = sizes[0];
    if (type == WIRE_SHAPE_CAPSULE) sizes[2] = size(s, WIRE_SIZE_MAX);
    *radius = type <= WIRE_SHAPE_CAPSULE || coin(s) ? size(s, WIRE_SIZE_MAX) : 0;
    *geometry_hash = type >= WIRE_SHAPE_HULL ? positive(s) : 0;
}

/* Any, or a compound of all the others. */
static wire_u8s body_types(sampler *s, uint32_t shapes)
{
    if (shapes < 2 || coin(s)) return u8s(s, shapes, WIRE_SHAPE_SPHERE, WIRE_SHAPE_HEIGHT_FIELD);
    uint8_t *at = wire_memory_take(s->memory, shapes);
    at[0] = WIRE_SHAPE_COMPOUND;
    for (uint32_t i = 1; i < shapes; i++) at[i] = (uint8_t)(WIRE_SHAPE_SPHERE + sample_below(s, WIRE_SHAPE_HALFSPACE));
    return (wire_u8s){shapes, at};
}

static wire_body body(sampler *s, uint32_t most)
{
    uint32_t shapes = 1 + sample_below(s, most), rules = sample_below(s, most);
    double *sizes = wire_memory_take(s->memory, 3 * (size_t)shapes * sizeof *sizes);
    double *radii = wire_memory_take(s->memory, shapes * sizeof *radii);
    int64_t *hashes = wire_memory_take(s->memory, shapes * sizeof *hashes);
    wire_u8s types = body_types(s, shapes);
    if (types.at[0] == WIRE_SHAPE_COMPOUND) {
        sizes[0] = shapes - 1;
        sizes[1] = sizes[2] = radii[0] = 0;
        hashes[0] = 0;
    }
    for (uint32_t i = types.at[0] == WIRE_SHAPE_COMPOUND; i < shapes; i++)
        shape(s, types.at[i], sizes + 3 * (size_t)i, radii + i, hashes + i);
    return (wire_body){WIRE_VERSION, positive(s), positive(s), (int32_t)sample_below(s, INT32_MAX),
        .motion = (uint8_t)sample_below(s, 2), .ccd = (uint8_t)sample_below(s, 3), .acceleration_m_s2 = size(s, 100),
        .angular_acceleration_rad_s2 = size(s, 100), .name = name(s), .group = text(s, WIRE_NAME_MAX),
        .category = (int64_t)sample_next(s), .mask = (int64_t)sample_next(s), .deadline_ns = positive(s),
        .stamp_ns = positive(s), .pose = poses(s, 1), .shape_types = types, .shape_sizes = {3 * shapes, sizes},
        .shape_radii = {shapes, radii}, .shape_deviations = margins(s, coin(s) ? shapes : 0),
        .shape_poses = poses(s, shapes), .shape_geometries = {shapes, hashes}, .rule_patterns = names(s, rules),
        .rule_actions = u8s(s, rules, 0, 1), .rule_reasons = names(s, rules), .one_way = (uint8_t)sample_below(s, 2),
        .stamp_is_now = (uint8_t)sample_below(s, 2), .rule_paddings = f64s(s, rules, WIRE_SIZE_MAX),
        .rule_margins = margins(s, rules)};
}

static wire_pose_batch pose_batch(sampler *s, uint32_t most)
{
    uint32_t n = sample_below(s, most + 1);
    return (wire_pose_batch){WIRE_VERSION, positive(s), positive(s), positive(s), positive(s), positive(s),
        i32s(s, n, INT32_MAX), f64s(s, 3 * n, WIRE_POSITION_MAX), turns(s, n),
        f64s(s, coin(s) ? 3 * n : 0, WIRE_SPEED_MAX), f64s(s, coin(s) ? 3 * n : 0, WIRE_SPIN_MAX),
        .teleports = u8s(s, coin(s) ? n : 0, 0, 1)};
}

static wire_vertex_batch vertex_batch(sampler *s, uint32_t most)
{
    return (wire_vertex_batch){WIRE_VERSION, positive(s), positive(s), positive(s), positive(s),
        (int32_t)sample_below(s, INT32_MAX), (int32_t)sample_below(s, WIRE_SHAPES_MAX), (int32_t)sample_below(s, ALL),
        .vertices = f64s(s, 3 * sample_below(s, most + 1), WIRE_SIZE_MAX)};
}

static wire_subscription subscription(sampler *s)
{
    uint8_t accuracy = (uint8_t)sample_below(s, 3);
    uint32_t has = accuracy == WIRE_BY_TOLERANCE ? 31 : accuracy == WIRE_BY_BOXES ? 3 : 1;
    return (wire_subscription){WIRE_VERSION, positive(s), positive(s), (int32_t)sample_below(s, INT32_MAX),
        .facts = 1 + (int32_t)sample_below(s, has), .accuracy = accuracy,
        .relative_tolerance = coin(s) ? 0 : WIRE_FINEST_RELATIVE + size(s, 0.5), .stream = coin(s) ? stream(s) : "",
        .select_a = name(s), .select_b = "group:arms", .threshold_m = number(s, WIRE_SIZE_MAX),
        .range_m = size(s, WIRE_SIZE_MAX), .tolerance_m = size(s, 1), .horizon_s = size(s, WIRE_SPAN_MAX),
        .hysteresis_m = size(s, 1), .rate_hz = coin(s) ? 0 : size(s, 1000)};
}

static wire_query query(sampler *s)
{
    static const double half[] = {0.1, 0, WIRE_SIZE_MAX};
    return (wire_query){WIRE_VERSION, positive(s), positive(s), (uint8_t)(1 + sample_below(s, WIRE_QUERY_SWEEP)),
        name(s), name(s), f64s(s, 3, WIRE_POSITION_MAX), turns(s, coin(s)), .half = {3, half},
        .direction = f64s(s, 3, 1e290), .length_m = coin(s) ? INFINITY : size(s, 1e290), .tolerance_m = size(s, 1),
        .most = (int32_t)sample_below(s, WIRE_ANSWERS_MAX + 1), .linear = f64s(s, coin(s) ? 3 : 0, WIRE_SPEED_MAX),
        .angular = f64s(s, coin(s) ? 3 : 0, WIRE_SPIN_MAX), .span_s = size(s, WIRE_SPAN_MAX)};
}

static wire_receipt receipt(sampler *s)
{
    return (wire_receipt){WIRE_VERSION, positive(s), positive(s), (int32_t)sample_below(s, INT32_MAX), positive(s),
        positive(s), coin(s) ? positive(s) : 0, (int32_t)sample_below(s, INT32_MAX), .missing = coin(s)};
}

/* Certified intervals, some of them without bound. */
static void intervals(sampler *s, uint32_t n, wire_f64s *lo, wire_f64s *hi)
{
    *lo = f64s(s, n, 1e6);
    double *above = wire_memory_take(s->memory, n * sizeof *above);
    for (uint32_t i = 0; i < n; i++) {
        bool unknown = sample_below(s, 8) == 0;
        above[i] = unknown ? INFINITY : lo->at[i] + unit(s);
        if (unknown) ((double *)lo->at)[i] = -INFINITY;
    }
    *hi = (wire_f64s){n, above};
}

static wire_answer answer(sampler *s, uint32_t most)
{
    uint32_t n = sample_below(s, most + 1), m = coin(s) ? n : 0;
    wire_answer a = {WIRE_VERSION, positive(s), positive(s), positive(s), positive(s), positive(s),
        (uint8_t)(1 + sample_below(s, WIRE_QUERY_SWEEP)), (uint8_t)sample_below(s, 4), text(s, WIRE_TEXT_MAX),
        names(s, n), names(s, m), .axes = f64s(s, 3 * n, 1), .points_a = f64s(s, 3 * n, 1e12),
        .points_b = f64s(s, 3 * m, 1e12), .orientations = turns(s, m), .ages_ns = i64s(s, n), .stale = u8s(s, n, 0, 1),
        .achieved = u8s(s, coin(s) ? n : 0, 0, 3)};
    intervals(s, n, &a.lo, &a.hi);
    return a;
}

static void manifolds(sampler *s, wire_event_batch *m)
{
    uint32_t points = 0;
    m->manifold_counts = u8s(s, m->kinds.count, 0, 4);
    for (uint32_t i = 0; i < m->kinds.count; i++) points += m->manifold_counts.at[i];
    m->manifold_points = f64s(s, 3 * points, 1e12);
    m->manifold_distances = f64s(s, points, 1);
    m->manifold_features = i64s(s, points);
}

static void impacts(sampler *s, wire_event_batch *m)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < m->kinds.count; i++)
        n += m->kinds.at[i] == WIRE_EVENT_IMPACT || m->kinds.at[i] == WIRE_EVENT_PREDICTED;
    m->impact_times = f64s(s, 2 * n, 1e3);
    for (uint32_t i = 1; i < 2 * n; i += 2)
        if (coin(s)) ((double *)m->impact_times.at)[i] = INFINITY;
    m->impact_starts_ns = i64s(s, n);
    m->impact_poses = poses(s, 2 * n);
    m->impact_estimated = u8s(s, n, 0, 1);
}

static wire_event_batch event_batch(sampler *s, uint32_t most)
{
    uint32_t n = sample_below(s, most + 1);
    wire_event_batch m = {WIRE_VERSION, positive(s), (int32_t)sample_below(s, INT32_MAX), positive(s), positive(s),
        positive(s), positive(s), positive(s), positive(s), .snapshot = coin(s), .closing = coin(s),
        .part = (int32_t)sample_below(s, 3), .parts = 3, .stream = stream(s), .kinds = u8s(s, n, 1, 10),
        .causes = u8s(s, n, 0, 9), .contacts = i64s(s, n), .names_a = names(s, n), .names_b = names(s, n),
        .shapes_a = i32s(s, n, WIRE_SHAPES_MAX), .shapes_b = i32s(s, n, WIRE_SHAPES_MAX), .axes = f64s(s, 3 * n, 1),
        .points_a = f64s(s, 3 * n, 1e12), .points_b = f64s(s, 3 * n, 1e12), .ages_a_ns = i64s(s, n),
        .ages_b_ns = i64s(s, n), .closings = f64s(s, n, 100), .achieved = u8s(s, n, 0, 3), .undone = positive(s),
        .simulation_ns = positive(s), .missing = (int32_t)sample_below(s, 3), .refused = (int32_t)sample_below(s, 3),
        .refusal = (uint8_t)sample_below(s, 4), .heartbeat = n == 0 && coin(s), .oldest_pose_ns = positive(s)};
    intervals(s, n, &m.lo, &m.hi);
    manifolds(s, &m);
    impacts(s, &m);
    return m;
}

static wire_status status(sampler *s, uint32_t most)
{
    uint32_t n = sample_below(s, most + 1);
    return (wire_status){WIRE_VERSION, positive(s), (uint8_t)sample_below(s, 4), text(s, 64), text(s, 64),
        text(s, WIRE_TEXT_MAX), text(s, WIRE_TEXT_MAX), positive(s), positive(s), positive(s), names(s, n),
        .counter_values = i64s(s, n)};
}

static wire_reject reject(sampler *s)
{
    return (wire_reject){WIRE_VERSION, positive(s), positive(s), positive(s), (uint8_t)sample_below(s, WIRE_KIND_COUNT),
        (int32_t)sample_below(s, INT32_MAX) - 1, (uint8_t)(1 + sample_below(s, WIRE_REASON_COUNT - 1)),
        .text = text(s, WIRE_TEXT_MAX)};
}

static wire_ack ack(sampler *s, uint32_t most)
{
    return (wire_ack){WIRE_VERSION, positive(s), positive(s), .sequences = i64s(s, sample_below(s, most + 1))};
}

static wire_message without_extensions(sampler *s, wire_kind kind, uint32_t most)
{
    switch (kind) {
    case WIRE_CLIENT:
        return (wire_message){kind, .client = client(s)};
    case WIRE_GEOMETRY:
        return (wire_message){kind, .geometry = geometry(s, most)};
    case WIRE_BODY:
        return (wire_message){kind, .body = body(s, most)};
    case WIRE_POSE_BATCH:
        return (wire_message){kind, .pose_batch = pose_batch(s, most)};
    case WIRE_VERTEX_BATCH:
        return (wire_message){kind, .vertex_batch = vertex_batch(s, most)};
    case WIRE_SUBSCRIPTION:
        return (wire_message){kind, .subscription = subscription(s)};
    case WIRE_QUERY:
        return (wire_message){kind, .query = query(s)};
    case WIRE_RECEIPT:
        return (wire_message){kind, .receipt = receipt(s)};
    case WIRE_ANSWER:
        return (wire_message){kind, .answer = answer(s, most)};
    case WIRE_EVENT_BATCH:
        return (wire_message){kind, .event_batch = event_batch(s, most)};
    case WIRE_STATUS:
        return (wire_message){kind, .status = status(s, most)};
    case WIRE_REJECT:
        return (wire_message){kind, .reject = reject(s)};
    case WIRE_ACK:
        return (wire_message){kind, .ack = ack(s, most)};
    case WIRE_NOTHING:
    case WIRE_KIND_COUNT:
        break;
    }
    return (wire_message){.kind = WIRE_NOTHING};
}

/* Of a later release: none that must not be passed over. */
static wire_u8s extensions(sampler *s)
{
    enum { RECORDS = 3, LONGEST = 40 };
    uint8_t *at = wire_memory_take(s->memory, RECORDS * (WIRE_EXTENSION_HEAD + LONGEST)), *end = at;
    uint32_t id = 0;
    for (uint32_t n = sample_below(s, RECORDS + 1); n > 0; n--) {
        uint32_t length = sample_below(s, LONGEST + 1);
        id += 1 + sample_below(s, 1 << 29);
        for (int k = 0; k < 4; k++) *end++ = (uint8_t)(id >> 8 * k);
        for (int k = 0; k < 4; k++) *end++ = (uint8_t)(length >> 8 * k);
        for (uint32_t i = 0; i < length; i++) *end++ = (uint8_t)sample_next(s);
    }
    return (wire_u8s){(uint32_t)(end - at), at};
}

wire_message sample_message(sampler *s, wire_kind kind, uint32_t most)
{
    wire_message m = without_extensions(s, kind, most);
    if (wire_schema_of(kind) && coin(s)) wire_extensions_set(&m, extensions(s));
    return m;
}

/* ---- comparing ---- */

typedef struct any_array { /* as all arrays of plain messages are laid out */
    uint32_t count;
    const void *at;
} any_array;

static bool same_texts(any_array a, any_array b)
{
    for (uint32_t i = 0; i < a.count; i++)
        if (strcmp(((const char *const *)a.at)[i], ((const char *const *)b.at)[i]) != 0) return false;
    return true;
}

static bool same_field(wire_type type, const void *a, const void *b)
{
    static const size_t bytes[] = {[WIRE_U8] = 1,
        [WIRE_I32] = 4,
        [WIRE_I64] = 8,
        [WIRE_F64] = 8,
        [WIRE_U8S] = 1,
        [WIRE_I32S] = 4,
        [WIRE_I64S] = 8,
        [WIRE_F64S] = 8,
        [WIRE_STRINGS] = 0};
    if (type < WIRE_STRING) return memcmp(a, b, bytes[type]) == 0;
    if (type == WIRE_STRING) return strcmp(*(const char *const *)a, *(const char *const *)b) == 0;
    any_array one, other;
    memcpy(&one, a, sizeof one);
    memcpy(&other, b, sizeof other);
    if (one.count != other.count) return false;
    if (type == WIRE_STRINGS) return same_texts(one, other);
    return one.count == 0 || memcmp(one.at, other.at, one.count * bytes[type]) == 0;
}

const char *sample_difference(const wire_message *a, const wire_message *b)
{
    const wire_schema *s = wire_schema_of(a->kind);
    if (!s || a->kind != b->kind) return "kind";
    for (uint32_t i = 0; i < s->field_count; i++)
        if (!same_field(s->fields[i].type, wire_field_at(a, &s->fields[i]), wire_field_at(b, &s->fields[i])))
            return s->fields[i].name;
    return NULL;
}
