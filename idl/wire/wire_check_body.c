/* wire_check_body: the rules of Geometry and Body: pieces, kinds, sizes of shapes, compounds, rules. Pure; any thread.
 */
#include "wire_rules.h"

#include <inttypes.h>
#include <string.h>

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
    case WIRE_GEOMETRY_SOFT:
        if (!triples || m->vertex_numbers < WIRE_SOFT_HEAD + 3 || m->index_numbers < 3)
            FAIL(WIRE_MALFORMED,
                "a soft surface has ring, rest exclusion, 0, three numbers a vertex and a triangle, and at least one");
        return WIRE_OK;
    default:
        FAIL(WIRE_MALFORMED, "kind is %u: 1 to 4 is allowed", m->kind);
    }
}

static wire_reason check_indices(const wire_geometry *m, wire_refusal *why)
{
    bool soft = m->kind == WIRE_GEOMETRY_SOFT, indexed = soft || m->kind == WIRE_GEOMETRY_MESH;
    int32_t vertices = m->vertex_numbers / 3 - (soft ? 1 : 0);
    for (uint32_t i = 0; indexed && i < m->indices.count; i++)
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

static wire_reason check_soft_surface(const wire_geometry *m, wire_refusal *why)
{
    if (m->piece != 0) return WIRE_OK;
    const double *head = m->vertices.at;
    if (!(head[0] >= 0 && head[0] <= WIRE_SOFT_RING_MAX && head[0] == (int)head[0]))
        FAIL(WIRE_BAD_SIZE, "vertices[0], the ring of a soft surface, is %g: a whole number from 0 to %d is allowed",
            head[0], WIRE_SOFT_RING_MAX);
    if (!(head[1] >= 0))
        FAIL(WIRE_BAD_SIZE, "vertices[1], the rest exclusion of a soft surface, is %g m: at least 0 is allowed",
            head[1]);
    if (head[2] != 0) FAIL(WIRE_BAD_SIZE, "vertices[2] of a soft surface is %g: it must be 0", head[2]);
    return WIRE_OK;
}

wire_reason check_geometry(const wire_geometry *m, wire_refusal *why)
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
    if (m->kind == WIRE_GEOMETRY_SOFT) TRY(check_soft_surface(m, why));
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
    [WIRE_SHAPE_SOFT] = {"soft surface", .geometry = true},
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

/* Its vertices are in the world, each where it is. */
static wire_reason check_soft(const wire_body *m, uint32_t i, wire_refusal *why)
{
    static const double IDENTITY[7] = {0, 0, 0, 1, 0, 0, 0};
    if (m->shape_types.count != 1) FAIL(WIRE_MALFORMED, "shape_types[%u]: a soft surface is its body's only shape", i);
    for (int k = 0; k < 7; k++)
        if (m->shape_poses.at[k] != IDENTITY[k])
            FAIL(WIRE_MALFORMED, "shape_poses[%d] is %g: a soft surface is at the identity", k, m->shape_poses.at[k]);
    if (m->shape_deviations.count && m->shape_deviations.at[0] != 0)
        FAIL(WIRE_UNSUPPORTED, "shape_deviations[0] is %g m: a soft surface has none", m->shape_deviations.at[0]);
    if (m->ccd != WIRE_CCD_OFF) FAIL(WIRE_UNSUPPORTED, "ccd is %u: the way of a soft body is always swept", m->ccd);
    return WIRE_OK;
}

static wire_reason check_shapes(const wire_body *m, wire_refusal *why)
{
    uint32_t n = m->shape_types.count;
    if (n == 0) FAIL(WIRE_MALFORMED, "shape_types is empty: 1 to %d shapes are allowed", WIRE_SHAPES_MAX);
    TRY(check_all_between("shape_types", m->shape_types, WIRE_SHAPE_SPHERE, WIRE_SHAPE_SOFT, why));
    TRY(check_count("shape_sizes", m->shape_sizes.count, 3, n, why));
    TRY(check_count("shape_radii", m->shape_radii.count, 1, n, why));
    TRY(check_optional("shape_deviations", m->shape_deviations.count, 1, n, why));
    TRY(check_count("shape_poses", m->shape_poses.count, 7, n, why));
    TRY(check_count("shape_geometries", m->shape_geometries.count, 1, n, why));
    for (uint32_t i = 0; i < n; i++) TRY(check_shape(m, i, why));
    for (uint32_t i = 0; i < n; i++)
        if (m->shape_types.at[i] == WIRE_SHAPE_COMPOUND) TRY(check_children(m, i, &i, why));
    for (uint32_t i = 0; i < n; i++)
        if (m->shape_types.at[i] == WIRE_SHAPE_SOFT) TRY(check_soft(m, i, why));
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

wire_reason check_body(const wire_body *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("body_id", m->body, 0, INT32_MAX, why));
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
    TRY(check_between("stamp_is_now", m->stamp_is_now, 0, 1, why));
    TRY(check_count("pose", m->pose.count, 7, 1, why));
    TRY(check_poses("pose", m->pose, why));
    TRY(check_shapes(m, why));
    TRY(check_rules(m, why));
    return check_model(m, why);
}
