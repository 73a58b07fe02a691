/* Every rule of wire_check with a case on each side of it: what is refused tells its reason, its field and what is
 * allowed. Rules of single fields and of bodies; test_wire_check_more.c has those of the daemon's messages, and limits.
 */
#include "plain.h"

#include <math.h>
#include <string.h>

static void the_plain_messages_are_legal(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) ACCEPTED((wire_kind)kind, (void)m);
    REFUSED(WIRE_NOTHING, (void)m, WIRE_MALFORMED, "no such kind");
    REFUSED(WIRE_CLIENT, m.kind = WIRE_KIND_COUNT, WIRE_MALFORMED, "no such kind");
}

static void another_version_is_refused(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        REFUSED((wire_kind)kind, m.version = WIRE_VERSION + 1, WIRE_WRONG_VERSION, "version is 2: it must be 1");
        REFUSED((wire_kind)kind, m.version = 0, WIRE_WRONG_VERSION, "version is 0");
    }
}

static void clients_have_a_number_and_count_their_messages(void **state)
{
    (void)state;
    static const wire_kind from_clients[] = {WIRE_CLIENT, WIRE_GEOMETRY, WIRE_BODY, WIRE_POSE_BATCH, WIRE_VERTEX_BATCH,
        WIRE_SUBSCRIPTION, WIRE_QUERY, WIRE_RECEIPT};
    for (size_t i = 0; i < sizeof from_clients / sizeof *from_clients; i++) {
        wire_kind kind = from_clients[i];
        ACCEPTED(kind, m.client.client = -1);
        REFUSED(kind, m.client.client = 0, WIRE_UNKNOWN_CLIENT, "client_id is 0");
        ACCEPTED(kind, m.client.sequence = INT64_MAX);
        REFUSED(kind, m.client.sequence = 0, WIRE_MALFORMED, "sequence is 0: 1 to");
        REFUSED(kind, m.client.sequence = -1, WIRE_MALFORMED, "sequence is -1");
    }
}

static void client_rules(void **state)
{
    (void)state;
    ACCEPTED(WIRE_CLIENT, m.client.on_loss = WIRE_LOST_KEEP);
    REFUSED(WIRE_CLIENT, m.client.on_loss = 3, WIRE_MALFORMED, "on_loss is 3: 0 to 2");
    REFUSED(WIRE_CLIENT, m.client.lease_ns = 0, WIRE_MALFORMED, "lease_ns is 0: 1 to");
    ACCEPTED(WIRE_CLIENT, m.client.lock_step = WIRE_LOCK_STEP_MAX);
    REFUSED(WIRE_CLIENT, m.client.lock_step = WIRE_LOCK_STEP_MAX + 1, WIRE_MALFORMED, "lock_step is 65537: 0 to 65536");
    REFUSED(WIRE_CLIENT, m.client.removed = 2, WIRE_MALFORMED, "removed is 2: 0 to 1");
    ACCEPTED(WIRE_CLIENT, m.client.name = "");
    ACCEPTED(WIRE_CLIENT, m.client.name = plain_text(WIRE_NAME_MAX));
    REFUSED(WIRE_CLIENT, m.client.name = plain_text(WIRE_NAME_MAX + 1), WIRE_TOO_LARGE, "the allowed 127 bytes");
    REFUSED(WIRE_CLIENT, m.client.name = "a\nb", WIRE_BAD_NAME, "control characters");
    ACCEPTED(WIRE_CLIENT, (m.client.removed = 1, m.client.lease_ns = 0));
}

