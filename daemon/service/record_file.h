/* record_file: the file of a recording, written by a thread of its own, so that no tick waits for a disk. What a tick
 * has said is handed over whole, and lies in a queue of a bounded size until it is written; once a second what was
 * written is synced, and so is the folder when the file has been made. So the file, what of it is synced, and what a
 * power cut leaves of that, end behind a whole tick. It ends of itself when the disk refuses, a limit is reached or the
 * queue is full: what is there is then cut behind the last whole tick, and stays readable.
 *
 * Tick thread, but for what the thread of the file does itself. */
#ifndef COLLIDED_SERVICE_RECORD_FILE_H
#define COLLIDED_SERVICE_RECORD_FILE_H

#include "state_parts.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct record_file record_file;

typedef struct record_terms {
    const char *path; /* copied; never overwritten */
    bool beside;      /* if it is there: FILE.1, FILE.2, ... */
    int64_t most_bytes;
    double keep_free;   /* of the file system's size, 0 to 1 */
    int64_t most_files; /* .lcmlog in its folder, this one included; 0: any number */
} record_terms;

typedef enum record_file_stand {
    RECORD_FILE_OPENING,
    RECORD_FILE_OPEN,
    RECORD_FILE_ENDED /* of itself: record_file_why says why */
} record_file_stand;

/* Starts the thread, which makes the file. NULL: no thread; errno says why. */
record_file *record_file_begin(const record_terms *terms);
/* How it stands; while it is being made, waits up to `wait_ms` for that (< 0: for as long as it takes). */
record_file_stand record_file_look(record_file *f, int wait_ms);
/* Of the file, when it was open or had ended as record_file_look looked last; the name it was given until then. */
const char *record_file_path(const record_file *f);
/* When it has ended: one line, and the option whose limit was reached, or "" if the disk refused. */
const char *record_file_why(const record_file *f, const char **option);

/* Where much is to be put at once, the memory for it is asked for first, which takes longer than putting it: the thread
 * makes room for so many bytes of a state. True when it is there. */
void record_file_ask_room(record_file *f, size_t state_bytes);
bool record_file_take_room(record_file *f, bytes_out *state);

int record_file_put(void *f, const uint8_t *bytes, size_t size); /* of the tick that is on; a wire_log_put */
/* A whole state, framed by the thread; takes it over. What was put before comes before it. */
void record_file_put_state(record_file *f, state_parts *state, int64_t first_record, int64_t timestamp_us);
/* What was put is a part of what a recording begins with. False: much waits to be written, and more had better wait. */
bool record_file_part(record_file *f);
/* What was put is a whole tick. If the queue is full: waits for room (a replay may), or the recording ends. */
void record_file_tick(record_file *f, bool may_wait);

/* No more comes: what was put is written, synced and closed. True within `wait_ms` (< 0: as long as it takes): it is
 * freed; false: to be called again. */
bool record_file_close(record_file *f, int wait_ms);

#endif
