/* The rules of wire_check, continued: poses, subscriptions, queries, what the daemon sends, and every limit, at it and
 * one beyond. */
#include "plain.h"

#include "wire/wire_lcm.h"
#include "wire/wire_schema.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void pose_batch_rules(void **state)
{
    (void)state;
    ACCEPTED(WIRE_POSE_BATCH, (m.pose_batch.linear.count = 0, m.pose_batch.angular.count = 0));
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.linear.count = 3, WIRE_MALFORMED, "linear has 3");
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.angular.count = 5, WIRE_MALFORMED, "angular has 5");
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.positions.count = 3, WIRE_MALFORMED, "positions has 3");
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.orientations.count = 4, WIRE_MALFORMED, "orientations has 4");
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.stamp_ns = -1, WIRE_MALFORMED, "stamp_ns is -1");
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.simulation_ns = -1, WIRE_MALFORMED, "simulation_ns is -1");
    REFUSED(WIRE_POSE_BATCH, plain.bodies[1] = -1, WIRE_MALFORMED, "bodies[1] is -1");
    REFUSED(WIRE_POSE_BATCH, plain.orientations[5] = 0, WIRE_BAD_ROTATION, "orientations[4..7] has the norm 0");
    REFUSED(WIRE_POSE_BATCH, plain.positions[5] = NAN, WIRE_BAD_NUMBER, "positions[5] is not a number");
    ACCEPTED(WIRE_POSE_BATCH, plain.positions[5] = WIRE_POSITION_MAX);
    REFUSED(WIRE_POSE_BATCH, plain.positions[5] = 1.1e12, WIRE_TOO_LARGE, "positions[5] is 1.1e+12: at most 1e+12");
    ACCEPTED(WIRE_POSE_BATCH, plain.linear[0] = -WIRE_SPEED_MAX);
    REFUSED(WIRE_POSE_BATCH, plain.linear[0] = 2e9, WIRE_TOO_LARGE, "linear[0]");
    ACCEPTED(WIRE_POSE_BATCH, plain.angular[0] = WIRE_SPIN_MAX);
    REFUSED(WIRE_POSE_BATCH, plain.angular[0] = 2 * WIRE_SPIN_MAX, WIRE_TOO_LARGE, "angular[0] is 200000");
    ACCEPTED(WIRE_POSE_BATCH, m.pose_batch.teleports = ((wire_u8s){2, plain.actions}));
    REFUSED(WIRE_POSE_BATCH, m.pose_batch.teleports = ((wire_u8s){1, plain.counts}), WIRE_MALFORMED, "teleports has 1");
    REFUSED(WIRE_POSE_BATCH, plain.angular[0] = -2e9, WIRE_TOO_LARGE, "angular[0]");
    REFUSED(WIRE_POSE_BATCH, plain.angular[1] = -INFINITY, WIRE_BAD_NUMBER, "angular[1] is infinite");
}

static void vertex_batch_rules(void **state)
{
    (void)state;
    REFUSED(WIRE_VERTEX_BATCH, m.vertex_batch.stamp_ns = -1, WIRE_MALFORMED, "stamp_ns");
    REFUSED(WIRE_VERTEX_BATCH, m.vertex_batch.body = -1, WIRE_MALFORMED, "body_id is -1");
    ACCEPTED(WIRE_VERTEX_BATCH, m.vertex_batch.shape = WIRE_SHAPES_MAX - 1);
    REFUSED(WIRE_VERTEX_BATCH, m.vertex_batch.shape = WIRE_SHAPES_MAX, WIRE_MALFORMED, "shape is 256: 0 to 255");
    ACCEPTED(WIRE_VERTEX_BATCH, m.vertex_batch.first_vertex = WIRE_GEOMETRY_MAX / 3);
    REFUSED(WIRE_VERTEX_BATCH, m.vertex_batch.first_vertex = WIRE_GEOMETRY_MAX, WIRE_MALFORMED, "first_vertex");
    REFUSED(WIRE_VERTEX_BATCH, m.vertex_batch.vertices.count = 11, WIRE_MALFORMED, "vertices has 11");
    ACCEPTED(WIRE_VERTEX_BATCH, plain.vertices[0] = WIRE_SIZE_MAX);
    REFUSED(WIRE_VERTEX_BATCH, plain.vertices[0] = 2e9, WIRE_TOO_LARGE, "vertices[0]");
}

