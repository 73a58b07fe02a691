/* wire_check: what can be told of a message without the world. First what the schema knows of every field (limits,
 * finite numbers, UTF-8), then one small function a message for its own rules. Pure; any thread. Each refusal names the
 * field, the index and what is allowed. */
#include "wire_schema.h"
#include "wire_text.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#define FAIL(reason, ...) return wire_refuse(why, reason, __VA_ARGS__)
#define TRY(check)                                                                                                     \
    do {                                                                                                               \
        wire_reason tried = (check);                                                                                   \
        if (tried != WIRE_OK) return tried;                                                                            \
    } while (0)

/* ---- by the schema ---- */

static wire_reason check_limit(const char *name, size_t count, uint32_t limit, const char *unit, wire_refusal *why)
{
    if (count <= limit) return WIRE_OK;
    FAIL(WIRE_TOO_LARGE, "%s has %zu %s: at most %u are allowed", name, count, unit, limit);
}

static wire_reason check_text(const char *name, uint32_t i, const char *text, uint32_t limit, wire_refusal *why)
{
    size_t length = text ? strnlen(text, (size_t)limit + 1) : 0;
    if (length > limit) FAIL(WIRE_TOO_LARGE, "%s (text %u) is longer than the allowed %u bytes", name, i, limit);
    if (length && !wire_text_is_utf8(text)) FAIL(WIRE_MALFORMED, "%s (text %u) is not UTF-8", name, i);
    return WIRE_OK;
}

static wire_reason check_texts(const wire_field *f, const wire_strings *s, wire_refusal *why)
{
    TRY(check_limit(f->name, s->count, f->limit, "texts", why));
    for (uint32_t i = 0; i < s->count; i++) TRY(check_text(f->name, i, s->at[i], WIRE_TEXT_MAX, why));
    return WIRE_OK;
}

static wire_reason check_numbers(const wire_field *f, const double *at, uint32_t count, wire_refusal *why)
{
    for (uint32_t i = 0; i < count; i++) {
        if (isnan(at[i])) FAIL(WIRE_BAD_NUMBER, "%s[%u] is not a number", f->name, i);
        if (!f->infinite && isinf(at[i])) FAIL(WIRE_BAD_NUMBER, "%s[%u] is infinite: it must be finite", f->name, i);
    }
    return WIRE_OK;
}

static wire_reason check_field(const wire_field *f, const void *at, wire_refusal *why)
{
    switch (f->type) {
    case WIRE_U8:
    case WIRE_I32:
    case WIRE_I64:
        return WIRE_OK;
    case WIRE_F64:
        return check_numbers(f, at, 1, why);
    case WIRE_STRING:
        return check_text(f->name, 0, *(const char *const *)at, f->limit, why);
    case WIRE_U8S:
        return check_limit(f->name, ((const wire_u8s *)at)->count, f->limit, "numbers", why);
    case WIRE_I32S:
        return check_limit(f->name, ((const wire_i32s *)at)->count, f->limit, "numbers", why);
    case WIRE_I64S:
        return check_limit(f->name, ((const wire_i64s *)at)->count, f->limit, "numbers", why);
    case WIRE_F64S: {
        const wire_f64s *numbers = at;
        TRY(check_limit(f->name, numbers->count, f->limit, "numbers", why));
        return check_numbers(f, numbers->at, numbers->count, why);
    }
    case WIRE_STRINGS:
        return check_texts(f, at, why);
    }
    return WIRE_OK;
}

/* ---- rules that several messages share ---- */

static wire_reason check_count(const char *name, uint32_t count, uint32_t each, uint32_t things, wire_refusal *why)
{
    if (count == each * things) return WIRE_OK;
    FAIL(WIRE_MALFORMED, "%s has %u elements: it must have %u for each of %u", name, count, each, things);
}

static wire_reason check_optional(const char *name, uint32_t count, uint32_t each, uint32_t things, wire_refusal *why)
{
    return count == 0 ? WIRE_OK : check_count(name, count, each, things, why);
}

static wire_reason check_between(const char *name, int64_t value, int64_t least, int64_t most, wire_refusal *why)
{
    if (value >= least && value <= most) return WIRE_OK;
    FAIL(WIRE_MALFORMED, "%s is %" PRId64 ": %" PRId64 " to %" PRId64 " is allowed", name, value, least, most);
}

static wire_reason check_all_between(const char *name, wire_u8s s, uint8_t least, uint8_t most, wire_refusal *why)
{
    for (uint32_t i = 0; i < s.count; i++)
        if (s.at[i] < least || s.at[i] > most)
            FAIL(WIRE_MALFORMED, "%s[%u] is %u: %u to %u is allowed", name, i, s.at[i], least, most);
    return WIRE_OK;
}

static wire_reason check_at_least(const char *name, double value, double least, wire_refusal *why)
{
    if (value >= least) return WIRE_OK;
    FAIL(WIRE_BAD_NUMBER, "%s is %g: at least %g is allowed", name, value, least);
}