/* Overlong forms, surrogates, beyond Unicode, cut in the middle: each is a way past somebody's filter. */
static void texts_are_utf8(void **state)
{
    (void)state;
    static const char *const good[] = {"\x7e", "\xc2\xa0", "\xdf\xbf", "\xe0\xa0\x80", "\xed\x9f\xbf", "\xee\x80\x80",
        "\xf0\x90\x80\x80", "\xf4\x8f\xbf\xbf"};
    static const char *const bad[] = {"\x80", "\xbf", "\xc0\x80", "\xc1\xbf", "\xc2", "\xc2\x20", "\xe0\x9f\xbf",
        "\xe2\x82", "\xed\xa0\x80", "\xef\xbf\x20", "\xf0\x8f\xbf\xbf", "\xf0\x90\x80", "\xf4\x90\x80\x80", "\xf5\x80",
        "\xff"};
    for (size_t i = 0; i < sizeof good / sizeof *good; i++) ACCEPTED(WIRE_BODY, m.body.name = good[i]);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        REFUSED(WIRE_BODY, m.body.name = bad[i], WIRE_MALFORMED, "is not UTF-8");
    REFUSED(WIRE_BODY, plain.texts[1] = "\xff", WIRE_MALFORMED, "rule_patterns (text 1) is not UTF-8");
    REFUSED(WIRE_BODY, m.body.name = "a\x7f", WIRE_BAD_NAME, "control");
    REFUSED(WIRE_BODY, m.body.name = "\xc2\x85", WIRE_BAD_NAME, "control");
}

static void geometry_rules(void **state)
{
    (void)state;
    REFUSED(WIRE_GEOMETRY, m.geometry.hash = 0, WIRE_BAD_HASH, "hash is 0");
    REFUSED(WIRE_GEOMETRY, m.geometry.hash++, WIRE_BAD_HASH, "does not have the hash");
    REFUSED(WIRE_GEOMETRY, plain.vertices[4] = 1e-300, WIRE_BAD_HASH, "does not have the hash");
    REFUSED(WIRE_GEOMETRY, m.geometry.kind = 0, WIRE_MALFORMED, "kind is 0: 1 to 4");
    REFUSED(WIRE_GEOMETRY, m.geometry.kind = 5, WIRE_MALFORMED, "kind is 5");
    REFUSED(WIRE_GEOMETRY, m.geometry.removed = 2, WIRE_MALFORMED, "removed");
    ACCEPTED(WIRE_GEOMETRY, (m.geometry.removed = 1, m.geometry.kind = 0));
    REFUSED(WIRE_GEOMETRY, m.geometry.pieces = 2, WIRE_MALFORMED, "pieces is 2: 1 to 1");
    REFUSED(WIRE_GEOMETRY, m.geometry.piece = 1, WIRE_MALFORMED, "piece is 1: 0 to 0");
    REFUSED(WIRE_GEOMETRY, m.geometry.piece = -1, WIRE_MALFORMED, "piece is -1");
    REFUSED(WIRE_GEOMETRY, m.geometry.vertices.count = 9, WIRE_MALFORMED, "vertices has 9");
    REFUSED(WIRE_GEOMETRY, m.geometry.indices.count = 5, WIRE_MALFORMED, "indices has 5");
    REFUSED(WIRE_GEOMETRY, m.geometry.vertex_numbers = -3, WIRE_MALFORMED, "vertex_numbers is -3");
    REFUSED(WIRE_GEOMETRY, m.geometry.index_numbers = -3, WIRE_MALFORMED, "index_numbers is -3");
    REFUSED(WIRE_GEOMETRY, m.geometry.vertex_numbers = 11, WIRE_MALFORMED, "three numbers");
    REFUSED(WIRE_GEOMETRY, m.geometry.index_numbers = 0, WIRE_MALFORMED, "at least one triangle");
    REFUSED(WIRE_GEOMETRY, plain.indices[1] = 4, WIRE_MALFORMED, "indices[1] is 4: 0 to 3");
    REFUSED(WIRE_GEOMETRY, plain.indices[2] = -1, WIRE_MALFORMED, "indices[2] is -1");
    REFUSED(WIRE_GEOMETRY, plain.vertices[0] = 2e9, WIRE_TOO_LARGE, "vertices[0] is 2e+09");
    REFUSED(WIRE_GEOMETRY, plain.vertices[0] = NAN, WIRE_BAD_NUMBER, "vertices[0] is not a number");
}

