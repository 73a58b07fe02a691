/* journal: the bytes that an active daemon hands to its standby: what it applied in a tick, in the order in which it
 * did, and how the tick ended. Both are programs of one release on one kind of machine, which their announcements say,
 * so numbers are written as they lie in memory; yet nothing is read beyond the end. Tick thread. */
#ifndef COLLIDED_SERVICE_JOURNAL_H
#define COLLIDED_SERVICE_JOURNAL_H

#include "base/bytes.h"
#include "wire/wire_lcm.h"
#include "wire/wire_log.h"

typedef enum journal_kind { /* of a record */
    JOURNAL_TICK,           /* its number, and entries */
    JOURNAL_STATE,          /* a portion of it (journal_portion); of the tick that was told before the first one */
    JOURNAL_WANT_STATE,     /* from one that joins: the epoch in which it has told what nobody else knows, or 0 */
    JOURNAL_HAVE,           /* from the standby: journal_have */
    JOURNAL_FOLLOWED,       /* to the standby, journal_followed: from here on nobody is told what it does not have */
    JOURNAL_DROPPED,        /* to the standby: it was too slow, and is waited for no more */
    JOURNAL_LEAVE           /* to the standby: go on */
} journal_kind;

typedef struct journal_portion {
    uint64_t whole, offset; /* bytes: of the state (standby_state.c), and where those that follow begin in it */
} journal_portion;

typedef struct journal_have {
    int64_t to, epoch, tick; /* whose journal; the last tick that has come */
    int64_t asks;            /* not 0: is it still waited for? */
} journal_have;

typedef struct journal_followed {
    int64_t whom, asked; /* by its sender; its last question, or 0 */
} journal_followed;

typedef enum journal_entry_kind { ENTRY_MESSAGE, ENTRY_LOST, ENTRY_READER, ENTRY_TICK, ENTRY_BUILD } journal_entry_kind;

typedef struct journal_entry {
    journal_entry_kind kind;
    uint8_t link;         /* by which it came: its place among the links of the configuration */
    wire_message message; /* ENTRY_MESSAGE; borrows from the memory given */
    int64_t client;       /* ENTRY_LOST, ENTRY_BUILD */
    int64_t hash, ready;  /* ENTRY_BUILD: of a geometry of that client: put off, or (1) ready */
    const char *stream;   /* ENTRY_READER; borrows from the record */
    int64_t epoch;        /* ENTRY_TICK */
    wire_log_tick tick;
} journal_entry;

void journal_put_message(bytes_out *to, uint8_t link, const wire_message *m);
void journal_put_lost(bytes_out *to, uint8_t link, int64_t client);
void journal_put_reader(bytes_out *to, uint8_t link, const char *stream);
void journal_put_build(bytes_out *to, int64_t client, int64_t hash, bool ready);
void journal_put_tick(bytes_out *to, int64_t epoch, const wire_log_tick *t);

/* The next entry; false: there is none, or the record is broken. */
bool journal_next(bytes_in *r, wire_memory *memory, journal_entry *out);

#endif