static wire_reason check_magnitudes(const char *name, wire_f64s v, double most, wire_refusal *why)
{
    for (uint32_t i = 0; i < v.count; i++)
        if (fabs(v.at[i]) > most) FAIL(WIRE_TOO_LARGE, "%s[%u] is %g: at most %g is allowed", name, i, v.at[i], most);
    return WIRE_OK;
}

/* Near enough to 1 that normalising it is no guess. */
static wire_reason check_rotation(const char *name, uint32_t i, const double q[4], wire_refusal *why)
{
    double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (squared >= 0.25 && squared <= 4) return WIRE_OK;
    FAIL(WIRE_BAD_ROTATION, "%s[%u..%u] has the norm %g: 0.5 to 2 is allowed", name, i, i + 3, sqrt(squared));
}

static wire_reason check_poses(const char *name, wire_f64s poses, wire_refusal *why)
{
    for (uint32_t i = 0; i + 7 <= poses.count; i += 7) {
        for (uint32_t k = i; k < i + 3; k++)
            if (fabs(poses.at[k]) > WIRE_POSITION_MAX)
                FAIL(WIRE_TOO_LARGE, "%s[%u] is %g m: at most %g is allowed", name, k, poses.at[k], WIRE_POSITION_MAX);
        TRY(check_rotation(name, i + 3, poses.at + i + 3, why));
    }
    return WIRE_OK;
}

static wire_reason check_label(const char *name, const char *text, wire_refusal *why)
{
    size_t length = text ? strnlen(text, WIRE_NAME_MAX + 1) : 0;
    if (length > WIRE_NAME_MAX) FAIL(WIRE_TOO_LARGE, "%s is longer than the allowed %d bytes", name, WIRE_NAME_MAX);
    if (length && wire_text_has_controls(text)) FAIL(WIRE_BAD_NAME, "%s must not have control characters", name);
    return WIRE_OK;
}

static wire_reason check_name(const char *name, const char *text, wire_refusal *why)
{
    if (!text || !*text) FAIL(WIRE_BAD_NAME, "%s is empty: 1 to %d bytes are allowed", name, WIRE_NAME_MAX);
    return check_label(name, text, why);
}

/* A name with '*' and '?', or a group. */
static wire_reason check_pattern(const char *name, const char *text, wire_refusal *why)
{
    TRY(check_name(name, text, why));
    if (strcmp(text, "group:") == 0) FAIL(WIRE_BAD_NAME, "%s is \"group:\" without the group's name", name);
    return WIRE_OK;
}

/* It names a DDS partition, where '*' would mean all of them, and an LCM channel, which is subscribed by a regular
 * expression. */
static wire_reason check_stream(const char *text, wire_refusal *why)
{
    static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-:/";
    if (text && text[strspn(text, allowed)]) FAIL(WIRE_BAD_NAME, "stream: letters, digits and . _ - : / are allowed");
    return WIRE_OK;
}

static wire_reason check_sender(int64_t client, int64_t sequence, wire_refusal *why)
{
    if (client == 0) FAIL(WIRE_UNKNOWN_CLIENT, "client is 0: any other number is allowed");
    return check_between("sequence", sequence, 1, INT64_MAX, why);
}

/* ---- each message ---- */

static wire_reason check_client(const wire_client *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("removed", m->removed, 0, 1, why));
    if (m->removed) return WIRE_OK;
    TRY(check_between("on_loss", m->on_loss, WIRE_LOST_REMOVE, WIRE_LOST_KEEP, why));
    TRY(check_between("lease_ns", m->lease_ns, 1, INT64_MAX, why));
    TRY(check_between("lock_step", m->lock_step, 0, WIRE_LOCK_STEP_MAX, why));
    return check_label("name", m->name, why);
}

/* How many of the numbers [from, to) of the whole lie in this piece. */
static uint32_t share_of_piece(int64_t piece, int64_t from, int64_t to)
{
    int64_t first = piece * WIRE_PIECE_MAX, end = first + WIRE_PIECE_MAX;
    int64_t lo = from > first ? from : first, hi = to < end ? to : end;
    return hi > lo ? (uint32_t)(hi - lo) : 0;
}

static wire_reason check_pieces(const wire_geometry *m, wire_refusal *why)
{
    int64_t whole = (int64_t)m->vertex_numbers + m->index_numbers;
    if (whole > WIRE_GEOMETRY_MAX)
        FAIL(WIRE_TOO_LARGE, "the geometry has %" PRId64 " numbers: at most %d are allowed", whole, WIRE_GEOMETRY_MAX);
    int64_t pieces = (whole + WIRE_PIECE_MAX - 1) / WIRE_PIECE_MAX;
    TRY(check_between("pieces", m->pieces, pieces, pieces, why));
    TRY(check_between("piece", m->piece, 0, pieces - 1, why));
    uint32_t vertices = share_of_piece(m->piece, 0, m->vertex_numbers);
    uint32_t indices = share_of_piece(m->piece, m->vertex_numbers, whole);
    TRY(check_count("vertices", m->vertices.count, 1, vertices, why));
    return check_count("indices", m->indices.count, 1, indices, why);
}

