/* link_dds_own: what the files of this link share, and nobody else includes: joining a domain (link_dds_join.c), taking
 * (link_dds_take.c), streams (link_dds_streams.c), all else (link_dds.c). Whose thread runs what: see link_dds.c; where
 * nothing is said, the tick thread's. */
#ifndef COLLIDED_LINK_DDS_OWN_H
#define COLLIDED_LINK_DDS_OWN_H

#include "base/array.h"
#include "link.h"
#include "link_dds_joiners.h"
#include "link_dds_peers.h"
#include "link_dds_reminder.h"
#include "link_dds_speakers.h"
#include "turns.h"
#include "wire/dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <pthread.h>
#include <stdatomic.h>

enum {
    LINK_DDS_IN = 8,     /* kinds that clients send, */
    LINK_DDS_OUT = 5,    /* that the daemon sends, but for events; large answers have a writer of their own, the last */
    LINK_DDS_REPLIES = 4 /* of these, those that are for one client; likewise */
};

typedef struct link_dds link_dds;

typedef struct reader {
    link_dds *owner;
    wire_kind kind;
    dds_entity_t entity;
    atomic_bool arrived;
} reader;

typedef struct writer {
    dds_entity_t entity;
    wire_kind kind;    /* of those that are not streams' */
    bool dirty;        /* written to since the last flush */
    atomic_bool fresh; /* a reader has come, and has been told nothing yet; of streams' writers */
} writer;

/* Streams of many clients that go out by one writer, in a partition that these clients read in. */
typedef struct shared_events {
    link_dds *owner;
    writer out;          /* created when it is first needed */
    int64_t idle_ns;     /* monotonic: since then it has heartbeats to send, and nothing else; 0: it has not */
    atomic_bool matched; /* a reader has come, or a stream that may have one */
} shared_events;

typedef struct stream {
    link_dds *owner;
    char *name;
    writer own;
    atomic_bool matched; /* a reader has come, and the sink has not been told */
    writer *out;         /* its own, or the shared one: */
    shared_events *shared;
    int64_t client; /* whose stream it is, ... */
    link_dds *home; /* ... and where he is: the link, or a room. In a room one that he named goes out by both */
    bool reported;  /* of a shared one: the sink has been told that he reads */
} stream;

/* Deletes the writers of streams that have been closed. */
typedef struct stream_closer {
    pthread_t thread;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t wake;
    ARRAY(stream *) closed; /* in the order of their closing */
    bool runs, ends;        /* ends: when all are deleted */
} stream_closer;

/* The link, or a room of it: the same ends on another participant. What all share is the link's: head, speakers,
 * closer, reminder, joiners, streams, peers, woken. */
struct link_dds {
    struct link head;
    link_dds *whole;                               /* of a room the link, of the link itself */
    unsigned room;                                 /* 0: the link */
    _Atomic(link_dds *) rooms[WIRE_DDS_ROOMS + 1]; /* of the link: from 1; NULL: not open. joiners opens them */
    bool room_fails[WIRE_DDS_ROOMS + 1];           /* joiners' */
    unsigned first;                                /* that is taken from */
    speakers_ear ear;
    dds_entity_t domain; /* 0 = the process had it already */
    dds_entity_t participant;
    dds_entity_t topics[WIRE_KIND_COUNT];
    reader readers[LINK_DDS_IN];
    writer writers[LINK_DDS_OUT];
    writer replies[WIRE_DDS_REPLIES][LINK_DDS_REPLIES]; /* by group and kind: see wire_dds_qos.h */
    ARRAY(stream *) streams;                            /* sorted by name */
    shared_events shared[WIRE_DDS_EVENTS];
    size_t own_streams; /* with a writer of their own */
    stream_closer closer;
    joiners joiners;
    reminder reminder;
    speakers speakers;
    atomic_bool has_discovered, has_news; /* for speakers */
    dds_peers peers;
    atomic_bool peers_arrived, status_matched; /* status_matched: somebody new reads Status */
    void *sample;                              /* room for a sample of any kind, to be written */
    atomic_bool woken;
    atomic_size_t lost[WIRE_KIND_COUNT]; /* samples that DDS found to be lost, and nobody has been told yet; ... */
    atomic_bool has_lost;                /* ... some are */
    turns waiting;                       /* batches of poses, beyond what a round takes */
    size_t poses;                        /* taken by the receive that runs ... */
    size_t read_bytes;                   /* ... and read, of poses */
    bool on_arrival;                     /* a thread of Cyclone's stands in for the tick thread */
    bool is_behind;                      /* the receive that runs has left some that are no poses ... */
    unsigned loss_waited;                /* ... as have so many in a row */
    metric *messages_in, *refused, *foreign, *history_full, *messages_out, *write_failed, *no_stream, *samples_lost;
    metric *certificate_days;  /* NULL: no security */
    int64_t certificate_end_s; /* of the first that expires, seconds since the Unix epoch */
    int64_t certificate_day;   /* of the last warning, days since then */
};

