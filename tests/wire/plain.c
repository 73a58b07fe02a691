/* The messages are as small as is legal, and touch every array; wire_check accepts each of them as it is. */
#include "plain.h"

#include <stdlib.h>
#include <string.h>

plain_arrays plain;

static const plain_arrays fresh = {
    .pose = {1, 2, 3, 1, 0, 0, 0},
    .sizes = {0.1, 0.2, 0.3, 0, 0, 0},
    .radii = {0, 0.5},
    .deviations = {0, 0.01},
    .shape_poses = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
    .positions = {1, 2, 3, 4, 5, 6},
    .orientations = {1, 0, 0, 0, 0, 1, 0, 0},
    .vertices = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1},
    .half = {0.1, 0.1, 0.1},
    .direction = {0, 0, -2},
    .lo = {-0.1, 0.2},
    .hi = {-0.1, 0.3},
    .types = {WIRE_SHAPE_BOX, WIRE_SHAPE_SPHERE},
    .kinds = {WIRE_EVENT_BEGIN, WIRE_EVENT_NEAR},
    .counts = {3, 0},
    .bodies = {0, 7},
    .indices = {0, 1, 2, 0, 2, 3},
    .contacts = {1, 2},
    .texts = {"one", "two"},
};

static wire_geometry mesh(void)
{
    wire_geometry g = {WIRE_VERSION, 1, 1, .kind = WIRE_GEOMETRY_MESH, .vertex_numbers = 12, .index_numbers = 6,
        .pieces = 1, .vertices = {12, plain.vertices}, .indices = {6, plain.indices}};
    g.hash = wire_geometry_hash(g.kind, g.vertices, g.indices);
    return g;
}

static wire_body body(void)
{
    return (wire_body){WIRE_VERSION, 1, 1, .name = "b", .group = "", .pose = {7, plain.pose},
        .shape_types = {2, plain.types}, .shape_sizes = {6, plain.sizes}, .shape_radii = {2, plain.radii},
        .shape_deviations = {2, plain.deviations}, .shape_poses = {14, plain.shape_poses},
        .shape_geometries = {2, plain.geometries}, .rule_patterns = {2, plain.texts},
        .rule_actions = {2, plain.actions}, .rule_reasons = {2, plain.texts}, .rule_paddings = {2, plain.paddings},
        .rule_margins = {2, plain.margins}};
}

static wire_pose_batch pose_batch(void)
{
    return (wire_pose_batch){WIRE_VERSION, 1, 1, .bodies = {2, plain.bodies}, .positions = {6, plain.positions},
        .orientations = {8, plain.orientations}, .linear = {6, plain.linear}, .angular = {6, plain.angular}};
}

static wire_query query(void)
{
    return (wire_query){WIRE_VERSION, 1, 1, WIRE_QUERY_BOX, "a", "b", .origin = {3, plain.origin},
        .orientation = {4, plain.orientations}, .half = {3, plain.half}, .direction = {3, plain.direction}};
}

static wire_answer answer(void)
{
    return (wire_answer){WIRE_VERSION, 1, 1, .kind = WIRE_QUERY_DISTANCE, .text = "", .names_a = {2, plain.texts},
        .names_b = {2, plain.texts}, .lo = {2, plain.lo}, .hi = {2, plain.hi}, .axes = {6, plain.axes},
        .points_a = {6, plain.points}, .points_b = {6, plain.points}, .orientations = {8, plain.orientations},
        .ages_ns = {2, plain.ages}, .stale = {2, plain.stale}, .achieved = {2, plain.stale}};
}

static wire_event_batch event_batch(void)
{
    return (wire_event_batch){WIRE_VERSION, 1, .batch = 1, .parts = 1, .stream = "s", .kinds = {2, plain.kinds},
        .causes = {2, plain.causes}, .contacts = {2, plain.contacts}, .names_a = {2, plain.texts},
        .names_b = {2, plain.texts}, .shapes_a = {2, plain.shapes}, .shapes_b = {2, plain.shapes}, .lo = {2, plain.lo},
        .hi = {2, plain.hi}, .axes = {6, plain.axes}, .points_a = {6, plain.points}, .points_b = {6, plain.points},
        .ages_a_ns = {2, plain.ages}, .ages_b_ns = {2, plain.ages}, .closings = {2, plain.distances},
        .achieved = {2, plain.stale}, .manifold_counts = {2, plain.counts}, .manifold_points = {9, plain.manifold},
        .manifold_distances = {3, plain.distances}, .manifold_features = {3, plain.features}};
}

wire_message plain_message(wire_kind kind)
{
    wire_message m = {.kind = kind, .client = {.version = WIRE_VERSION, .client = 1, .sequence = 1}};
    plain = fresh;
    if (kind == WIRE_CLIENT) m.client = (wire_client){WIRE_VERSION, 1, 1, .lease_ns = 1, .name = "c"};
    if (kind == WIRE_GEOMETRY) m.geometry = mesh();
    if (kind == WIRE_BODY) m.body = body();
    if (kind == WIRE_POSE_BATCH) m.pose_batch = pose_batch();
    if (kind == WIRE_VERTEX_BATCH) m.vertex_batch.vertices = (wire_f64s){12, plain.vertices};
    if (kind == WIRE_SUBSCRIPTION)
        m.subscription = (wire_subscription){
            WIRE_VERSION, 1, 1, .facts = WIRE_FACT_TOUCH, .stream = "", .select_a = "a", .select_b = "b"};
    if (kind == WIRE_QUERY) m.query = query();
    if (kind == WIRE_ANSWER) m.answer = answer();
    if (kind == WIRE_EVENT_BATCH) m.event_batch = event_batch();
    if (kind == WIRE_STATUS)
        m.status = (wire_status){WIRE_VERSION, 1, 0, "d", "r", "l", "", .counter_names = {2, plain.texts},
            .counter_values = {2, plain.contacts}};
    if (kind == WIRE_REJECT)
        m.reject = (wire_reject){WIRE_VERSION, 1, .object = -1, .reason = WIRE_LIMIT, .text = "why"};
    if (kind == WIRE_ACK) m.ack.sequences = (wire_i64s){2, plain.contacts};
    return m;
}

const char *plain_text(size_t bytes)
{
    static char text[2 * WIRE_TEXT_MAX];
    memset(text, 'x', bytes);
    text[bytes] = '\0';
    return text;
}

void expect_accepted(const wire_message *m, const char *change)
{
    wire_refusal why = {WIRE_LIMIT, "untouched"};
    if (wire_check(m, &why) != WIRE_OK)
        fail_msg("%s, %s: refused, %s (%s)", wire_kind_name(m->kind), change, why.text, wire_reason_name(why.reason));
    assert_int_equal(why.reason, WIRE_OK);
    assert_string_equal(why.text, "");
}

void expect_refused(const wire_message *m, const char *change, wire_reason reason, const char *words)
{
    wire_refusal why = {WIRE_OK, ""};
    wire_reason got = wire_check(m, &why);
    if (got != reason || got != why.reason || !strstr(why.text, words))
        fail_msg("%s, %s: %s \"%s\", not %s \"%s\"", wire_kind_name(m->kind), change, wire_reason_name(got), why.text,
            wire_reason_name(reason), words);
}