/* A hull or height field of the plain mesh's vertices. */
static wire_message solid(uint8_t kind, int32_t vertex_numbers, int32_t index_numbers)
{
    wire_message m = plain_message(WIRE_GEOMETRY);
    wire_geometry *g = &m.geometry;
    plain.indices[0] = plain.indices[1] = 2;
    for (int i = 0; kind == WIRE_GEOMETRY_HEIGHT_FIELD && i < WIRE_FIELD_HEAD; i++) plain.vertices[i] = 0.5;
    g->kind = kind;
    g->vertex_numbers = vertex_numbers;
    g->index_numbers = index_numbers;
    g->vertices.count = (uint32_t)vertex_numbers;
    g->indices.count = (uint32_t)index_numbers;
    g->hash = wire_geometry_hash(g->kind, g->vertices, g->indices);
    return m;
}

static void geometry_kinds_have_their_numbers(void **state)
{
    (void)state;
    ACCEPTED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HULL, 12, 0));
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HULL, 9, 0), WIRE_FLAT_HULL, "at least 4 points");
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HULL, 12, 3), WIRE_MALFORMED, "no indices");
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HULL, 10, 0), WIRE_MALFORMED, "three numbers");
    ACCEPTED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_MESH, 9, 3));
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_MESH, 6, 3), WIRE_MALFORMED, "at least one triangle");
}

static void height_fields_have_their_numbers(void **state)
{
    (void)state;
    const int32_t n = WIRE_FIELD_HEAD + 4;
    ACCEPTED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2));
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n - 1, 2), WIRE_MALFORMED, "height field");
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 3), WIRE_MALFORMED, "columns, rows");
    REFUSED(WIRE_GEOMETRY, m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n + 1, 2), WIRE_MALFORMED,
        "2 columns and 2 rows are not 5 heights");
    REFUSED(WIRE_GEOMETRY, (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.indices[0] = 4, plain.indices[1] = 1),
        WIRE_MALFORMED, "4 columns and 1 rows: at least 2");
    REFUSED(WIRE_GEOMETRY, (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.indices[0] = -2), WIRE_MALFORMED,
        "-2 columns");
    REFUSED(WIRE_GEOMETRY,
        (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.indices[0] = plain.indices[1] = INT32_MAX), WIRE_MALFORMED,
        "are not 4 heights");
    REFUSED(WIRE_GEOMETRY, (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.vertices[0] = 0), WIRE_BAD_SIZE,
        "vertices[0], the spacing x");
    REFUSED(WIRE_GEOMETRY, (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.vertices[1] = -1), WIRE_BAD_SIZE,
        "vertices[1], the spacing y of a height field, is -1 m");
    REFUSED(WIRE_GEOMETRY, (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.vertices[2] = 0), WIRE_BAD_SIZE,
        "vertices[2], the base");
    REFUSED(WIRE_GEOMETRY, (m = solid(WIRE_GEOMETRY_HEIGHT_FIELD, n, 2), plain.vertices[5] = NAN), WIRE_BAD_NUMBER,
        "vertices[5] is not a number");
}