static void subscription_rules(void **state)
{
    (void)state;
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.subscription = -1, WIRE_MALFORMED, "subscription_id is -1");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.facts = 15);
    ACCEPTED(WIRE_SUBSCRIPTION, (m.subscription.facts = 31, m.subscription.horizon_s = 2));
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.facts = 16, WIRE_BAD_SIZE, "horizon_s is 0 s: above 0");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.horizon_s = 1e6, WIRE_BAD_SIZE, "horizon_s is 1e+06 s");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.horizon_s = -1, WIRE_BAD_NUMBER, "horizon_s is -1");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.hysteresis_m = WIRE_SIZE_MAX);
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.hysteresis_m = 1.1 * WIRE_SIZE_MAX, WIRE_TOO_LARGE, "hysteresis_m");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.hysteresis_m = -1e-9, WIRE_BAD_NUMBER, "hysteresis_m is -1e-09");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.facts = 0, WIRE_MALFORMED, "facts is 0: 1 to 511");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.facts = 512, WIRE_MALFORMED, "facts is 512");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.stream = "a.b_c-d:e/f9Z");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.stream = "a*", WIRE_BAD_NAME, "letters, digits and . _ - : /");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.stream = "a b", WIRE_BAD_NAME, "stream");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.stream = "\xc3\xa9", WIRE_BAD_NAME, "stream");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.select_a = "arm_*?");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.select_a = "", WIRE_BAD_NAME, "select_a is empty");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.select_b = "group:", WIRE_BAD_NAME, "select_b is \"group:\"");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.threshold_m = -WIRE_SIZE_MAX);
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.threshold_m = 2e9, WIRE_TOO_LARGE, "threshold_m");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.threshold_m = INFINITY, WIRE_BAD_NUMBER, "threshold_m[0] is infinite");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.range_m = -1, WIRE_BAD_NUMBER, "range_m is -1: at least 0");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.range_m = 2e9, WIRE_TOO_LARGE, "range_m");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.tolerance_m = -1, WIRE_BAD_NUMBER, "tolerance_m is -1");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.tolerance_m = NAN, WIRE_BAD_NUMBER, "tolerance_m[0] is not a number");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.relative_tolerance = -1, WIRE_BAD_NUMBER, "1e-15 to 1 is possible, or 0");
    REFUSED(
        WIRE_SUBSCRIPTION, m.subscription.relative_tolerance = NAN, WIRE_BAD_NUMBER, "relative_tolerance[0] is not a");
    REFUSED(
        WIRE_SUBSCRIPTION, m.subscription.relative_tolerance = 9e-16, WIRE_BAD_NUMBER, "1e-15 to 1 is possible, or 0");
    REFUSED(
        WIRE_SUBSCRIPTION, m.subscription.relative_tolerance = 1.001, WIRE_BAD_NUMBER, "1e-15 to 1 is possible, or 0");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.relative_tolerance = 1e-15);
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.relative_tolerance = 1);
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.accuracy = 3, WIRE_MALFORMED, "accuracy is 3: 0 to 2");
    ACCEPTED(WIRE_SUBSCRIPTION, (m.subscription.accuracy = WIRE_BY_BOXES, m.subscription.facts = 1 + 2));
    ACCEPTED(WIRE_SUBSCRIPTION, (m.subscription.accuracy = WIRE_BY_VERDICT, m.subscription.facts = 1));
    REFUSED(WIRE_SUBSCRIPTION, (m.subscription.accuracy = WIRE_BY_BOXES, m.subscription.facts = 1 + 4),
        WIRE_UNSUPPORTED, "accuracy is 1: manifolds need 0");
    REFUSED(WIRE_SUBSCRIPTION, (m.subscription.accuracy = WIRE_BY_VERDICT, m.subscription.facts = 1 + 2),
        WIRE_UNSUPPORTED, "accuracy is 2: distances need 0");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.rate_hz = -1, WIRE_BAD_NUMBER, "rate_hz is -1");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.rate_hz = NAN, WIRE_BAD_NUMBER, "rate_hz[0] is not a number");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.removed = 2, WIRE_MALFORMED, "removed");
    ACCEPTED(WIRE_SUBSCRIPTION, (m.subscription.removed = 1, m.subscription.facts = 0));
}