/* The numbers that the whole may have. */
static wire_reason check_geometry_kind(const wire_geometry *m, wire_refusal *why)
{
    bool triples = m->vertex_numbers % 3 == 0 && m->index_numbers % 3 == 0;
    switch (m->kind) {
    case WIRE_GEOMETRY_HULL:
        if (!triples || m->index_numbers != 0) FAIL(WIRE_MALFORMED, "a hull has three numbers a vertex and no indices");
        if (m->vertex_numbers < 12)
            FAIL(WIRE_FLAT_HULL, "vertex_numbers is %d: a hull has at least 4 points, 12 numbers", m->vertex_numbers);
        return WIRE_OK;
    case WIRE_GEOMETRY_MESH:
        if (!triples || m->vertex_numbers < 9 || m->index_numbers < 3)
            FAIL(WIRE_MALFORMED, "a mesh has three numbers a vertex and a triangle, and at least one triangle");
        return WIRE_OK;
    case WIRE_GEOMETRY_HEIGHT_FIELD:
        if (m->index_numbers != 2 || m->vertex_numbers < WIRE_FIELD_HEAD + 4)
            FAIL(WIRE_MALFORMED,
                "a height field has spacing x, y, base and 4 or more heights, and 2 indices: columns, rows");
        return WIRE_OK;
    default:
        FAIL(WIRE_MALFORMED, "kind is %u: 1 to 3 is allowed", m->kind);
    }
}

static wire_reason check_indices(const wire_geometry *m, wire_refusal *why)
{
    int32_t vertices = m->vertex_numbers / 3;
    for (uint32_t i = 0; m->kind == WIRE_GEOMETRY_MESH && i < m->indices.count; i++)
        if (m->indices.at[i] < 0 || m->indices.at[i] >= vertices)
            FAIL(WIRE_MALFORMED, "indices[%u] is %d: 0 to %d is allowed", i, m->indices.at[i], vertices - 1);
    return WIRE_OK;
}

/* As far as this piece shows it; what comes in other pieces is looked at when the field is built. */
static wire_reason check_height_field(const wire_geometry *m, wire_refusal *why)
{
    static const char *const names[WIRE_FIELD_HEAD] = {"spacing x", "spacing y", "base"};
    for (uint32_t i = 0; m->piece == 0 && i < WIRE_FIELD_HEAD; i++)
        if (!(m->vertices.at[i] > 0))
            FAIL(WIRE_BAD_SIZE, "vertices[%u], the %s of a height field, is %g m: above 0 is allowed", i, names[i],
                m->vertices.at[i]);
    if (m->indices.count < 2) return WIRE_OK;
    int32_t columns = m->indices.at[0], rows = m->indices.at[1];
    if (columns < 2 || rows < 2)
        FAIL(WIRE_MALFORMED, "indices: a height field of %d columns and %d rows: at least 2 of each are allowed",
            columns, rows);
    int64_t heights = (int64_t)m->vertex_numbers - WIRE_FIELD_HEAD;
    if ((int64_t)columns * rows != heights)
        FAIL(WIRE_MALFORMED, "indices: %d columns and %d rows are not %" PRId64 " heights", columns, rows, heights);
    return WIRE_OK;
}

static wire_reason check_geometry(const wire_geometry *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("removed", m->removed, 0, 1, why));
    if (m->hash == 0) FAIL(WIRE_BAD_HASH, "hash is 0: any other number is allowed");
    if (m->removed) return WIRE_OK;
    TRY(check_between("vertex_numbers", m->vertex_numbers, 0, INT32_MAX, why));
    TRY(check_between("index_numbers", m->index_numbers, 0, INT32_MAX, why));
    TRY(check_geometry_kind(m, why));
    TRY(check_pieces(m, why));
    TRY(check_magnitudes("vertices", m->vertices, WIRE_SIZE_MAX, why));
    TRY(check_indices(m, why));
    if (m->kind == WIRE_GEOMETRY_HEIGHT_FIELD) TRY(check_height_field(m, why));
    if (m->pieces == 1 && wire_geometry_hash(m->kind, m->vertices, m->indices) != m->hash)
        FAIL(WIRE_BAD_HASH, "the content does not have the hash %016" PRIx64, (uint64_t)m->hash);
    return WIRE_OK;
}

/* Which of the three sizes a type uses. An unused one must be 0; a used one positive, except where the rounding radius
 * makes a solid of what is flat. */
typedef struct size_rule {
    const char *name;
    bool used[3];
    bool round;    /* used[0] and used[1] are the same radius */
    bool zero;     /* a used size may be 0 even without rounding */
    bool radius;   /* the radius must be positive */
    bool geometry; /* it needs one; otherwise it may not have one */
} size_rule;