static void body_rules(void **state)
{
    (void)state;
    ACCEPTED(WIRE_BODY, m.body.body = INT32_MAX);
    REFUSED(WIRE_BODY, m.body.body = -1, WIRE_MALFORMED, "body_id is -1");
    ACCEPTED(WIRE_BODY, (m.body.removed = 1, m.body.name = "", m.body.shape_types.count = 0));
    REFUSED(WIRE_BODY, m.body.removed = 2, WIRE_MALFORMED, "removed");
    ACCEPTED(WIRE_BODY, m.body.motion = WIRE_MOTION_FIXED);
    REFUSED(WIRE_BODY, m.body.motion = 2, WIRE_MALFORMED, "motion is 2: 0 to 1");
    ACCEPTED(WIRE_BODY, m.body.ccd = WIRE_CCD_FULL);
    REFUSED(WIRE_BODY, m.body.ccd = 3, WIRE_MALFORMED, "ccd is 3: 0 to 2");
    ACCEPTED(WIRE_BODY, m.body.stamp_is_now = 1);
    REFUSED(WIRE_BODY, m.body.stamp_is_now = 2, WIRE_MALFORMED, "stamp_is_now is 2: 0 to 1");
    ACCEPTED(WIRE_BODY, m.body.one_way = 1);
    REFUSED(WIRE_BODY, m.body.one_way = 2, WIRE_MALFORMED, "one_way is 2: 0 to 1");
    REFUSED(WIRE_BODY, m.body.name = "", WIRE_BAD_NAME, "name is empty");
    REFUSED(WIRE_BODY, m.body.name = NULL, WIRE_BAD_NAME, "name is empty");
    REFUSED(WIRE_BODY, m.body.group = "a\tb", WIRE_BAD_NAME, "group must not have control");
    REFUSED(WIRE_BODY, m.body.deadline_ns = -1, WIRE_MALFORMED, "deadline_ns is -1");
    REFUSED(WIRE_BODY, m.body.stamp_ns = -1, WIRE_MALFORMED, "stamp_ns is -1");
    REFUSED(WIRE_BODY, m.body.pose.count = 6, WIRE_MALFORMED, "pose has 6");
    REFUSED(WIRE_BODY, m.body.shape_types.count = 0, WIRE_MALFORMED, "shape_types is empty");
    REFUSED(WIRE_BODY, plain.types[1] = 12, WIRE_MALFORMED, "shape_types[1] is 12: 0 to 11");
    REFUSED(WIRE_BODY, m.body.shape_sizes.count = 3, WIRE_MALFORMED, "shape_sizes has 3");
    REFUSED(WIRE_BODY, m.body.shape_radii.count = 1, WIRE_MALFORMED, "shape_radii has 1");
    ACCEPTED(WIRE_BODY, m.body.shape_deviations.count = 0);
    REFUSED(WIRE_BODY, m.body.shape_deviations.count = 1, WIRE_MALFORMED, "shape_deviations has 1");
    REFUSED(WIRE_BODY, plain.deviations[1] = -0.1, WIRE_BAD_SIZE, "shape_deviations[1] is -0.1");
    REFUSED(WIRE_BODY, m.body.shape_poses.count = 7, WIRE_MALFORMED, "shape_poses has 7");
    REFUSED(WIRE_BODY, m.body.shape_geometries.count = 0, WIRE_MALFORMED, "shape_geometries has 0");
}

static void body_filter_rules(void **state)
{
    (void)state;
    ACCEPTED(WIRE_BODY, plain.actions[1] = WIRE_RULE_CHECK);
    REFUSED(WIRE_BODY, plain.actions[1] = 2, WIRE_MALFORMED, "rule_actions[1] is 2: 0 to 1");
    REFUSED(WIRE_BODY, m.body.rule_actions.count = 1, WIRE_MALFORMED, "rule_actions has 1");
    REFUSED(WIRE_BODY, m.body.rule_reasons.count = 1, WIRE_MALFORMED, "rule_reasons has 1");
    REFUSED(WIRE_BODY, m.body.rule_paddings.count = 1, WIRE_MALFORMED, "rule_paddings has 1");
    REFUSED(WIRE_BODY, m.body.rule_margins.count = 0, WIRE_MALFORMED, "rule_margins has 0");
    ACCEPTED(WIRE_BODY, plain.paddings[1] = -WIRE_SIZE_MAX);
    REFUSED(WIRE_BODY, plain.paddings[1] = 2 * WIRE_SIZE_MAX, WIRE_TOO_LARGE, "rule_paddings");
    REFUSED(WIRE_BODY, plain.paddings[1] = NAN, WIRE_BAD_NUMBER, "rule_paddings");
    ACCEPTED(WIRE_BODY, plain.margins[1] = WIRE_SIZE_MAX);
    REFUSED(WIRE_BODY, plain.margins[1] = -0.001, WIRE_BAD_NUMBER, "a rule's margin is -0.001: at least 0");
    ACCEPTED(WIRE_BODY, plain.texts[0] = "group:g");
    REFUSED(WIRE_BODY, plain.texts[0] = "group:", WIRE_BAD_NAME, "without the group's name");
    REFUSED(WIRE_BODY, plain.texts[0] = "", WIRE_BAD_NAME, "a rule's pattern is empty");
    ACCEPTED(WIRE_BODY, plain.texts[0] = plain_text(WIRE_NAME_MAX));
    REFUSED(WIRE_BODY, plain.texts[0] = plain_text(WIRE_NAME_MAX + 1), WIRE_TOO_LARGE, "a rule's pattern");
}