static void query_rules(void **state)
{
    (void)state;
    REFUSED(WIRE_QUERY, m.query.kind = 0, WIRE_MALFORMED, "kind is 0: 1 to 11");
    REFUSED(WIRE_QUERY, m.query.kind = 12, WIRE_MALFORMED, "kind is 12");
    REFUSED(WIRE_QUERY, m.query.kind = WIRE_QUERY_SWEEP, WIRE_BAD_SIZE, "span_s is 0 s: above 0");
    ACCEPTED(WIRE_QUERY, (m.query.kind = WIRE_QUERY_SWEEP, m.query.span_s = 1));
    REFUSED(WIRE_QUERY, m.query.linear = ((wire_f64s){2, plain.linear}), WIRE_MALFORMED, "linear has 2");
    REFUSED(WIRE_QUERY, m.query.name_a = "\x01", WIRE_BAD_NAME, "name_a");
    REFUSED(WIRE_QUERY, m.query.name_b = "\x01", WIRE_BAD_NAME, "name_b");
    REFUSED(WIRE_QUERY, m.query.origin.count = 2, WIRE_MALFORMED, "origin has 2");
    REFUSED(WIRE_QUERY, m.query.orientation.count = 3, WIRE_MALFORMED, "orientation has 3");
    REFUSED(WIRE_QUERY, m.query.half.count = 1, WIRE_MALFORMED, "half has 1");
    REFUSED(WIRE_QUERY, m.query.direction.count = 1, WIRE_MALFORMED, "direction has 1");
    ACCEPTED(WIRE_QUERY, plain.origin[1] = -WIRE_POSITION_MAX);
    REFUSED(WIRE_QUERY, plain.origin[1] = 2e12, WIRE_TOO_LARGE, "origin[1]");
    REFUSED(WIRE_QUERY, plain.orientations[0] = 0, WIRE_BAD_ROTATION, "orientation[0..3]");
    ACCEPTED(WIRE_QUERY, plain.half[2] = 0);
    REFUSED(WIRE_QUERY, plain.half[2] = -1, WIRE_BAD_SIZE, "half[2] is -1 m");
    REFUSED(WIRE_QUERY, plain.half[2] = 2e9, WIRE_BAD_SIZE, "half[2] is 2e+09 m");
    REFUSED(WIRE_QUERY, plain.direction[2] = 0, WIRE_BAD_NUMBER, "direction is 0 0 0");
    ACCEPTED(WIRE_QUERY, m.query.length_m = INFINITY);
    REFUSED(WIRE_QUERY, m.query.length_m = -1, WIRE_BAD_NUMBER, "length_m is -1");
    REFUSED(WIRE_QUERY, m.query.length_m = NAN, WIRE_BAD_NUMBER, "length_m[0] is not a number");
    REFUSED(WIRE_QUERY, m.query.tolerance_m = -1, WIRE_BAD_NUMBER, "tolerance_m is -1");
    ACCEPTED(WIRE_QUERY, m.query.most = WIRE_ANSWERS_MAX);
    REFUSED(WIRE_QUERY, m.query.most = WIRE_ANSWERS_MAX + 1, WIRE_MALFORMED, "most is 4097: 0 to 4096");
    REFUSED(WIRE_QUERY, m.query.most = -1, WIRE_MALFORMED, "most is -1");
}

