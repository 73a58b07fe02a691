/* wire_schema: the tables that wire_fields.h spells out, with the offsets in the plain structs. Constant data; any
 * thread. */
#include "wire_schema.h"

#include "wire_fields.h"

#define FINITE false
#define INFINITE true

#define ROW(S, member, name, type, most, rule) {#name, WIRE_##type, offsetof(S, member), most, rule},
#define FIELDS_OF(kind, member, name)                                                                                  \
    static const wire_field member##_fields[] = {WIRE_FIELDS_##member(ROW, wire_##member)};

WIRE_MESSAGES(FIELDS_OF)

#define SCHEMA_OF(kind, member, name)                                                                                  \
    [kind] = {#name, sizeof(wire_##member), sizeof member##_fields / sizeof *member##_fields, member##_fields},

static const wire_schema schemas[WIRE_KIND_COUNT] = {WIRE_MESSAGES(SCHEMA_OF)};

const wire_schema *wire_schema_of(wire_kind kind)
{
    unsigned at = (unsigned)kind;
    return at > WIRE_NOTHING && at < WIRE_KIND_COUNT ? &schemas[at] : NULL;
}
