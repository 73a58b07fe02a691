/* wire_names: names of kinds and reasons, and where a message comes from. Constant data; any thread. */
#include "wire_schema.h"

#include <string.h>

const char *wire_kind_name(wire_kind kind)
{
    const wire_schema *s = wire_schema_of(kind);
    return s ? s->name : kind == WIRE_NOTHING ? "Nothing" : "unknown";
}

const char *wire_reason_name(wire_reason reason)
{
    static const char *const NAMES[WIRE_REASON_COUNT] = {
        [WIRE_OK] = "ok",
        [WIRE_WRONG_VERSION] = "wrong_version",
        [WIRE_MALFORMED] = "malformed",
        [WIRE_BAD_NUMBER] = "bad_number",
        [WIRE_BAD_ROTATION] = "bad_rotation",
        [WIRE_BAD_SIZE] = "bad_size",
        [WIRE_BAD_NAME] = "bad_name",
        [WIRE_TOO_LARGE] = "too_large",
        [WIRE_FLAT_HULL] = "flat_hull",
        [WIRE_BAD_HASH] = "bad_hash",
        [WIRE_UNKNOWN_CLIENT] = "unknown_client",
        [WIRE_UNKNOWN_BODY] = "unknown_body",
        [WIRE_UNKNOWN_GEOMETRY] = "unknown_geometry",
        [WIRE_NAME_TAKEN] = "name_taken",
        [WIRE_NOT_YOURS] = "not_yours",
        [WIRE_UNSUPPORTED] = "unsupported",
        [WIRE_LIMIT] = "limit",
        [WIRE_OLD_POSE] = "old_pose",
        [WIRE_BAD_STEP] = "bad_step",
        [WIRE_STEP_MISSED] = "step_missed",
        [WIRE_UNHEARD] = "unheard",
    };
    return reason < WIRE_REASON_COUNT ? NAMES[reason] : "unknown";
}

static const void *field_of(const wire_message *m, const wire_schema *s, const char *name)
{
    for (uint32_t i = 0; i < s->field_count; i++)
        if (strcmp(s->fields[i].name, name) == 0) return (const char *)&m->version + s->fields[i].offset;
    return NULL;
}

void wire_origin(const wire_message *m, int64_t *client, int64_t *sequence, int32_t *object)
{
    const wire_schema *s = wire_schema_of(m->kind);
    const int64_t *from = s ? field_of(m, s, "client_id") : NULL;
    const int64_t *number = s ? field_of(m, s, "sequence") : NULL;
    *client = from ? *from : 0;
    *sequence = number ? *number : 0;
    *object = m->kind == WIRE_BODY           ? m->body.body
              : m->kind == WIRE_SUBSCRIPTION ? m->subscription.subscription
              : m->kind == WIRE_RECEIPT      ? m->receipt.subscription
              : m->kind == WIRE_EVENT_BATCH  ? m->event_batch.subscription
                                             : -1;
}

static uint64_t mix(uint64_t h, uint64_t word)
{
    for (int byte = 0; byte < 8; byte++) h = (h ^ (word >> (8 * byte) & 0xff)) * UINT64_C(1099511628211);
    return h;
}

int64_t wire_geometry_hash(uint8_t kind, wire_f64s vertices, wire_i32s indices)
{
    uint64_t h = mix(UINT64_C(14695981039346656037), kind);
    h = mix(mix(h, vertices.count), indices.count);
    for (uint32_t i = 0; i < vertices.count; i++) {
        uint64_t bits;
        memcpy(&bits, &vertices.at[i], sizeof bits);
        h = mix(h, bits);
    }
    for (uint32_t i = 0; i < indices.count; i++) h = mix(h, (uint32_t)indices.at[i]);
    return h ? (int64_t)h : 1;
}