static void receipt_rules(void **state)
{
    (void)state;
    ACCEPTED(WIRE_RECEIPT, (m.receipt.batch = INT64_MAX, m.receipt.tick = INT64_MAX, m.receipt.part = INT32_MAX));
    REFUSED(WIRE_RECEIPT, m.receipt.subscription = -1, WIRE_MALFORMED, "subscription_id is -1: 0 to");
    REFUSED(WIRE_RECEIPT, m.receipt.batch = -1, WIRE_MALFORMED, "batch is -1: 0 to");
    REFUSED(WIRE_RECEIPT, m.receipt.tick = -1, WIRE_MALFORMED, "tick is -1: 0 to");
    REFUSED(WIRE_RECEIPT, m.receipt.part = -1, WIRE_MALFORMED, "part is -1: 0 to");
    REFUSED(WIRE_RECEIPT, m.receipt.missing = 2, WIRE_MALFORMED, "missing is 2: 0 to 1");
}

/* What each kind of query cannot do without. */
static void query_kinds_have_what_they_need(void **state)
{
    (void)state;
    static const uint8_t at_a_place[] = {WIRE_QUERY_RAY, WIRE_QUERY_BOX, WIRE_QUERY_NEAREST, WIRE_QUERY_CAST};
    static const uint8_t along[] = {WIRE_QUERY_RAY, WIRE_QUERY_CAST};
    static const uint8_t of_two[] = {WIRE_QUERY_DISTANCE, WIRE_QUERY_EXPLAIN};
    for (size_t i = 0; i < 4; i++)
        REFUSED(WIRE_QUERY, (m.query.kind = at_a_place[i], m.query.name_a = "", m.query.origin.count = 0),
            WIRE_MALFORMED, "origin has 0");
    ACCEPTED(WIRE_QUERY, (m.query.kind = WIRE_QUERY_NEAREST, m.query.origin.count = 0)); /* near the body name_a */
    for (size_t i = 0; i < 2; i++) {
        REFUSED(WIRE_QUERY, (m.query.kind = along[i], m.query.direction.count = 0), WIRE_MALFORMED, "direction has 0");
        REFUSED(WIRE_QUERY, (m.query.kind = of_two[i], m.query.name_a = ""), WIRE_BAD_NAME, "name_a is empty");
        REFUSED(WIRE_QUERY, (m.query.kind = of_two[i], m.query.name_b = ""), WIRE_BAD_NAME, "name_b is empty");
        ACCEPTED(WIRE_QUERY, (m.query.kind = of_two[i], m.query.origin.count = m.query.direction.count = 0));
    }
    REFUSED(WIRE_QUERY, m.query.half.count = 0, WIRE_MALFORMED, "half has 0");
    REFUSED(WIRE_QUERY, (m.query.kind = WIRE_QUERY_BODIES, m.query.name_a = ""), WIRE_BAD_NAME, "name_a is empty");
    ACCEPTED(WIRE_QUERY, (m.query.kind = WIRE_QUERY_BODIES, m.query.name_a = "*"));
    ACCEPTED(WIRE_QUERY, (m.query.kind = WIRE_QUERY_RECORD, m.query.name_a = ""));
}

