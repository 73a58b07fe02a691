/* wire_extensions: see wire_extensions.h. */
#include "wire_extensions.h"
#include "wire_rules.h"

#include <string.h>

static uint32_t little_endian(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

bool wire_extension_next(wire_u8s *rest, wire_extension *out)
{
    if (rest->count < WIRE_EXTENSION_HEAD) return false;
    uint32_t length = little_endian(rest->at + 4);
    if (length > rest->count - WIRE_EXTENSION_HEAD) return false;
    *out = (wire_extension){little_endian(rest->at), {length, rest->at + WIRE_EXTENSION_HEAD}};
    *rest = (wire_u8s){rest->count - WIRE_EXTENSION_HEAD - length, out->bytes.at + length};
    return true;
}

/* The last field of the table. */
static uint16_t offset_of_extensions(const wire_message *m)
{
    const wire_schema *s = wire_schema_of(m->kind);
    return s->fields[s->field_count - 1].offset;
}

wire_u8s wire_extensions_of(const wire_message *m)
{
    wire_u8s extensions = {0, NULL};
    if (!wire_schema_of(m->kind)) return extensions;
    memcpy(&extensions, (const char *)&m->version + offset_of_extensions(m), sizeof extensions);
    return extensions;
}

void wire_extensions_set(wire_message *m, wire_u8s extensions)
{
    memcpy((char *)&m->version + offset_of_extensions(m), &extensions, sizeof extensions);
}

uint32_t wire_extensions_keep_known(const wire_message *m, uint8_t *room, wire_u8s *known)
{
    wire_u8s rest = wire_extensions_of(m);
    uint32_t unknown = 0;
    wire_extension e;
    *known = (wire_u8s){0, room};
    for (const uint8_t *at = rest.at; wire_extension_next(&rest, &e); at = rest.at) {
        uint32_t size = WIRE_EXTENSION_HEAD + e.bytes.count;
        bool keeps = wire_extension_is_known(m->kind, e.id);
        if (keeps) memcpy(room + known->count, at, size);
        known->count += keeps ? size : 0;
        unknown += !keeps;
    }
    return unknown;
}

wire_reason check_extensions(const wire_message *m, wire_refusal *why)
{
    wire_u8s rest = wire_extensions_of(m);
    const uint32_t all = rest.count;
    uint32_t before = 0, records = 0;
    wire_extension e;
    while (wire_extension_next(&rest, &e)) {
        if (++records > WIRE_RECORDS_MAX)
            FAIL(WIRE_TOO_LARGE, "extensions: more than the allowed %d records", WIRE_RECORDS_MAX);
        if (e.id <= before) FAIL(WIRE_MALFORMED, "extensions: id %u stands behind %u: ids rise from 1", e.id, before);
        if (e.id & WIRE_EXTENSION_REQUIRED && !wire_extension_is_known(m->kind, e.id))
            FAIL(WIRE_UNSUPPORTED, "extensions: %u must not be passed over, and this release does not know it",
                e.id & ~WIRE_EXTENSION_REQUIRED);
        before = e.id;
    }
    if (rest.count) FAIL(WIRE_MALFORMED, "extensions[%u]: the record is longer than what is left", all - rest.count);
    return WIRE_OK;
}
