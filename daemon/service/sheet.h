/* sheet: the figures of one Status, in their order. Those that a page puts under one head follow each other. The names
 * are borrowed until it has been told. Tick thread. */
#ifndef COLLIDED_SERVICE_SHEET_H
#define COLLIDED_SERVICE_SHEET_H

#include "wire/wire.h"

enum { SHEET_NAMED_MAX = 64 }; /* clients, or streams, that have figures of their own */

typedef struct sheet {
    const char *names[WIRE_COUNTERS_MAX];
    int64_t values[WIRE_COUNTERS_MAX];
    uint32_t count;
} sheet;

static inline void sheet_add(sheet *t, const char *name, int64_t value)
{
    if (t->count == WIRE_COUNTERS_MAX) return; /* far more than there are: the registry is made at start */
    t->names[t->count] = name;
    t->values[t->count++] = value;
}

#endif