static inline link_dds *link_dds_of(struct link *l)
{
    return (link_dds *)l;
}

/* Sets the flag, and wakes the tick thread if none was set. Any thread. */
void link_dds_notice(link_dds *l, atomic_bool *flag);

/* DDS has found that so many samples were lost: counted, and told the sink in the next receive. Any thread. */
void link_dds_note_lost(link_dds *l, wire_kind kind, size_t count);

/* That client's: a room, or the link, where nobody speaks for it as well. */
link_dds *link_dds_home(link_dds *l, int64_t client);

/* The next room that is open, from that number on, which goes on behind it; NULL: no more. Any thread. */
link_dds *link_dds_next_room(link_dds *l, unsigned *number);

joiners_rooms link_dds_rooms(link_dds *l);
/* Readers and writers of a link, or a room, whose participant is there. */
bool link_dds_open_ends(link_dds *l);
void link_dds_rooms_close(link_dds *l);

/* Created when it is first asked for; below 0: DDS's error. */
dds_entity_t link_dds_topic(link_dds *l, wire_kind kind);

void link_dds_flush_writer(writer *w);

/* ---- the domain ---- */

/* What DDS complained of first while it was joined: why it could not be. */
typedef struct link_dds_complaint {
    char text[256];
} link_dds_complaint;

/* Days until the first certificate expires; warns of it once a day, from 30 days on. */
int64_t link_dds_days_left(link_dds *l);

/* As link_ops says. */
int link_dds_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size);

uint32_t link_dds_domain(const link_dds *l); /* its number */

/* Domain and participant, of options that were checked: 0, or DDS's error. */
dds_return_t link_dds_join(link_dds *l, link_dds_complaint *first);

void link_dds_leave(link_dds *l);

/* Cyclone's own words, and what to do about those that are met in practice. */
void link_dds_say_why(
    const link_options *options, const link_dds_complaint *first, dds_return_t joined, char *why, size_t why_size);

/* ---- taking: as link_ops says ---- */

size_t link_dds_receive(struct link *head, const link_sink *sink);
size_t link_dds_receive_poses(struct link *head, const link_sink *sink);
void link_dds_drop_waiting(link_dds *l); /* before the domain is left */

/* ---- streams: the first two as link_ops says ---- */

void link_dds_stream_open(struct link *head, const char *name, int64_t client);
void link_dds_stream_close(struct link *head, const char *name);

/* Until that writer's readers have all that was flushed, or until then (monotonic). What was lost is said again. */
void link_dds_await(dds_entity_t writer, int64_t until_ns);

/* Creates the writer of that group's streams, if it is not there. */
shared_events *link_dds_shared(link_dds *l, unsigned group);

/* NULL: not open. */
stream *link_dds_stream_find(const link_dds *l, const char *name);

/* `m` is about to be written to its stream; and what was written goes out. Heartbeats of a crowd that share
 * a writer wait for each other, since each packet wakes all who share it. */
void link_dds_stream_note(const stream *s, const wire_message *m);
void link_dds_streams_flush(link_dds *l);

/* Tells the sink of readers that have come since the last call. */
void link_dds_streams_report(link_dds *l, const link_sink *sink);

void link_dds_closer_start(stream_closer *c);
void link_dds_streams_close(link_dds *l); /* all, and waits until their writers are deleted */

#endif
