/* journal: the bytes that an active daemon hands to its standby: what it applied in a tick, in the order in which it
 * did, and how the tick ended. Both are programs of one release on one kind of machine, which their cards say, so
 * numbers are written as they lie in memory; yet nothing is read beyond the end. Tick thread. */
#ifndef COLLIDED_SERVICE_JOURNAL_H
#define COLLIDED_SERVICE_JOURNAL_H

#include "base/array.h"
#include "wire/wire_lcm.h"
#include "wire/wire_log.h"

typedef ARRAY(uint8_t) journal_bytes;

typedef enum journal_kind { JOURNAL_TICK, JOURNAL_STATE, JOURNAL_WANT_STATE } journal_kind; /* of a record */

typedef enum journal_entry_kind { ENTRY_MESSAGE, ENTRY_LOST, ENTRY_READER, ENTRY_TICK } journal_entry_kind;

typedef struct journal_entry {
    journal_entry_kind kind;
    uint8_t link;         /* by which it came: its place among the links of the configuration */
    wire_message message; /* ENTRY_MESSAGE; borrows from the memory given */
    int64_t client;       /* ENTRY_LOST */
    const char *stream;   /* ENTRY_READER; borrows from the record */
    int64_t epoch;        /* ENTRY_TICK */
    wire_log_tick tick;
} journal_entry;

void journal_put_message(journal_bytes *to, uint8_t link, const wire_message *m);
void journal_put_lost(journal_bytes *to, uint8_t link, int64_t client);
void journal_put_reader(journal_bytes *to, uint8_t link, const char *stream);
void journal_put_tick(journal_bytes *to, int64_t epoch, const wire_log_tick *t);

typedef struct journal_reader {
    const uint8_t *at;
    size_t left;
    bool broken; /* it says more than there is */
} journal_reader;

/* The next entry; false: there is none, or the record is broken. */
bool journal_next(journal_reader *r, wire_memory *memory, journal_entry *out);

/* Plain bytes, for states. Reading beyond the end gives zeros and breaks the reader. */
void journal_put(journal_bytes *to, const void *data, size_t size);
void journal_put_text(journal_bytes *to, const char *text);
bool journal_get(journal_reader *r, void *data, size_t size);
const char *journal_get_text(journal_reader *r); /* "" if it is broken */

#endif
