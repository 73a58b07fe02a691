/* wire_check: what can be told of a message without the world. First what the schema knows of every field (limits,
 * finite numbers, UTF-8), then one small function a message for its own rules. Pure; any thread. Each refusal names the
 * field, the index and what is allowed. */
#include "wire_rules.h"

#include <math.h>
#include <string.h>

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

static wire_reason check_pose_batch(const wire_pose_batch *m, wire_refusal *why)
{
    uint32_t n = m->bodies.count;
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("stamp_ns", m->stamp_ns, 0, INT64_MAX, why));
    TRY(check_between("simulation_ns", m->simulation_ns, 0, INT64_MAX, why));
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
    TRY(check_all_between("teleports", m->teleports, 0, 1, why));
    return check_joints(m, why);
}

static wire_reason check_vertex_batch(const wire_vertex_batch *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("stamp_ns", m->stamp_ns, 0, INT64_MAX, why));
    TRY(check_between("body_id", m->body, 0, INT32_MAX, why));
    TRY(check_between("shape", m->shape, 0, WIRE_SHAPES_MAX - 1, why));
    TRY(check_between("first_vertex", m->first_vertex, 0, WIRE_GEOMETRY_MAX / 3, why));
    TRY(check_count("vertices", m->vertices.count, 3, m->vertices.count / 3, why));
    TRY(check_magnitudes("vertices", m->vertices, WIRE_SIZE_MAX, why));
    return check_soft_vertices(m, why);
}

static wire_reason check_horizon(const wire_subscription *m, wire_refusal *why)
{
    bool predicts = m->facts & WIRE_FACT_PREDICT;
    TRY(check_at_least("horizon_s", m->horizon_s, 0, why));
    if (m->horizon_s > WIRE_SPAN_MAX || (predicts && m->horizon_s == 0))
        FAIL(WIRE_BAD_SIZE, "horizon_s is %g s: %s 0 and at most %g is allowed", m->horizon_s,
            predicts ? "above" : "at least", WIRE_SPAN_MAX);
    return WIRE_OK;
}

static wire_reason check_accuracy(const wire_subscription *m, wire_refusal *why)
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

static wire_reason check_subscription(const wire_subscription *m, wire_refusal *why)
{
    int32_t known = WIRE_FACT_TOUCH | WIRE_FACT_DISTANCE | WIRE_FACT_MANIFOLD | WIRE_FACT_IMPACT | WIRE_FACT_PREDICT |
                    WIRE_FACT_SCENE | WIRE_FACT_POSES | WIRE_FACT_FEATURES | WIRE_FACT_SAFE_STEP;
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("subscription_id", m->subscription, 0, INT32_MAX, why));
    TRY(check_between("removed", m->removed, 0, 1, why));
    if (m->removed) return WIRE_OK;
    TRY(check_between("facts", m->facts, 1, known, why));
    if ((m->facts & WIRE_FACT_SCENE && m->facts != WIRE_FACT_SCENE) || m->facts == WIRE_FACT_POSES)
        FAIL(WIRE_UNSUPPORTED, "facts is %d: 32 (a scene) stands alone, 64 (poses) with facts about pairs", m->facts);
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
    TRY(check_at_least("rate_hz", m->rate_hz, 0, why));
    return check_soft_interest(m->extensions, why);
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
    bool pair = m->kind == WIRE_QUERY_DISTANCE || m->kind == WIRE_QUERY_EXPLAIN || m->kind == WIRE_QUERY_GEOMETRY;
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
    TRY(check_between("kind", m->kind, WIRE_QUERY_RAY, WIRE_QUERY_CHECK, why));
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

static wire_reason check_receipt(const wire_receipt *m, wire_refusal *why)
{
    TRY(check_sender(m->client, m->sequence, why));
    TRY(check_between("subscription_id", m->subscription, 0, INT32_MAX, why));
    TRY(check_between("batch", m->batch, 0, INT64_MAX, why));
    TRY(check_between("tick", m->tick, 0, INT64_MAX, why));
    TRY(check_between("part", m->part, 0, INT32_MAX, why));
    return check_between("missing", m->missing, 0, 1, why);
}

/* What the daemon says may be of a later release: values of its enumerations that are not known yet are for whoever
 * reads them. */
static wire_reason check_status(const wire_status *m, wire_refusal *why)
{
    return check_count("counter_values", m->counter_values.count, 1, m->counter_names.count, why);
}

static wire_reason check_reject(const wire_reject *m, wire_refusal *why)
{
    TRY(check_between("object_id", m->object, -1, INT32_MAX, why));
    return check_between("reason", m->reason, WIRE_WRONG_VERSION, UINT8_MAX, why);
}

static wire_reason check_ack(const wire_ack *m, wire_refusal *why)
{
    if (m->client == 0) FAIL(WIRE_UNKNOWN_CLIENT, "client_id is 0: any other number is allowed");
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
    case WIRE_SUBSCRIPTION:
        return check_subscription(&m->subscription, why);
    case WIRE_QUERY:
        return check_query(&m->query, why);
    case WIRE_RECEIPT:
        return check_receipt(&m->receipt, why);
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
    if (m->kind == WIRE_POSE_BATCH && poses_are_plain(&m->pose_batch)) {
        why->reason = WIRE_OK;
        why->text[0] = '\0';
        return WIRE_OK;
    }
    if (m->version != WIRE_VERSION) FAIL(WIRE_WRONG_VERSION, "version is %d: it must be %d", m->version, WIRE_VERSION);
    for (uint32_t i = 0; i < s->field_count; i++) TRY(check_field(&s->fields[i], wire_field_at(m, &s->fields[i]), why));
    TRY(check_own_rules(m, why));
    TRY(check_extensions(m, why));
    *why = (wire_refusal){WIRE_OK, ""};
    return WIRE_OK;
}