static const size_rule size_rules[] = {
    [WIRE_SHAPE_SPHERE] = {"sphere", .radius = true},
    [WIRE_SHAPE_CAPSULE] = {"capsule", .used = {false, false, true}, .zero = true, .radius = true},
    [WIRE_SHAPE_BOX] = {"box", .used = {true, true, true}},
    [WIRE_SHAPE_CYLINDER] = {"cylinder", .used = {true, true, true}, .round = true},
    [WIRE_SHAPE_CONE] = {"cone", .used = {true, true, true}, .round = true},
    [WIRE_SHAPE_ELLIPSOID] = {"ellipsoid", .used = {true, true, true}},
    [WIRE_SHAPE_HALFSPACE] = {"half-space", .zero = true},
    [WIRE_SHAPE_HULL] = {"hull", .geometry = true},
    [WIRE_SHAPE_MESH] = {"mesh", .geometry = true},
    [WIRE_SHAPE_HEIGHT_FIELD] = {"height field", .geometry = true},
    [WIRE_SHAPE_COMPOUND] = {"compound", .used = {true, false, false}, .zero = true},
};

static wire_reason check_shape_size(
    const size_rule *rule, uint32_t i, double size, bool used, bool zero, wire_refusal *why)
{
    if (!used && size != 0) FAIL(WIRE_BAD_SIZE, "shape_sizes[%u] is %g: of a %s it must be 0", i, size, rule->name);
    if (size < 0 || size > WIRE_SIZE_MAX)
        FAIL(WIRE_BAD_SIZE, "shape_sizes[%u] is %g m: 0 to %g is allowed", i, size, WIRE_SIZE_MAX);
    if (used && !zero && size == 0)
        FAIL(WIRE_BAD_SIZE, "shape_sizes[%u] is 0: a %s that is not rounded must be solid", i, rule->name);
    return WIRE_OK;
}

static wire_reason check_shape(const wire_body *m, uint32_t i, wire_refusal *why)
{
    const size_rule *rule = &size_rules[m->shape_types.at[i]];
    const double *sizes = m->shape_sizes.at + 3 * i;
    double radius = m->shape_radii.at[i];
    for (uint32_t k = 0; k < 3; k++)
        TRY(check_shape_size(rule, 3 * i + k, sizes[k], rule->used[k], rule->zero || radius > 0, why));
    if (rule->round && sizes[0] != sizes[1])
        FAIL(WIRE_BAD_SIZE, "shape_sizes[%u] and [%u] differ: a %s is round", 3 * i, 3 * i + 1, rule->name);
    if (radius < 0 || radius > WIRE_SIZE_MAX || (rule->radius && radius == 0))
        FAIL(WIRE_BAD_SIZE, "shape_radii[%u] is %g m: %s 0 and at most %g is allowed for a %s", i, radius,
            rule->radius ? "above" : "at least", WIRE_SIZE_MAX, rule->name);
    double deviation = m->shape_deviations.count ? m->shape_deviations.at[i] : 0;
    if (deviation < 0 || deviation > WIRE_SIZE_MAX)
        FAIL(WIRE_BAD_SIZE, "shape_deviations[%u] is %g m: 0 to %g is allowed", i, deviation, WIRE_SIZE_MAX);
    if (rule->geometry != (m->shape_geometries.at[i] != 0))
        FAIL(WIRE_MALFORMED, "shape_geometries[%u]: a %s %s", i, rule->name, rule->geometry ? "needs one" : "has none");
    return WIRE_OK;
}

/* The children follow their compound in the list. *last: the last of them. */
static wire_reason check_children(const wire_body *m, uint32_t i, uint32_t *last, wire_refusal *why)
{
    double count = m->shape_sizes.at[3 * i];
    uint32_t behind = m->shape_types.count - 1 - i;
    if (!(count >= 1) || count > behind || count != (uint32_t)count)
        FAIL(WIRE_BAD_SIZE, "shape_sizes[%u] is %g: a compound's number of children, 1 to the %u shapes that follow it",
            3 * i, count, behind);
    *last = i + (uint32_t)count;
    for (uint32_t k = i + 1; k <= *last; k++) {
        uint8_t type = m->shape_types.at[k];
        if (type == WIRE_SHAPE_HALFSPACE || type > WIRE_SHAPE_HULL)
            FAIL(WIRE_MALFORMED, "shape_types[%u]: a %s cannot be the child of a compound", k, size_rules[type].name);
    }
    return WIRE_OK;
}

static wire_reason check_shapes(const wire_body *m, wire_refusal *why)
{
    uint32_t n = m->shape_types.count;
    if (n == 0) FAIL(WIRE_MALFORMED, "shape_types is empty: 1 to %d shapes are allowed", WIRE_SHAPES_MAX);
    TRY(check_all_between("shape_types", m->shape_types, WIRE_SHAPE_SPHERE, WIRE_SHAPE_COMPOUND, why));
    TRY(check_count("shape_sizes", m->shape_sizes.count, 3, n, why));
    TRY(check_count("shape_radii", m->shape_radii.count, 1, n, why));
    TRY(check_optional("shape_deviations", m->shape_deviations.count, 1, n, why));
    TRY(check_count("shape_poses", m->shape_poses.count, 7, n, why));
    TRY(check_count("shape_geometries", m->shape_geometries.count, 1, n, why));
    for (uint32_t i = 0; i < n; i++) TRY(check_shape(m, i, why));
    for (uint32_t i = 0; i < n; i++)
        if (m->shape_types.at[i] == WIRE_SHAPE_COMPOUND) TRY(check_children(m, i, &i, why));
    return check_poses("shape_poses", m->shape_poses, why);
}

