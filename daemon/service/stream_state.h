/* stream_state: a stream of events, and what waits for its reader. */
#ifndef COLLIDED_SERVICE_STREAM_STATE_H
#define COLLIDED_SERVICE_STREAM_STATE_H

#include "base/array.h"
#include "link/link.h"
#include "wire/wire_lcm.h"

typedef struct backlog_entry { /* a message that is not acknowledged yet, encoded */
    uint8_t *data;
    size_t size;
    int64_t batch, tick;
    int32_t part, parts;
    bool snapshot;
} backlog_entry;

typedef struct backlog {
    ARRAY(backlog_entry) entries;
    size_t first, next; /* the first that is not acknowledged, and the first that is not sent */
    size_t bytes;       /* of those, and of these: */
    bool building;      /* a snapshot comes in portions: until it is whole it is kept here, and goes first */
    ARRAY(backlog_entry) built;
    wire_event_batch head;      /* of each of its parts */
    bool anew;                  /* more came than is kept: a snapshot follows when the rest has been read */
    bool wants;                 /* that snapshot, in a moment */
    bool receipts;              /* its subscriber sends them */
    int64_t receipt;            /* the newest one's sequence */
    int64_t received;           /* and the last batch that it names */
    unsigned window, threshold; /* messages that may be under way; up to where that grows fast */
    bool lossy;                 /* something was lost: `threshold` says when */
    unsigned again;             /* without receipts: how often a snapshot was asked for again */
    int64_t snapshot_ns;        /* when the last one came to wait, monotonic */
    int64_t due_ns;             /* without receipts: when the next ones go out, monotonic */
    int64_t moved_ns;           /* when something was acknowledged last, while something waits; monotonic */
    int64_t skipped;            /* batches that were not kept since it was up to date */
    bool starves, warned;
    int64_t warned_ns;
} backlog;

typedef struct stream {
    bool live;
    bool read;   /* a reader has come: before, there is nobody to tell */
    bool ending; /* its subscription is gone, its last batch is not told yet: another may have its name */
    char *name;
    int64_t client;
    int32_t subscription;
    struct link *link;
    bool each_tick;      /* its updates are not held back: it answers the steps of its client, too */
    bool reported;       /* a batch has been sent */
    int64_t batch;       /* of the last batch made ... */
    int64_t batch_tick;  /* ... and the tick of that; a snapshot is none */
    int64_t inherited;   /* the last one of the daemon that this one took over from, as far as it knows */
    int64_t reported_ns; /* when it last said something, monotonic */
    uint64_t work;       /* units of the world's, told in Status so far */
    uint64_t events;     /* reported on it */
    int64_t recorded;    /* the number of its last batch in a recording */
    bool tells_poses;    /* with each event those that it is proven for */
    bool scene;          /* no events, but the bodies that match this pattern, and their poses: see scene.c; ... */
    char scene_select[WIRE_NAME_MAX + 1];
    int64_t scene_period_ns; /* ... at most so often ... */
    struct scene_view *view; /* ... and what its reader knows of them; NULL: nothing */
    backlog backlog;
} stream;

#endif