static void answer_rules(void **state)
{
    (void)state;
    ACCEPTED(WIRE_ANSWER, m.answer.names_b.count = m.answer.lo.count = m.answer.hi.count = 0);
    ACCEPTED(WIRE_ANSWER, m.answer.status = WIRE_ANSWER_TRUNCATED);
    REFUSED(WIRE_ANSWER, m.answer.names_b.count = 1, WIRE_MALFORMED, "names_b has 1");
    REFUSED(WIRE_ANSWER, m.answer.lo.count = 1, WIRE_MALFORMED, "lo has 1");
    REFUSED(WIRE_ANSWER, m.answer.hi.count = 1, WIRE_MALFORMED, "hi has 1");
    REFUSED(WIRE_ANSWER, m.answer.axes.count = 5, WIRE_MALFORMED, "axes has 5");
    REFUSED(WIRE_ANSWER, m.answer.points_a.count = 5, WIRE_MALFORMED, "points_a has 5");
    REFUSED(WIRE_ANSWER, m.answer.points_b.count = 5, WIRE_MALFORMED, "points_b has 5");
    REFUSED(WIRE_ANSWER, m.answer.orientations.count = 7, WIRE_MALFORMED, "orientations has 7");
    REFUSED(WIRE_ANSWER, m.answer.ages_ns.count = 1, WIRE_MALFORMED, "ages_ns has 1");
    REFUSED(WIRE_ANSWER, m.answer.stale.count = 1, WIRE_MALFORMED, "stale has 1");
    REFUSED(WIRE_ANSWER, plain.stale[1] = 2, WIRE_MALFORMED, "stale[1] is 2");
    REFUSED(WIRE_ANSWER, plain.lo[1] = 0.4, WIRE_BAD_NUMBER, "lo[1] is 0.4, above hi 0.3");
    ACCEPTED(WIRE_ANSWER, (plain.lo[1] = -INFINITY, plain.hi[1] = INFINITY));
    REFUSED(WIRE_ANSWER, plain.lo[1] = NAN, WIRE_BAD_NUMBER, "lo[1] is not a number");
    ACCEPTED(WIRE_ANSWER, m.answer.text = plain_text(WIRE_TEXT_MAX));
    REFUSED(WIRE_ANSWER, m.answer.text = plain_text(WIRE_TEXT_MAX + 1), WIRE_TOO_LARGE, "the allowed 4095 bytes");
}

static void event_batch_rules(void **state)
{
    (void)state;
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.batch = 0, WIRE_MALFORMED, "batch is 0");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.simulation_ns = -1, WIRE_MALFORMED, "simulation_ns is -1");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.snapshot = 2, WIRE_MALFORMED, "snapshot is 2");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.closing = 2, WIRE_MALFORMED, "closing is 2");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.parts = 0, WIRE_MALFORMED, "parts is 0");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.parts = INT32_MIN, WIRE_MALFORMED, "parts is -2147483648");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.part = 1, WIRE_MALFORMED, "part is 1: 0 to 0");
    ACCEPTED(WIRE_EVENT_BATCH, m.event_batch.behind = INT32_MAX);
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.behind = -1, WIRE_MALFORMED, "behind is -1: 0 to");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.stream = "", WIRE_BAD_NAME, "stream is empty");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.stream = "?", WIRE_BAD_NAME, "letters, digits");
    ACCEPTED(WIRE_EVENT_BATCH, plain.kinds[0] = WIRE_EVENT_KNOWN);
    ACCEPTED(WIRE_EVENT_BATCH, plain.kinds[0] = WIRE_EVENT_AVERTED);
    REFUSED(WIRE_EVENT_BATCH, plain.kinds[0] = WIRE_EVENT_IMPACT, WIRE_MALFORMED, "impact_times has 0");
    REFUSED(WIRE_EVENT_BATCH, plain.kinds[0] = 0, WIRE_MALFORMED, "kinds[0] is 0: 1 to 255");
    ACCEPTED(WIRE_EVENT_BATCH, plain.causes[1] = WIRE_CAUSE_TELEPORT);
    REFUSED(WIRE_EVENT_BATCH, plain.lo[0] = 0, WIRE_BAD_NUMBER, "lo[0] is 0, above hi -0.1");
    ACCEPTED(WIRE_EVENT_BATCH, (plain.lo[0] = -INFINITY, plain.hi[0] = INFINITY));
    REFUSED(WIRE_EVENT_BATCH, plain.axes[0] = INFINITY, WIRE_BAD_NUMBER, "axes[0] is infinite");
    REFUSED(WIRE_EVENT_BATCH, plain.counts[0] = 5, WIRE_MALFORMED, "manifold_counts[0] is 5: 0 to 4");
    REFUSED(WIRE_EVENT_BATCH, plain.counts[1] = 1, WIRE_MALFORMED, "manifold_points has 9");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.manifold_distances.count = 2, WIRE_MALFORMED, "manifold_distances has 2");
    REFUSED(WIRE_EVENT_BATCH, m.event_batch.manifold_features.count = 2, WIRE_MALFORMED, "manifold_features has 2");
}