static wire_reason check_rules(const wire_body *m, wire_refusal *why)
{
    uint32_t n = m->rule_patterns.count;
    TRY(check_count("rule_actions", m->rule_actions.count, 1, n, why));
    TRY(check_count("rule_reasons", m->rule_reasons.count, 1, n, why));
    TRY(check_count("rule_paddings", m->rule_paddings.count, 1, n, why));
    TRY(check_count("rule_margins", m->rule_margins.count, 1, n, why));
    TRY(check_all_between("rule_actions", m->rule_actions, WIRE_RULE_ALLOW, WIRE_RULE_CHECK, why));
    TRY(check_magnitudes("rule_paddings", m->rule_paddings, WIRE_SIZE_MAX, why));
    TRY(check_magnitudes("rule_margins", m->rule_margins, WIRE_SIZE_MAX, why));
    for (uint32_t i = 0; i < n; i++) TRY(check_at_least("a rule's margin", m->rule_margins.at[i], 0, why));
    for (uint32_t i = 0; i < n; i++) TRY(check_pattern("a rule's pattern", m->rule_patterns.at[i], why));
    return WIRE_OK;
}

static wire_reason check_rate(const char *name, double rate, wire_refusal *why)
{
    TRY(check_at_least(name, rate, 0, why));
    return check_magnitudes(name, (wire_f64s){1, &rate}, WIRE_SPEED_MAX, why);
}

static wire_reason check_body(const wire_body *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("body", m->body, 0, INT32_MAX, why));
    TRY(check_between("removed", m->removed, 0, 1, why));
    if (m->removed) return WIRE_OK;
    TRY(check_between("motion", m->motion, WIRE_MOTION_MOVING, WIRE_MOTION_FIXED, why));
    TRY(check_between("ccd", m->ccd, WIRE_CCD_OFF, WIRE_CCD_FULL, why));
    TRY(check_rate("acceleration_m_s2", m->acceleration_m_s2, why));
    TRY(check_rate("angular_acceleration_rad_s2", m->angular_acceleration_rad_s2, why));
    TRY(check_between("one_way", m->one_way, 0, 1, why));
    TRY(check_name("name", m->name, why));
    TRY(check_label("group", m->group, why));
    TRY(check_between("deadline_ns", m->deadline_ns, 0, INT64_MAX, why));
    TRY(check_between("stamp_ns", m->stamp_ns, 0, INT64_MAX, why));
    TRY(check_count("pose", m->pose.count, 7, 1, why));
    TRY(check_poses("pose", m->pose, why));
    TRY(check_shapes(m, why));
    return check_rules(m, why);
}

static wire_reason check_pose_batch(const wire_pose_batch *m, wire_refusal *why)
{
    uint32_t n = m->bodies.count;
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("stamp_ns", m->stamp_ns, 0, INT64_MAX, why));
    TRY(check_count("positions", m->positions.count, 3, n, why));
    TRY(check_count("orientations", m->orientations.count, 4, n, why));
    TRY(check_optional("linear", m->linear.count, 3, n, why));
    TRY(check_optional("angular", m->angular.count, 3, n, why));
    for (uint32_t i = 0; i < n; i++) {
        if (m->bodies.at[i] < 0) FAIL(WIRE_MALFORMED, "bodies[%u] is %d: at least 0 is allowed", i, m->bodies.at[i]);
        TRY(check_rotation("orientations", 4 * i, m->orientations.at + 4 * i, why));
    }
    TRY(check_magnitudes("positions", m->positions, WIRE_POSITION_MAX, why));
    TRY(check_magnitudes("linear", m->linear, WIRE_SPEED_MAX, why));
    TRY(check_magnitudes("angular", m->angular, WIRE_SPIN_MAX, why));
    TRY(check_optional("teleports", m->teleports.count, 1, n, why));
    return check_all_between("teleports", m->teleports, 0, 1, why);
}

static wire_reason check_vertex_batch(const wire_vertex_batch *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("stamp_ns", m->stamp_ns, 0, INT64_MAX, why));
    TRY(check_between("body", m->body, 0, INT32_MAX, why));
    TRY(check_between("shape", m->shape, 0, WIRE_SHAPES_MAX - 1, why));
    TRY(check_between("first_vertex", m->first_vertex, 0, WIRE_GEOMETRY_MAX / 3, why));
    TRY(check_count("vertices", m->vertices.count, 3, m->vertices.count / 3, why));
    return check_magnitudes("vertices", m->vertices, WIRE_SIZE_MAX, why);
}

static wire_reason check_horizon(const wire_interest *m, wire_refusal *why)
{
    bool foretells = m->facts & WIRE_FACT_FORETELL;
    TRY(check_at_least("horizon_s", m->horizon_s, 0, why));
    if (m->horizon_s > WIRE_SPAN_MAX || (foretells && m->horizon_s == 0))
        FAIL(WIRE_BAD_SIZE, "horizon_s is %g s: %s 0 and at most %g is allowed", m->horizon_s,
            foretells ? "above" : "at least", WIRE_SPAN_MAX);
    return WIRE_OK;
}

