/* wire_dds: samples of idlc's structs to and from plain messages, field by field, led by the schema and one table of
 * offsets a message. Pure; any thread. Sequences of numbers and strings are borrowed, never copied: idlc's buffers of
 * strings are `char **`, ours `const char *const *`, the same bytes. */
#include "wire_dds.h"

#include "wire/wire_fields.h"
#include "wire/wire_schema.h"

#include "collided.h"

#include <string.h>

#define OFFSET(S, member, name, type, most, rule) offsetof(S, name),
#define OFFSETS_OF(kind, member, name)                                                                                 \
    static const size_t member##_offsets[] = {WIRE_FIELDS_##member(OFFSET, collided_##name)};

WIRE_MESSAGES(OFFSETS_OF)

#define LAYOUT_OF(kind, member, name) [kind] = {&collided_##name##_desc, sizeof(collided_##name), member##_offsets},

static const struct {
    const dds_topic_descriptor_t *descriptor;
    size_t size;
    const size_t *offsets; /* of the schema's fields in the sample */
} layouts[WIRE_KIND_COUNT] = {WIRE_MESSAGES(LAYOUT_OF)};

const struct dds_topic_descriptor *wire_dds_descriptor(wire_kind kind)
{
    return wire_schema_of(kind) ? layouts[kind].descriptor : NULL;
}

size_t wire_dds_sample_size(wire_kind kind)
{
    return wire_schema_of(kind) ? layouts[kind].size : 0;
}

/* Arrays begin with count and pointer, alike for every type. */
typedef struct any_array {
    uint32_t count;
    const void *at;
} any_array;

static size_t number_bytes(wire_type type)
{
    if (type == WIRE_U8) return 1;
    return type == WIRE_I32 ? 4 : 8;
}

static void decode_field(wire_type type, const void *from, void *to)
{
    if (type < WIRE_STRING) {
        memcpy(to, from, number_bytes(type));
    } else if (type == WIRE_STRING) {
        const char *text;
        memcpy(&text, from, sizeof text);
        if (!text) text = "";
        memcpy(to, &text, sizeof text);
    } else {
        const dds_sequence_t *sequence = from;
        any_array a = {sequence->_length, sequence->_buffer};
        memcpy(to, &a, sizeof a);
    }
}

static void encode_field(wire_type type, const void *from, void *to)
{
    if (type < WIRE_STRING) {
        memcpy(to, from, number_bytes(type));
    } else if (type == WIRE_STRING) {
        decode_field(type, from, to);
    } else {
        any_array a;
        memcpy(&a, from, sizeof a);
        dds_sequence_t sequence = {._maximum = a.count, ._length = a.count, ._buffer = (uint8_t *)a.at};
        memcpy(to, &sequence, sizeof sequence);
    }
}

wire_reason wire_dds_decode(wire_kind kind, const void *sample, wire_message *out, wire_refusal *refusal)
{
    const wire_schema *s = wire_schema_of(kind);
    memset(out, 0, sizeof *out);
    out->kind = kind;
    for (uint32_t i = 0; s && i < s->field_count; i++)
        decode_field(s->fields[i].type, (const char *)sample + layouts[kind].offsets[i],
            (char *)&out->version + s->fields[i].offset);
    return wire_check(out, refusal);
}

/* ---- bytes ---- */

typedef struct cursor {
    const char *bytes; /* behind the header, from which on everything is aligned to its own size */
    size_t size, at;
} cursor;

/* `count` of so many bytes each; NULL: they are not all there. */
static const void *next(cursor *c, size_t count, size_t each)
{
    size_t at = (c->at + each - 1) & ~(each - 1);
    if (at > c->size || count > (c->size - at) / each) return NULL;
    c->at = at + count * each;
    return c->bytes + at;
}

static size_t element_bytes(wire_type type)
{
    return number_bytes(type == WIRE_U8S ? WIRE_U8 : type == WIRE_I32S ? WIRE_I32 : WIRE_F64);
}

static bool read_field(wire_type type, cursor *from, void *to)
{
    if (type == WIRE_STRING || type == WIRE_STRINGS) return false;
    if (type < WIRE_STRING) {
        const void *number = next(from, 1, number_bytes(type));
        if (number) memcpy(to, number, number_bytes(type));
        return number != NULL;
    }
    any_array a = {0, NULL};
    const void *count = next(from, 1, sizeof a.count);
    if (!count) return false;
    memcpy(&a.count, count, sizeof a.count);
    if (a.count) a.at = next(from, a.count, element_bytes(type)); /* an empty one has no padding */
    memcpy(to, &a, sizeof a);
    return a.at || !a.count;
}

bool wire_dds_decode_bytes(
    wire_kind kind, const void *bytes, size_t size, wire_message *out, wire_reason *reason, wire_refusal *refusal)
{
    enum { HEADER = 4 };
    static const uint16_t one = 1;
    const uint8_t native[2] = {0, *(const uint8_t *)&one}; /* XCDR 1, not a list of parameters */
    const wire_schema *s = wire_schema_of(kind);
    if (!s || size < HEADER || memcmp(bytes, native, sizeof native) != 0) return false;
    cursor from = {(const char *)bytes + HEADER, size - HEADER, 0};
    if ((uintptr_t)from.bytes % 8) return false;
    memset(out, 0, sizeof *out);
    out->kind = kind;
    for (uint32_t i = 0; i < s->field_count; i++)
        if (!read_field(s->fields[i].type, &from, (char *)&out->version + s->fields[i].offset)) return false;
    *reason = wire_check(out, refusal);
    return true;
}

int64_t wire_dds_client_of_ack(const void *sample)
{
    return ((const collided_Ack *)sample)->client_id;
}

void wire_dds_encode(const wire_message *m, void *sample)
{
    const wire_schema *s = wire_schema_of(m->kind);
    if (!s) return;
    memset(sample, 0, layouts[m->kind].size);
    for (uint32_t i = 0; i < s->field_count; i++)
        encode_field(s->fields[i].type, wire_field_at(m, &s->fields[i]), (char *)sample + layouts[m->kind].offsets[i]);
}