/* Every array of a batch has its entries for each event. */
static void event_arrays_are_of_one_length(void **state)
{
    (void)state;
    static const char *const arrays[] = {"causes", "contacts", "names_a", "names_b", "shapes_a", "shapes_b", "lo", "hi",
        "axes", "points_a", "points_b", "ages_a_ns", "ages_b_ns", "closings", "achieved", "manifold_counts"};
    const wire_schema *s = wire_schema_of(WIRE_EVENT_BATCH);
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        for (uint32_t i = 0; i < s->field_count; i++) {
            if (strcmp(s->fields[i].name, arrays[k]) != 0) continue;
            wire_message m = plain_message(WIRE_EVENT_BATCH);
            uint32_t *count = (uint32_t *)((char *)&m.version + s->fields[i].offset);
            --*count;
            expect_refused(&m, arrays[k], WIRE_MALFORMED, arrays[k]);
        }
}

static void rules_of_the_daemon_s_other_messages(void **state)
{
    (void)state;
    ACCEPTED(WIRE_STATUS, m.status.health = WIRE_HEALTH_STOPPING);
    REFUSED(WIRE_STATUS, m.status.counter_values.count = 1, WIRE_MALFORMED, "counter_values has 1");
    ACCEPTED(WIRE_REJECT, (m.reject.client = 0, m.reject.kind = WIRE_NOTHING));
    REFUSED(WIRE_REJECT, m.reject.object = -2, WIRE_MALFORMED, "object_id is -2");
    REFUSED(WIRE_REJECT, m.reject.reason = WIRE_OK, WIRE_MALFORMED, "reason is 0");
    REFUSED(WIRE_ACK, m.ack.client = 0, WIRE_UNKNOWN_CLIENT, "client_id is 0");
    ACCEPTED(WIRE_ACK, m.ack.sequences.count = 0);
}

/* The daemon may be of a later release; whoever hears it shows such a value as unknown. What clients say is refused: it
 * could not be done. */
static void values_that_only_a_later_daemon_knows_are_no_fault(void **state)
{
    (void)state;
    ACCEPTED(WIRE_EVENT_BATCH, plain.kinds[1] = 42);
    ACCEPTED(WIRE_EVENT_BATCH, plain.causes[1] = 10);
    ACCEPTED(WIRE_EVENT_BATCH, plain.stale[1] = 4); /* achieved */
    ACCEPTED(WIRE_EVENT_BATCH, m.event_batch.refusal = WIRE_REASON_COUNT);
    ACCEPTED(WIRE_ANSWER, m.answer.kind = 10);
    ACCEPTED(WIRE_ANSWER, m.answer.status = 4);
    ACCEPTED(WIRE_ANSWER, (m.answer.achieved = (wire_u8s){2, plain.counts}, plain.counts[1] = 4));
    ACCEPTED(WIRE_STATUS, m.status.health = 4);
    ACCEPTED(WIRE_REJECT, m.reject.kind = WIRE_KIND_COUNT);
    ACCEPTED(WIRE_REJECT, m.reject.reason = WIRE_REASON_COUNT);
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.facts = 512, WIRE_MALFORMED, "facts is 512: 1 to 511");
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.facts = WIRE_FACT_SCENE);
    ACCEPTED(WIRE_SUBSCRIPTION, m.subscription.facts = WIRE_FACT_TOUCH | WIRE_FACT_POSES);
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.facts = WIRE_FACT_SCENE | WIRE_FACT_TOUCH, WIRE_UNSUPPORTED,
        "facts is 33: 32 (a scene) stands alone");
    REFUSED(WIRE_SUBSCRIPTION, m.subscription.facts = WIRE_FACT_POSES, WIRE_UNSUPPORTED, "facts is 64");
    REFUSED(WIRE_QUERY, m.query.kind = 12, WIRE_MALFORMED, "kind is 12: 1 to 11");
}