static wire_reason check_accuracy(const wire_interest *m, wire_refusal *why)
{
    double relative = m->relative_tolerance;
    TRY(check_at_least("tolerance_m", m->tolerance_m, 0, why));
    TRY(check_between("accuracy", m->accuracy, WIRE_BY_TOLERANCE, WIRE_BY_VERDICT, why));
    if (!(relative == 0 || (relative >= WIRE_FINEST_RELATIVE && relative <= 1)))
        FAIL(WIRE_BAD_NUMBER, "relative_tolerance is %g: %g to 1 is possible, or 0: as narrow as arithmetic gives",
            relative, WIRE_FINEST_RELATIVE);
    if (m->accuracy != WIRE_BY_TOLERANCE && m->facts & WIRE_FACT_MANIFOLD)
        FAIL(WIRE_UNSUPPORTED, "accuracy is %u: manifolds need 0, by tolerance", m->accuracy);
    if (m->accuracy == WIRE_BY_VERDICT && m->facts & WIRE_FACT_DISTANCE)
        FAIL(WIRE_UNSUPPORTED, "accuracy is %u: distances need 0, by tolerance, or 1, by boxes", m->accuracy);
    return WIRE_OK;
}

static wire_reason check_interest(const wire_interest *m, wire_refusal *why)
{
    int32_t known = WIRE_FACT_TOUCH | WIRE_FACT_DISTANCE | WIRE_FACT_MANIFOLD | WIRE_FACT_IMPACT | WIRE_FACT_FORETELL;
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("interest", m->interest, 0, INT32_MAX, why));
    TRY(check_between("removed", m->removed, 0, 1, why));
    if (m->removed) return WIRE_OK;
    TRY(check_between("facts", m->facts, 1, known, why));
    TRY(check_stream(m->stream, why));
    TRY(check_pattern("select_a", m->select_a, why));
    TRY(check_pattern("select_b", m->select_b, why));
    TRY(check_magnitudes("threshold_m", (wire_f64s){1, &m->threshold_m}, WIRE_SIZE_MAX, why));
    TRY(check_magnitudes("range_m", (wire_f64s){1, &m->range_m}, WIRE_SIZE_MAX, why));
    TRY(check_at_least("range_m", m->range_m, 0, why));
    TRY(check_at_least("hysteresis_m", m->hysteresis_m, 0, why));
    TRY(check_magnitudes("hysteresis_m", (wire_f64s){1, &m->hysteresis_m}, WIRE_SIZE_MAX, why));
    TRY(check_accuracy(m, why));
    TRY(check_horizon(m, why));
    return check_at_least("rate_hz", m->rate_hz, 0, why);
}

static wire_reason check_direction(wire_f64s d, wire_refusal *why)
{
    if (d.count != 3 || d.at[0] != 0 || d.at[1] != 0 || d.at[2] != 0) return WIRE_OK;
    FAIL(WIRE_BAD_NUMBER, "direction is 0 0 0: it must point somewhere");
}

/* Which of the arrays a kind of query needs. */
static wire_reason check_query_needs(const wire_query *m, wire_refusal *why)
{
    bool origin = m->kind == WIRE_QUERY_RAY || m->kind == WIRE_QUERY_BOX || m->kind == WIRE_QUERY_CAST ||
                  (m->kind == WIRE_QUERY_NEAREST && !*m->name_a);
    bool direction = m->kind == WIRE_QUERY_RAY || m->kind == WIRE_QUERY_CAST;
    bool pair = m->kind == WIRE_QUERY_DISTANCE || m->kind == WIRE_QUERY_EXPLAIN;
    if (m->kind == WIRE_QUERY_SWEEP) TRY(check_name("name_a", m->name_a, why));
    if (origin) TRY(check_count("origin", m->origin.count, 3, 1, why));
    if (direction) TRY(check_count("direction", m->direction.count, 3, 1, why));
    if (m->kind == WIRE_QUERY_BOX) TRY(check_count("half", m->half.count, 3, 1, why));
    if (m->kind == WIRE_QUERY_BODIES) TRY(check_pattern("name_a", m->name_a, why));
    if (pair) TRY(check_name("name_a", m->name_a, why));
    if (pair) TRY(check_name("name_b", m->name_b, why));
    return WIRE_OK;
}

static wire_reason check_sweep(const wire_query *m, wire_refusal *why)
{
    TRY(check_optional("linear", m->linear.count, 3, 1, why));
    TRY(check_optional("angular", m->angular.count, 3, 1, why));
    TRY(check_magnitudes("linear", m->linear, WIRE_SPEED_MAX, why));
    TRY(check_magnitudes("angular", m->angular, WIRE_SPIN_MAX, why));
    TRY(check_at_least("span_s", m->span_s, 0, why));
    bool sweeps = m->kind == WIRE_QUERY_SWEEP;
    if (m->span_s > WIRE_SPAN_MAX || (sweeps && m->span_s == 0))
        FAIL(WIRE_BAD_SIZE, "span_s is %g s: %s 0 and at most %g is allowed", m->span_s, sweeps ? "above" : "at least",
            WIRE_SPAN_MAX);
    return WIRE_OK;
}

