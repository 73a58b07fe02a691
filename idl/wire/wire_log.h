/* wire_log: recordings, in LCM's event log format, so that lcm-logplayer and its kin can read them.
 *
 * One record an event: sync word 0xEDA1DA01, event number (i64), timestamp in microseconds (i64), channel length and
 * data length (i32), all big-endian, then channel and data. Messages are stored under their LCM channels in their LCM
 * encoding: commands as they came, and what each tick reported, before its end. Beside them stand records of our own:
 * "collided.tick" ends the commands of a tick, "collided.lost" is a client whose lease ran out, "collided.steps" how
 * far lock-step was when the recording began, "collided.later" and "collided.built" that a geometry, whole, was not
 * built within the tick, and the tick from which on it was there, "collided.state" a piece of the daemon's whole state
 * then, and "collided.settings" what of its configuration is not the default and decides what is reported. Reading is
 * bounds-checked: a damaged file gives an error with its offset, never a crash.
 */
#ifndef COLLIDED_WIRE_LOG_H
#define COLLIDED_WIRE_LOG_H

#include "wire.h"
#include "wire_lcm.h"

#include <stdbool.h>

typedef enum wire_log_entry_kind {
    WIRE_LOG_MESSAGE,
    WIRE_LOG_TICK,
    WIRE_LOG_LOST,
    WIRE_LOG_STEPS,
    WIRE_LOG_STATE,
    WIRE_LOG_SETTINGS,
    WIRE_LOG_BUILD
} wire_log_entry_kind;

typedef struct wire_log_tick {
    int64_t tick;
    int64_t now_ns; /* the wall clock that the tick was given */
    int64_t monotonic_ns;
    int64_t events_hash; /* running hash of all events so far */
    int64_t budgeted;    /* 1: the tick had a budget, ... */
    int64_t work;        /* ... and did so many units of work */
    int64_t slice;       /* > 0: finding and deciding pairs was cut off after so many units, or had been before */
    int64_t pairs_most;  /* of max_pairs, so many could be, for want of memory; 0: all */
} wire_log_tick;

typedef struct wire_log_state { /* of so many bytes in all, those from `offset` on */
    uint64_t offset, total;
    uint64_t hash; /* of all of them, as their writer says */
} wire_log_state;

typedef struct wire_log_built { /* of a geometry that has come */
    int64_t client, hash;
    bool ready; /* from this tick on; otherwise it is built later than this tick. Without either: in this tick */
} wire_log_built;

enum { WIRE_LOG_PIECE_BYTES = 60000 }; /* of a state, at most: a datagram for who plays the file */

typedef struct wire_log_entry {
    wire_log_entry_kind kind;
    int64_t timestamp_us;
    wire_message message; /* WIRE_LOG_MESSAGE; borrows from the reader until its next call ... */
    const uint8_t *data;  /* ... and so does this: its LCM encoding, or WIRE_LOG_STATE: the bytes of the piece, or
                             WIRE_LOG_SETTINGS: text, without an end */
    size_t data_size;
    wire_log_state state;
    wire_log_tick tick;
    int64_t lost_client;
    int64_t steps_done;
    wire_log_built build;
} wire_log_entry;

typedef struct wire_log_writer wire_log_writer;
wire_log_writer *wire_log_create(const char *path, char *why, size_t why_size); /* refuses to overwrite */
/* To somewhere else than a file: `put` takes the bytes as they follow each other, and returns 0, or -1 with errno. The
 * first record has that number. NULL: no memory. */
typedef int wire_log_put(void *context, const uint8_t *bytes, size_t size);
wire_log_writer *wire_log_to(wire_log_put *put, void *context, int64_t first_record);
/* Each: 0, or -1 when the disk refused (errno kept): the writer stays valid and refuses all that follows. */
int wire_log_message(wire_log_writer *w, int64_t timestamp_us, const wire_message *m);
int wire_log_tick_end(wire_log_writer *w, int64_t timestamp_us, const wire_log_tick *tick);
int wire_log_lost(wire_log_writer *w, int64_t timestamp_us, int64_t client);
int wire_log_steps(wire_log_writer *w, int64_t timestamp_us, int64_t done);
int wire_log_build(wire_log_writer *w, int64_t timestamp_us, int64_t client, int64_t hash, bool ready);
int wire_log_settings(wire_log_writer *w, int64_t timestamp_us, const char *text); /* lines of key = value */
/* In pieces; or piece by piece, each of WIRE_LOG_PIECE_BYTES but the last one, of a state of `total` bytes and that
 * hash. */
int wire_log_state_piece(wire_log_writer *w, int64_t timestamp_us, size_t offset, size_t total, uint64_t hash,
    const uint8_t *bytes, size_t size);
int wire_log_whole_state(wire_log_writer *w, int64_t timestamp_us, const uint8_t *bytes, size_t size, uint64_t hash);
/* Another writer puts a state of that size here: the number of its first record. */
int64_t wire_log_leave_state(wire_log_writer *w, size_t size);
int wire_log_close(wire_log_writer *w); /* -1 if not all could be written */

typedef struct wire_log_reader wire_log_reader;
wire_log_reader *wire_log_open(const char *path, char *why, size_t why_size);
/* 1: an entry; 0: the end; -1: damaged, with the offset and what is wrong in `why`. Unknown channels are passed over
 * and counted in *skipped (may be NULL). */
int wire_log_next(wire_log_reader *r, wire_log_entry *out, uint64_t *skipped, char *why, size_t why_size);
void wire_log_end(wire_log_reader *r);

#endif
