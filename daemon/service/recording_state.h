/* recording_state: a recording that is written, or taken. */
#ifndef COLLIDED_SERVICE_RECORDING_STATE_H
#define COLLIDED_SERVICE_RECORDING_STATE_H

#include "base/array.h"
#include "base/pair_map.h"
#include "link/link.h"
#include "wire/wire_lcm.h"

typedef struct record_wish { /* the last one on recordings, and what was answered */
    int64_t client, sequence;
    uint8_t status;
    char text[WIRE_TEXT_MAX + 1];
} record_wish;

typedef struct record_telling { /* of what a recording that begins in the middle is told: how far that has come */
    bool runs;
    enum { TELLS_CLAIMED, TELLS_HELD, TELLS_TAKEN_BACK, TELLS_CLIENTS } what;
    int64_t hash;           /* of the last claim of the next client on a geometry that was told; 0: none */
    int64_t geometry;       /* of which some pieces were told: its id, ... */
    int32_t piece;          /* ... and its next piece; 0: none is told in part */
    pair_map held;          /* ids of those that the next client's bodies hold, and that were told */
    ARRAY(int64_t) clients; /* that are to be told, ... */
    size_t next, next_body; /* ... and who, and what of its bodies, is next */
} record_telling;

typedef struct record_beginner { /* who may end it */
    bool by_query;               /* not: the configuration */
    bool watched, gone;          /* its link tells when it goes; it is gone: nobody may, but the operator */
    int64_t client, since_ns;    /* monotonic */
} record_beginner;

typedef struct record_reply { /* the answer to who ended a recording: when all of it is on the disk */
    struct link *to;          /* NULL: none is owed */
    wire_answer answer;
} record_reply;

typedef struct taken_state {    /* of the recording that is replayed */
    bool is_there;              /* since the last tick ended; ... */
    bool stands;                /* ... and it is that of the tick that ends now, which is not run */
    uint64_t events;            /* that the daemon had told until then */
    char wrong[128], left[192]; /* it is damaged; or it is of another build, and was left out: "" = not */
} taken_state;

#endif
