/* table: from a 64-bit key to a pointer, open addressing with linear probing. Used for bodies by id and announcements
 * by sequence. Not locked: whoever holds the client's mutex owns it. */
#ifndef COLLIDED_CLIENT_TABLE_H
#define COLLIDED_CLIENT_TABLE_H

#include <stddef.h>
#include <stdint.h>

typedef struct table_slot {
    int64_t key;
    void *value; /* NULL = empty */
} table_slot;

typedef struct table {
    table_slot *slots;
    size_t capacity; /* 0 or a power of two, at least twice `count` */
    size_t count;
} table; /* all zero = empty */

void *table_get(const table *t, int64_t key);       /* NULL if there is none */
void table_fetch(const table *t, int64_t key);      /* asks memory for what table_get will look at */
void table_put(table *t, int64_t key, void *value); /* `value` is not NULL; replaces */
void table_drop(table *t, int64_t key);
void table_free(table *t);

#endif
