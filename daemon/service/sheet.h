/* sheet: the figures of one Status, in their order. Those that a page puts under one head follow each other. The names
 * are borrowed until it has been told; those that are made up for it live until the next one is begun. Each daemon has
 * one: there may be several in a process. Tick thread. */
#ifndef COLLIDED_SERVICE_SHEET_H
#define COLLIDED_SERVICE_SHEET_H

#include "wire/wire_lcm.h"

enum { SHEET_NAMED_MAX = 64 }; /* clients, or streams, that have figures of their own */

typedef struct sheet {
    const char *names[WIRE_COUNTERS_MAX];
    int64_t values[WIRE_COUNTERS_MAX];
    uint32_t count;
    wire_memory *memory; /* of names that are made up */
} sheet;

sheet *sheet_create(void);
void sheet_destroy(sheet *t); /* NULL: nothing */
void sheet_begin(sheet *t);
/* As sheet_add, under a name that is made up by a format of printf's. */
void sheet_add_named(sheet *t, int64_t value, const char *format, ...) __attribute__((format(printf, 3, 4)));

static inline void sheet_add(sheet *t, const char *name, int64_t value)
{
    if (t->count == WIRE_COUNTERS_MAX) return; /* far more than there are: the registry is made at start */
    t->names[t->count] = name;
    t->values[t->count++] = value;
}

#endif
