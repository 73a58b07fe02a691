/* message: deep copies made from the wire's schema, so that a new field needs no code here. Pure; any thread. */
#include "message.h"

#include "allocate.h"
#include "wire/wire_schema.h"

#include <assert.h>
#include <string.h>

static size_t number_size(wire_type type)
{
    switch (type) {
    case WIRE_U8S:
        return sizeof(uint8_t);
    case WIRE_I32S:
        return sizeof(int32_t);
    case WIRE_I64S:
        return sizeof(int64_t);
    case WIRE_F64S:
        return sizeof(double);
    default:
        return 0;
    }
}

static size_t rounded(size_t bytes)
{
    return (bytes + 7) & ~(size_t)7;
}

/* Where the next array goes. With block == NULL only the size is counted. */
typedef struct writer {
    char *block;
    size_t used;
} writer;

static void *put(writer *w, const void *from, size_t bytes)
{
    void *at = w->block ? w->block + w->used : NULL;
    if (at && bytes) memcpy(at, from, bytes);
    w->used += rounded(bytes);
    return at;
}

static void copy_string(writer *w, const char **field)
{
    const char *copy = *field ? put(w, *field, strlen(*field) + 1) : NULL;
    if (w->block) *field = copy;
}

static void copy_strings(writer *w, wire_strings *field)
{
    const char **at = put(w, field->at, field->count * sizeof *field->at);
    for (uint32_t i = 0; i < field->count; i++) {
        const char *copy = put(w, field->at[i], strlen(field->at[i]) + 1);
        if (w->block) at[i] = copy;
    }
    if (w->block) field->at = at;
}

/* The four kinds of arrays of numbers have one layout; a wire_u8s stands for each. */
static void copy_numbers(writer *w, void *field, size_t size)
{
    wire_u8s numbers;
    memcpy(&numbers, field, sizeof numbers);
    numbers.at = put(w, numbers.at, numbers.count * size);
    if (w->block) memcpy(field, &numbers, sizeof numbers);
}

/* `body` is the plain struct, whose fields are replaced by copies when the writer has a block. */
static void copy_fields(writer *w, char *body, const wire_schema *schema)
{
    for (uint32_t i = 0; i < schema->field_count; i++) {
        void *field = body + schema->fields[i].offset;
        wire_type type = schema->fields[i].type;
        if (type == WIRE_STRING) copy_string(w, field);
        if (type == WIRE_STRINGS) copy_strings(w, field);
        if (number_size(type)) copy_numbers(w, field, number_size(type));
    }
}

wire_message *message_copy(const wire_message *m)
{
    const wire_schema *schema = wire_schema_of(m->kind);
    assert(schema);
    wire_message head = *m;
    writer w = {.used = rounded(sizeof head)};
    copy_fields(&w, (char *)&head + offsetof(wire_message, version), schema);
    w.block = allocate(1, w.used);
    w.used = 0;
    wire_message *copy = put(&w, m, sizeof *m);
    copy_fields(&w, (char *)copy + offsetof(wire_message, version), schema);
    return copy;
}

int64_t message_sequence(const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    return sequence;
}

void message_set_sequence(wire_message *m, int64_t sequence)
{
    switch (m->kind) {
    case WIRE_CLIENT:
        m->client.sequence = sequence;
        break;
    case WIRE_GEOMETRY:
        m->geometry.sequence = sequence;
        break;
    case WIRE_BODY:
        m->body.sequence = sequence;
        break;
    case WIRE_SUBSCRIPTION:
        m->subscription.sequence = sequence;
        break;
    case WIRE_POSE_BATCH:
        m->pose_batch.sequence = sequence;
        break;
    case WIRE_QUERY:
        m->query.sequence = sequence;
        break;
    case WIRE_RECEIPT:
        m->receipt.sequence = sequence;
        break;
    default:
        assert(!"clients do not send this kind");
    }
}