static void poses_are_finite_near_and_turned(void **state)
{
    (void)state;
    ACCEPTED(WIRE_BODY, plain.pose[2] = -WIRE_POSITION_MAX);
    REFUSED(WIRE_BODY, plain.pose[2] = nextafter(-WIRE_POSITION_MAX, -INFINITY), WIRE_TOO_LARGE, "pose[2] is");
    REFUSED(WIRE_BODY, plain.pose[0] = NAN, WIRE_BAD_NUMBER, "pose[0] is not a number");
    REFUSED(WIRE_BODY, plain.pose[6] = INFINITY, WIRE_BAD_NUMBER, "pose[6] is infinite");
    REFUSED(WIRE_BODY, plain.pose[3] = 0, WIRE_BAD_ROTATION, "pose[3..6] has the norm 0: 0.5 to 2");
    ACCEPTED(WIRE_BODY, plain.pose[3] = 0.5);
    REFUSED(WIRE_BODY, plain.pose[3] = 0.499, WIRE_BAD_ROTATION, "pose[3..6]");
    ACCEPTED(WIRE_BODY, plain.pose[3] = -2);
    REFUSED(WIRE_BODY, plain.pose[3] = 2.001, WIRE_BAD_ROTATION, "pose[3..6]");
    REFUSED(WIRE_BODY, plain.pose[3] = 1e200, WIRE_BAD_ROTATION, "pose[3..6]");
    REFUSED(WIRE_BODY, plain.shape_poses[11] = 0, WIRE_BAD_ROTATION, "shape_poses[10..13]");
    REFUSED(WIRE_BODY, plain.shape_poses[7] = 1e13, WIRE_TOO_LARGE, "shape_poses[7]");
}

/* The first shape becomes one of this type with these sizes. */
static void set_shape(uint8_t type, double x, double y, double z, double radius)
{
    plain.types[0] = type;
    memcpy(plain.sizes, (double[]){x, y, z}, 3 * sizeof(double));
    plain.radii[0] = radius;
    plain.geometries[0] = type >= WIRE_SHAPE_HULL;
}
#define SHAPE(...) set_shape(__VA_ARGS__)
#define SHAPE_OK(...) ACCEPTED(WIRE_BODY, SHAPE(__VA_ARGS__))
#define SHAPE_BAD(words, ...) REFUSED(WIRE_BODY, SHAPE(__VA_ARGS__), WIRE_BAD_SIZE, words)

static void round_shapes_have_their_sizes(void **state)
{
    (void)state;
    SHAPE_OK(WIRE_SHAPE_SPHERE, 0, 0, 0, WIRE_SIZE_MAX);
    SHAPE_BAD("above 0 and at most 1e+09", WIRE_SHAPE_SPHERE, 0, 0, 0, 0);
    SHAPE_BAD("shape_radii[0] is -1", WIRE_SHAPE_SPHERE, 0, 0, 0, -1);
    SHAPE_BAD("shape_radii[0] is 2e+09", WIRE_SHAPE_SPHERE, 0, 0, 0, 2e9);
    SHAPE_BAD("of a sphere it must be 0", WIRE_SHAPE_SPHERE, 0, 1, 0, 1);
    SHAPE_OK(WIRE_SHAPE_CAPSULE, 0, 0, 0, 1);
    SHAPE_OK(WIRE_SHAPE_CAPSULE, 0, 0, 1, 1);
    SHAPE_BAD("of a capsule it must be 0", WIRE_SHAPE_CAPSULE, 1, 0, 1, 1);
    SHAPE_BAD("shape_sizes[2] is -1 m", WIRE_SHAPE_CAPSULE, 0, 0, -1, 1);
    SHAPE_BAD("above 0", WIRE_SHAPE_CAPSULE, 0, 0, 1, 0);
    SHAPE_OK(WIRE_SHAPE_CYLINDER, 1, 1, 2, 0);
    SHAPE_BAD("a cylinder is round", WIRE_SHAPE_CYLINDER, 1, 2, 2, 0);
    SHAPE_OK(WIRE_SHAPE_CONE, 1, 1, 2, 0.1);
    SHAPE_BAD("a cone is round", WIRE_SHAPE_CONE, 1, 2, 2, 0);
    SHAPE_BAD("must be solid", WIRE_SHAPE_CONE, 0, 0, 2, 0);
    SHAPE_OK(WIRE_SHAPE_ELLIPSOID, 1, 2, 3, 0);
    SHAPE_BAD("must be solid", WIRE_SHAPE_ELLIPSOID, 1, 0, 3, 0);
}

