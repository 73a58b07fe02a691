/* wire_schema: the fields of each message as a table: the one place from which checking, coding and the test that holds
 * IDL and LCM equal are made. */
#ifndef COLLIDED_WIRE_SCHEMA_H
#define COLLIDED_WIRE_SCHEMA_H

#include "wire.h"

#include <stdbool.h>

typedef enum wire_type {
    WIRE_U8,  /* octet, byte */
    WIRE_I32, /* long, int32_t */
    WIRE_I64, /* long long, int64_t */
    WIRE_F64, /* double */
    WIRE_STRING,
    WIRE_U8S, /* sequence<octet>; in LCM preceded by int32_t NAME_n, as are all arrays */
    WIRE_I32S,
    WIRE_I64S,
    WIRE_F64S,
    WIRE_STRINGS
} wire_type;

typedef struct wire_field {
    const char *name;
    wire_type type;
    uint16_t offset; /* in the plain struct */
    uint32_t limit;  /* most numbers, strings, or bytes of a string */
    bool infinite;   /* infinities have a meaning here; NaN never has */
} wire_field;

typedef struct wire_schema {
    const char *name; /* "PoseBatch"; the IDL struct is collided::PoseBatch, the LCM type collided.PoseBatch */
    size_t size;      /* of the plain struct */
    uint32_t field_count;
    const wire_field *fields;
} wire_schema;

const wire_schema *wire_schema_of(wire_kind kind); /* NULL for WIRE_NOTHING and unknown kinds */

/* A field of a plain struct, by its type. */
static inline const void *wire_field_at(const wire_message *m, const wire_field *f)
{
    return (const char *)&m->version + f->offset;
}

#endif