static wire_reason check_query(const wire_query *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("kind", m->kind, WIRE_QUERY_RAY, WIRE_QUERY_SWEEP, why));
    TRY(check_label("name_a", m->name_a, why));
    TRY(check_label("name_b", m->name_b, why));
    TRY(check_optional("origin", m->origin.count, 3, 1, why));
    TRY(check_optional("orientation", m->orientation.count, 4, 1, why));
    TRY(check_optional("half", m->half.count, 3, 1, why));
    TRY(check_optional("direction", m->direction.count, 3, 1, why));
    TRY(check_query_needs(m, why));
    TRY(check_magnitudes("origin", m->origin, WIRE_POSITION_MAX, why));
    if (m->orientation.count) TRY(check_rotation("orientation", 0, m->orientation.at, why));
    for (uint32_t i = 0; i < m->half.count; i++)
        if (m->half.at[i] < 0 || m->half.at[i] > WIRE_SIZE_MAX)
            FAIL(WIRE_BAD_SIZE, "half[%u] is %g m: 0 to %g is allowed", i, m->half.at[i], WIRE_SIZE_MAX);
    TRY(check_direction(m->direction, why));
    TRY(check_at_least("length_m", m->length_m, 0, why));
    TRY(check_at_least("tolerance_m", m->tolerance_m, 0, why));
    TRY(check_sweep(m, why));
    return check_between("most", m->most, 0, WIRE_ANSWERS_MAX, why);
}

static wire_reason check_intervals(wire_f64s lo, wire_f64s hi, wire_refusal *why)
{
    for (uint32_t i = 0; i < lo.count && i < hi.count; i++)
        if (lo.at[i] > hi.at[i]) FAIL(WIRE_BAD_NUMBER, "lo[%u] is %g, above hi %g", i, lo.at[i], hi.at[i]);
    return WIRE_OK;
}

static wire_reason check_answer(const wire_answer *m, wire_refusal *why)
{
    uint32_t n = m->names_a.count;
    TRY(check_between("kind", m->kind, WIRE_QUERY_RAY, WIRE_QUERY_SWEEP, why));
    TRY(check_between("status", m->status, WIRE_ANSWER_OK, WIRE_ANSWER_TRUNCATED, why));
    TRY(check_optional("names_b", m->names_b.count, 1, n, why));
    TRY(check_optional("lo", m->lo.count, 1, n, why));
    TRY(check_count("hi", m->hi.count, 1, m->lo.count, why));
    TRY(check_optional("axes", m->axes.count, 3, n, why));
    TRY(check_optional("points_a", m->points_a.count, 3, n, why));
    TRY(check_optional("points_b", m->points_b.count, 3, n, why));
    TRY(check_optional("orientations", m->orientations.count, 4, n, why));
    TRY(check_optional("ages_ns", m->ages_ns.count, 1, n, why));
    TRY(check_optional("stale", m->stale.count, 1, n, why));
    TRY(check_all_between("stale", m->stale, 0, 1, why));
    TRY(check_optional("achieved", m->achieved.count, 1, n, why));
    TRY(check_all_between("achieved", m->achieved, WIRE_CERTAIN, WIRE_STOPPED, why));
    return check_intervals(m->lo, m->hi, why);
}

static wire_reason check_event_counts(const wire_event_batch *m, wire_refusal *why)
{
    uint32_t n = m->kinds.count;
    TRY(check_count("causes", m->causes.count, 1, n, why));
    TRY(check_count("contacts", m->contacts.count, 1, n, why));
    TRY(check_count("names_a", m->names_a.count, 1, n, why));
    TRY(check_count("names_b", m->names_b.count, 1, n, why));
    TRY(check_count("shapes_a", m->shapes_a.count, 1, n, why));
    TRY(check_count("shapes_b", m->shapes_b.count, 1, n, why));
    TRY(check_count("lo", m->lo.count, 1, n, why));
    TRY(check_count("hi", m->hi.count, 1, n, why));
    TRY(check_count("axes", m->axes.count, 3, n, why));
    TRY(check_count("points_a", m->points_a.count, 3, n, why));
    TRY(check_count("points_b", m->points_b.count, 3, n, why));
    TRY(check_count("ages_a_ns", m->ages_a_ns.count, 1, n, why));
    TRY(check_count("ages_b_ns", m->ages_b_ns.count, 1, n, why));
    TRY(check_count("closings", m->closings.count, 1, n, why));
    TRY(check_count("achieved", m->achieved.count, 1, n, why));
    return check_count("manifold_counts", m->manifold_counts.count, 1, n, why);
}

static wire_reason check_manifolds(const wire_event_batch *m, wire_refusal *why)
{
    uint32_t points = 0;
    TRY(check_all_between("manifold_counts", m->manifold_counts, 0, 4, why));
    for (uint32_t i = 0; i < m->manifold_counts.count; i++) points += m->manifold_counts.at[i];
    TRY(check_count("manifold_points", m->manifold_points.count, 3, points, why));
    TRY(check_count("manifold_distances", m->manifold_distances.count, 1, points, why));
    return check_count("manifold_features", m->manifold_features.count, 1, points, why);
}