static void flat_shapes_have_their_sizes(void **state)
{
    (void)state;
    SHAPE_OK(WIRE_SHAPE_BOX, 1e-300, 2, WIRE_SIZE_MAX, 0);
    SHAPE_BAD("shape_sizes[1] is 0: a box that is not rounded", WIRE_SHAPE_BOX, 1, 0, 1, 0);
    SHAPE_OK(WIRE_SHAPE_BOX, 1, 0, 1, 0.01);
    SHAPE_BAD("shape_sizes[0] is -1 m", WIRE_SHAPE_BOX, -1, 1, 1, 0);
    SHAPE_BAD("0 to 1e+09 is allowed", WIRE_SHAPE_BOX, 1, 1, nextafter(WIRE_SIZE_MAX, INFINITY), 0);
    REFUSED(WIRE_BODY, SHAPE(WIRE_SHAPE_BOX, 1, 1, NAN, 0), WIRE_BAD_NUMBER, "shape_sizes[2] is not a number");
    SHAPE_OK(WIRE_SHAPE_HALFSPACE, 0, 0, 0, 0);
    SHAPE_BAD("of a half-space it must be 0", WIRE_SHAPE_HALFSPACE, 1, 0, 0, 0);
    SHAPE_OK(WIRE_SHAPE_HULL, 0, 0, 0, 0.1);
    SHAPE_BAD("of a hull it must be 0", WIRE_SHAPE_HULL, 1, 0, 0, 0);
    SHAPE_OK(WIRE_SHAPE_MESH, 0, 0, 0, 0.1);
    SHAPE_BAD("of a mesh it must be 0", WIRE_SHAPE_MESH, 0, 0, 1, 0);
    SHAPE_OK(WIRE_SHAPE_HEIGHT_FIELD, 0, 0, 0, 0.1);
    SHAPE_BAD("of a height field it must be 0", WIRE_SHAPE_HEIGHT_FIELD, 1, 0, 0, 0);
    REFUSED(WIRE_BODY, (SHAPE(WIRE_SHAPE_HEIGHT_FIELD, 0, 0, 0, 0), plain.types[0] = WIRE_SHAPE_SOFT + 1),
        WIRE_MALFORMED, "shape_types[0]");
    REFUSED(WIRE_BODY, (SHAPE(WIRE_SHAPE_HULL, 0, 0, 0, 0), plain.geometries[0] = 0), WIRE_MALFORMED,
        "shape_geometries[0]: a hull needs one");
    REFUSED(WIRE_BODY, plain.geometries[0] = 5, WIRE_MALFORMED, "shape_geometries[0]: a box has none");
}

/* The plain body's first shape becomes a compound, its second the only child. */
static void set_compound(double count, uint8_t child)
{
    set_shape(WIRE_SHAPE_COMPOUND, count, 0, 0, 0);
    plain.geometries[0] = 0;
    plain.types[1] = child;
    plain.geometries[1] = child >= WIRE_SHAPE_HULL && child <= WIRE_SHAPE_HEIGHT_FIELD;
    if (child != WIRE_SHAPE_SPHERE) plain.radii[1] = 0;
}