/* ---- limits ---- */

/* A message of `kind` whose field has `count` entries that are zeros, or empty texts; the other fields as plain. */
static wire_reason check_count(wire_kind kind, const wire_field *f, uint32_t count, wire_refusal *why)
{
    wire_message m = plain_message(kind);
    wire_f64s zeros = {count, calloc(count, sizeof(double))};
    if (f->type == WIRE_STRINGS)
        for (uint32_t i = 0; i < count; i++) ((const char **)zeros.at)[i] = "";
    memcpy((char *)&m.version + f->offset, &zeros, sizeof zeros);
    wire_reason reason = wire_check(&m, why);
    free((void *)zeros.at);
    return reason;
}

static void one_array_at_its_limit(wire_kind kind, const wire_field *f)
{
    wire_refusal why;
    char told[64];
    snprintf(told, sizeof told, "%s has ", f->name);
    wire_reason at = check_count(kind, f, f->limit, &why);
    if (at == WIRE_TOO_LARGE) fail_msg("%s: %s", wire_kind_name(kind), why.text);
    wire_reason beyond = check_count(kind, f, f->limit + 1, &why);
    if (beyond != WIRE_TOO_LARGE || strncmp(why.text, told, strlen(told)) != 0)
        fail_msg("%s: %s beyond its limit: \"%s\"", wire_kind_name(kind), f->name, why.text);
}

static void every_array_is_refused_one_beyond_its_limit(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        const wire_schema *s = wire_schema_of((wire_kind)kind);
        for (uint32_t i = 0; i < s->field_count; i++)
            if (s->fields[i].type >= WIRE_U8S) one_array_at_its_limit((wire_kind)kind, &s->fields[i]);
    }
}

static void every_text_is_refused_one_byte_beyond_its_limit(void **state)
{
    (void)state;
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        const wire_schema *s = wire_schema_of((wire_kind)kind);
        for (uint32_t i = 0; i < s->field_count; i++) {
            const wire_field *f = &s->fields[i];
            if (f->type != WIRE_STRING) continue;
            wire_message m = plain_message((wire_kind)kind);
            const char **text = (const char **)((char *)&m.version + f->offset);
            *text = plain_text(f->limit);
            expect_accepted(&m, f->name);
            *text = plain_text(f->limit + 1);
            expect_refused(&m, f->name, WIRE_TOO_LARGE, f->name);
        }
    }
}

static void a_full_pose_batch_is_legal(void **state)
{
    (void)state;
    wire_message m = plain_message(WIRE_POSE_BATCH);
    double *zeros = calloc(4 * (size_t)WIRE_POSES_MAX, sizeof *zeros), *turns = calloc(4 * (size_t)WIRE_POSES_MAX, 8);
    for (size_t i = 0; i < WIRE_POSES_MAX; i++) turns[4 * i] = 1;
    m.pose_batch.bodies = (wire_i32s){WIRE_POSES_MAX, (const int32_t *)zeros};
    m.pose_batch.orientations = (wire_f64s){4 * WIRE_POSES_MAX, turns};
    m.pose_batch.positions = m.pose_batch.linear = m.pose_batch.angular = (wire_f64s){3 * WIRE_POSES_MAX, zeros};
    expect_accepted(&m, "full");
    assert_true(wire_lcm_size(&m) < 16 << 20); /* the frame of the gateway's pipe, and MaxSampleSize over DDS */
    free(zeros);
    free(turns);
}