static wire_reason check_impacts(const wire_event_batch *m, wire_refusal *why)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < m->kinds.count; i++)
        n += m->kinds.at[i] == WIRE_EVENT_IMPACT || m->kinds.at[i] == WIRE_EVENT_FORETOLD;
    TRY(check_count("impact_times", m->impact_times.count, 2, n, why));
    TRY(check_count("impact_starts_ns", m->impact_starts_ns.count, 1, n, why));
    TRY(check_count("impact_poses", m->impact_poses.count, 14, n, why));
    TRY(check_count("impact_estimated", m->impact_estimated.count, 1, n, why));
    TRY(check_all_between("impact_estimated", m->impact_estimated, 0, 1, why));
    return check_poses("impact_poses", m->impact_poses, why);
}

static wire_reason check_event_batch(const wire_event_batch *m, wire_refusal *why)
{
    TRY(check_between("batch", m->batch, 1, INT64_MAX, why));
    TRY(check_between("snapshot", m->snapshot, 0, 1, why));
    TRY(check_between("closing", m->closing, 0, 1, why));
    TRY(check_between("undone", m->undone, 0, INT64_MAX, why));
    TRY(check_between("missing", m->missing, 0, INT32_MAX, why));
    TRY(check_between("heartbeat", m->heartbeat, 0, 1, why));
    if (m->heartbeat) TRY(check_count("kinds", m->kinds.count, 0, 0, why));
    TRY(check_between("parts", m->parts, 1, INT32_MAX, why));
    TRY(check_between("part", m->part, 0, m->parts - 1, why));
    TRY(check_name("stream", m->stream, why));
    TRY(check_stream(m->stream, why));
    TRY(check_event_counts(m, why));
    TRY(check_all_between("kinds", m->kinds, WIRE_EVENT_BEGIN, WIRE_EVENT_AVERTED, why));
    TRY(check_all_between("causes", m->causes, WIRE_CAUSE_MOTION, WIRE_CAUSE_TELEPORT, why));
    TRY(check_all_between("achieved", m->achieved, WIRE_CERTAIN, WIRE_STOPPED, why));
    TRY(check_intervals(m->lo, m->hi, why));
    TRY(check_impacts(m, why));
    return check_manifolds(m, why);
}

static wire_reason check_status(const wire_status *m, wire_refusal *why)
{
    TRY(check_between("health", m->health, WIRE_HEALTH_STARTING, WIRE_HEALTH_STOPPING, why));
    return check_count("counter_values", m->counter_values.count, 1, m->counter_names.count, why);
}

static wire_reason check_reject(const wire_reject *m, wire_refusal *why)
{
    TRY(check_between("kind", m->kind, WIRE_NOTHING, WIRE_KIND_COUNT - 1, why));
    TRY(check_between("object", m->object, -1, INT32_MAX, why));
    return check_between("reason", m->reason, WIRE_WRONG_VERSION, WIRE_REASON_COUNT - 1, why);
}

static wire_reason check_ack(const wire_ack *m, wire_refusal *why)
{
    if (m->client == 0) FAIL(WIRE_UNKNOWN_CLIENT, "client is 0: any other number is allowed");
    return WIRE_OK;
}

static wire_reason check_own_rules(const wire_message *m, wire_refusal *why)
{
    switch (m->kind) {
    case WIRE_CLIENT:
        return check_client(&m->client, why);
    case WIRE_GEOMETRY:
        return check_geometry(&m->geometry, why);
    case WIRE_BODY:
        return check_body(&m->body, why);
    case WIRE_POSE_BATCH:
        return check_pose_batch(&m->pose_batch, why);
    case WIRE_VERTEX_BATCH:
        return check_vertex_batch(&m->vertex_batch, why);
    case WIRE_INTEREST:
        return check_interest(&m->interest, why);
    case WIRE_QUERY:
        return check_query(&m->query, why);
    case WIRE_ANSWER:
        return check_answer(&m->answer, why);
    case WIRE_EVENT_BATCH:
        return check_event_batch(&m->event_batch, why);
    case WIRE_STATUS:
        return check_status(&m->status, why);
    case WIRE_REJECT:
        return check_reject(&m->reject, why);
    case WIRE_ACK:
        return check_ack(&m->ack, why);
    case WIRE_NOTHING:
    case WIRE_KIND_COUNT:
        break;
    }
    FAIL(WIRE_MALFORMED, "no such kind of message");
}

wire_reason wire_check(const wire_message *m, wire_refusal *refusal)
{
    wire_refusal *why = refusal;
    const wire_schema *s = wire_schema_of(m->kind);
    if (!s) FAIL(WIRE_MALFORMED, "no such kind of message: %d", (int)m->kind);
    if (m->version != WIRE_VERSION) FAIL(WIRE_WRONG_VERSION, "version is %d: it must be %d", m->version, WIRE_VERSION);
    for (uint32_t i = 0; i < s->field_count; i++) TRY(check_field(&s->fields[i], wire_field_at(m, &s->fields[i]), why));
    TRY(check_own_rules(m, why));
    *why = (wire_refusal){WIRE_OK, ""};
    return WIRE_OK;
}