static void compounds_are_followed_by_their_children(void **state)
{
    (void)state;
    ACCEPTED(WIRE_BODY, set_compound(1, WIRE_SHAPE_SPHERE));
    ACCEPTED(WIRE_BODY, set_compound(1, WIRE_SHAPE_HULL));
    ACCEPTED(WIRE_BODY, (set_compound(1, WIRE_SHAPE_SPHERE), plain.radii[0] = 0.1));
    REFUSED(WIRE_BODY, set_compound(0, WIRE_SHAPE_SPHERE), WIRE_BAD_SIZE, "shape_sizes[0] is 0");
    REFUSED(WIRE_BODY, (set_compound(0, WIRE_SHAPE_SPHERE), plain.radii[0] = 0.1), WIRE_BAD_SIZE,
        "shape_sizes[0] is 0: a compound's number of children");
    REFUSED(WIRE_BODY, set_compound(2, WIRE_SHAPE_SPHERE), WIRE_BAD_SIZE, "1 to the 1 shapes that follow it");
    REFUSED(WIRE_BODY, set_compound(0.5, WIRE_SHAPE_SPHERE), WIRE_BAD_SIZE, "shape_sizes[0] is 0.5");
    REFUSED(WIRE_BODY, set_compound(1e9, WIRE_SHAPE_SPHERE), WIRE_BAD_SIZE, "shape_sizes[0] is 1e+09");
    REFUSED(WIRE_BODY, (set_compound(1, WIRE_SHAPE_SPHERE), plain.sizes[1] = 1), WIRE_BAD_SIZE,
        "of a compound it must be 0");
    REFUSED(WIRE_BODY, (set_compound(1, WIRE_SHAPE_SPHERE), plain.geometries[0] = 7), WIRE_MALFORMED,
        "shape_geometries[0]: a compound has none");
    REFUSED(WIRE_BODY, set_compound(1, WIRE_SHAPE_HALFSPACE), WIRE_MALFORMED, "a half-space cannot be the child");
    REFUSED(WIRE_BODY, set_compound(1, WIRE_SHAPE_MESH), WIRE_MALFORMED, "shape_types[1]: a mesh cannot be the child");
    REFUSED(WIRE_BODY, set_compound(1, WIRE_SHAPE_HEIGHT_FIELD), WIRE_MALFORMED, "a height field cannot be the child");
    REFUSED(WIRE_BODY, (set_compound(1, WIRE_SHAPE_COMPOUND), plain.sizes[3] = 1), WIRE_MALFORMED,
        "a compound cannot be the child");
    REFUSED(WIRE_BODY,
        (set_compound(1, WIRE_SHAPE_SPHERE), plain.types[1] = WIRE_SHAPE_COMPOUND, plain.types[0] = WIRE_SHAPE_BOX,
            plain.sizes[1] = plain.sizes[2] = plain.sizes[3] = 1, plain.radii[1] = 0),
        WIRE_BAD_SIZE, "shape_sizes[3] is 1: a compound's number of children, 1 to the 0 shapes");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_plain_messages_are_legal),
        cmocka_unit_test(another_version_is_refused),
        cmocka_unit_test(clients_have_a_number_and_count_their_messages),
        cmocka_unit_test(client_rules),
        cmocka_unit_test(texts_are_utf8),
        cmocka_unit_test(geometry_rules),
        cmocka_unit_test(geometry_kinds_have_their_numbers),
        cmocka_unit_test(height_fields_have_their_numbers),
        cmocka_unit_test(body_rules),
        cmocka_unit_test(body_filter_rules),
        cmocka_unit_test(poses_are_finite_near_and_turned),
        cmocka_unit_test(round_shapes_have_their_sizes),
        cmocka_unit_test(flat_shapes_have_their_sizes),
        cmocka_unit_test(compounds_are_followed_by_their_children),
    };
    return cmocka_run_group_tests_name("wire_check", tests, NULL, NULL);
}