/* One piece of a geometry at the limit, and of one with three numbers more; the hash is checked of whole ones only. */
static void a_geometry_is_refused_beyond_its_limit(void **state)
{
    (void)state;
    double *zeros = calloc(WIRE_PIECE_MAX, sizeof *zeros);
    wire_message m = plain_message(WIRE_GEOMETRY);
    wire_geometry *g = &m.geometry;
    int32_t most = WIRE_GEOMETRY_MAX / 3 * 3;
    *g = (wire_geometry){WIRE_VERSION, 1, 1, .kind = WIRE_GEOMETRY_HULL, .hash = 1, .vertex_numbers = most, .piece = 3,
        .pieces = 256, .vertices = {WIRE_PIECE_MAX, zeros}};
    expect_accepted(&m, "at the limit");
    g->piece = 255;
    g->vertices.count = (uint32_t)(most - 255 * WIRE_PIECE_MAX);
    expect_accepted(&m, "the last piece is shorter");
    g->vertices.count++;
    expect_refused(&m, "a number too many", WIRE_MALFORMED, "vertices has");
    g->vertex_numbers = most + 3;
    expect_refused(&m, "beyond", WIRE_TOO_LARGE, "at most 16777216 are allowed");
    g->kind = WIRE_GEOMETRY_MESH;
    g->index_numbers = g->vertex_numbers = INT32_MAX / 3 * 3;
    expect_refused(&m, "far beyond", WIRE_TOO_LARGE, "at most 16777216 are allowed");
    free(zeros);
}

/* Vertices end and indices begin within one piece. */
static void a_piece_may_hold_the_seam(void **state)
{
    (void)state;
    double *zeros = calloc(WIRE_PIECE_MAX, sizeof *zeros);
    wire_message m = plain_message(WIRE_GEOMETRY);
    m.geometry = (wire_geometry){WIRE_VERSION, 1, 1, .kind = WIRE_GEOMETRY_MESH, .hash = 1,
        .vertex_numbers = WIRE_PIECE_MAX + 2, .index_numbers = 6, .piece = 1, .pieces = 2, .vertices = {2, zeros},
        .indices = {6, (const int32_t *)zeros}};
    expect_accepted(&m, "second piece");
    m.geometry.piece = 0;
    expect_refused(&m, "first piece", WIRE_MALFORMED, "vertices has 2 elements: it must have 1 for each of 65536");
    m.geometry.vertices.count = WIRE_PIECE_MAX;
    expect_refused(&m, "first piece", WIRE_MALFORMED, "indices has 6 elements: it must have 1 for each of 0");
    m.geometry.indices.count = 0;
    expect_accepted(&m, "first piece");
    free(zeros);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pose_batch_rules),
        cmocka_unit_test(vertex_batch_rules),
        cmocka_unit_test(subscription_rules),
        cmocka_unit_test(query_rules),
        cmocka_unit_test(receipt_rules),
        cmocka_unit_test(query_kinds_have_what_they_need),
        cmocka_unit_test(answer_rules),
        cmocka_unit_test(event_batch_rules),
        cmocka_unit_test(event_arrays_are_of_one_length),
        cmocka_unit_test(rules_of_the_daemon_s_other_messages),
        cmocka_unit_test(values_that_only_a_later_daemon_knows_are_no_fault),
        cmocka_unit_test(every_array_is_refused_one_beyond_its_limit),
        cmocka_unit_test(every_text_is_refused_one_byte_beyond_its_limit),
        cmocka_unit_test(a_full_pose_batch_is_legal),
        cmocka_unit_test(a_geometry_is_refused_beyond_its_limit),
        cmocka_unit_test(a_piece_may_hold_the_seam),
    };
    return cmocka_run_group_tests_name("wire_check_more", tests, NULL, NULL);
}
