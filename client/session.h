/* session: the client's state, and the two threads that share it.
 *
 * The caller's thread runs every function of collided.h and all callbacks; it alone receives event batches and answers,
 * unless it sleeps, and on_arrival lets a thread of the transport's stand in for it (session_run.c, stand_in).
 * The keeper, a thread of the library, receives acks, rejects and status, repeats what nobody acknowledged, and sends
 * heartbeats, so that a client that only sleeps keeps its lease and outlives a restart of the daemon. What both touch
 * is under `lock`, which no callback ever runs under. */
#ifndef COLLIDED_CLIENT_SESSION_H
#define COLLIDED_CLIENT_SESSION_H

#include "announcement.h"
#include "collided.h"
#include "table.h"
#include "transport.h"

#include <pthread.h>

#define NS_PER_S INT64_C(1000000000)
#define NS_PER_MS INT64_C(1000000)
#define SESSION_SILENCE_NS (3 * NS_PER_S) /* a daemon that says nothing for so long is not heard; it speaks at 1 Hz */

enum { SESSION_REJECTIONS_MAX = 256, SESSION_ERROR_MAX = 640 };

typedef struct body_record { /* publishing touches three cache lines of it: these */
    _Alignas(64) announcement announced;
    int32_t id;
    bool removed;
    bool has_linear, has_angular;
    bool teleported; /* `pose` was not reached from what was announced by a way: told so with the acknowledgement */
    _Alignas(64) double pose[7]; /* newest published */
    int64_t stamp_ns;            /* of `pose`; 0 = none since it was announced */
    double velocity[6];          /* linear, angular */
    int64_t step, simulation_ns;
} body_record;
_Static_assert(sizeof(body_record) == 192, "publishing touches three cache lines");

typedef struct geometry_record {
    announcement *pieces; /* owned array */
    int32_t piece_count;
    int64_t hash;
    struct geometry_record *next;
} geometry_record;

/* The keeper announces and repeats; the rest belongs to the caller's thread. */
typedef struct subscription_record {
    announcement announced;
    int32_t id;
    bool removed;   /* by the caller: no more callbacks */
    bool forgotten; /* under lock: its removal is settled, the record can be freed */
    char *stream;
    collided_events *callback;
    collided_observed *observed; /* instead of it, of a scene */
    bool has_poses;              /* asked for with events */
    void *context;
    collided_soft_steps_told *soft_callback; /* NULL: none */
    void *soft_context;
    int64_t epoch;                         /* of the last batch, 0 = none yet */
    int64_t next_batch, tick;              /* tick: of the last batch */
    bool closed;                           /* that one was the last of its stream */
    bool waiting;                          /* nothing is delivered until what is missing, or a snapshot, comes */
    bool gathering;                        /* parts of a snapshot come */
    int64_t snapshot_batch, snapshot_tick; /* of the last snapshot, if nothing came behind it; tick 0: something did */
    int32_t snapshot_part;                 /* its last part that came */
    bool asked;                            /* for what is missing here */
    unsigned receipts;                     /* so often, since something came in order */
    unsigned owed;                         /* messages that came in order since the last receipt */
    bool eager;                            /* the daemon waits for receipts */
    int32_t behind;                        /* messages that it said to wait */
    bool starved;                          /* and its callback has had the notice */
    int64_t lacks_ns;                      /* waiting or gathering: since then */
    bool unsure;                           /* a standby has taken over, and has not told where it goes on ... */
    int64_t unsure_epoch;                  /* ... from what we were told under this one */
    int64_t reported_more; /* the last batch of that, which the standby did not know: none of its own is believed before
                          a snapshot; 0: it knew all */
    bool each_tick;
    int64_t step;           /* of the last batch since a step was ended; 0 = none */
    int64_t reported_epoch; /* of the last batch that was delivered; 0 = none was */
    int64_t lost;
    int64_t resync_ns; /* waiting: when the snapshot is asked for again */
    int64_t resync_wait_ns;
    unsigned silences; /* so often in a row the silence was looked into, and nothing came */
    int64_t last_seen_ns,
        patience_ns;      /* not waiting: the last batch or heartbeat; after how long a silence it is asked */
    wire_message **parts; /* copies, of the batch that is being put together */
    size_t part_count, part_capacity;
    struct subscription_record *next;
} subscription_record;

typedef struct scene_room scene_room;

typedef struct session_counters { /* under lock; shown beside the daemon's own in collided_get_status */
    int64_t repeats, announced_again, foreign, malformed, rejections_dropped, batches_lost, unknown_events, stalls,
        send_failures;
    int64_t unheard, renewals, silent_streams; /* see unheard.c; streams: stream.c */
} session_counters;

struct collided {
    /* constant after opening */
    transport *link;
    int64_t id;
    int64_t lease_ns;
    int32_t lock_step;
    collided_on_loss on_loss;
    int keeper_wake, caller_wake; /* eventfds */
    int loop, loop_timer;         /* see loop.h; -1 = there is none */
    pthread_t keeper;
    bool on_arrival;

    /* under turn: while the caller's thread sleeps, a thread of the transport's may take its place and receive */
    pthread_mutex_t turn;
    bool sleeping;

    /* under lock */
    pthread_mutex_t lock;
    bool stopping;
    int64_t sequence; /* the last one used */
    announcement client;
    announcement *first, *last; /* the record */
    size_t pending;
    size_t names_leaving; /* bodies and subscriptions of which it is not acknowledged yet that they leave their names */
    int64_t name_left_ns; /* when it was last; 0 = never */
    table by_sequence;    /* to announcement */
    table bodies;         /* id to body_record */
    void **body_blocks;   /* memory of body records, side by side */
    size_t body_block_count, body_block_capacity;
    body_record *spare_bodies; /* linked by announced.next */
    body_record **published;   /* of the poses that are being published */
    size_t published_capacity;
    geometry_record *geometries;
    struct robot_record *robots; /* robots.c */
    int64_t wall_ahead_ns;       /* of the monotonic clock, when poses were published last; 0 = none were */
    int64_t epoch, last_seen_ns; /* the daemon's; 0 = never heard */
    int64_t over;                /* the epoch that was told last to end: nobody who comes to it follows it any more */
    int64_t seek_ns;             /* when a daemon is sought next, while none is heard; 0 = one was */
    int64_t seek_wait_ns;        /* before that */
    int64_t crowd;               /* clients that the daemon knows, by its last status */
    int64_t heartbeat_ns;        /* when the next one is due */
    int64_t heartbeat;           /* sequence of the last one */
    int64_t acknowledged_ns;     /* when one, or our announcement, was acknowledged last; 0 = never */
    int64_t all_again_ns;        /* when everything was last announced again */
    bool all_again_wanted;       /* the daemon has lost us: when a second has passed since */
    int64_t newest_poses;        /* sequence of the newest PoseBatch; 0 = none */
    int64_t word_ns;             /* when that is said next */
    int64_t unheard_ns;          /* when the daemon last told that it does not hear us; 0 = never */
    int64_t renew_ns;            /* not before, new writers */
    int64_t renew_wait_s;
    bool poses_again; /* as soon as the transport is ready */
    wire_message *status;
    wire_message *rejections[SESSION_REJECTIONS_MAX]; /* for the callback */
    size_t rejection_count;
    int64_t rejections_overflowed; /* not kept since the last delivery */
    bool refused;                  /* since the last sync */
    int64_t step_end, step_begin;  /* sequences of the last end of a step that was sent, and of the one before */
    bool step_refused;             /* the end of that step, or what was published for it after its end before */
    char step_refusal[SESSION_ERROR_MAX];
    char first_refusal[SESSION_ERROR_MAX];
    int64_t query, query_epoch; /* sequence that the caller waits for, 0 = none; the epoch it was sent in */
    wire_message *query_reject;
    session_counters counters;

    /* the caller's thread */
    subscription_record *subscriptions;
    int32_t next_body, next_subscription;
    bool in_callback;
    size_t delivered;       /* callbacks run */
    int64_t awaited_step;   /* the one that was ended last; 0 = none was */
    int64_t step_sent_ns;   /* when its end was sent last, monotonic */
    bool step_resumed;      /* poses were published for it since */
    int32_t step_lacks;     /* poses of it that the daemon refused ... */
    uint8_t step_lacks_why; /* ... and why the first of them was */
    int64_t simulation_ns;  /* told with poses; 0 = not given */
    wire_message *answer;
    wire_message **answer_wanted; /* who asks takes it as it is; NULL: nobody */
    collided_rejected *on_rejected;
    void *on_rejected_context;
    wire_message *status_shown;
    collided_counter *status_counters;
    collided_event *events; /* the batch being delivered */
    size_t event_capacity;
    collided_contact_point *points;
    size_t point_capacity;
    collided_impact *impacts;
    size_t impact_capacity;
    struct soft_gathered *soft; /* soft.c */
    scene_room *scene;          /* what is handed to those who observe; NULL: nobody has */
    char error[SESSION_ERROR_MAX];
};

void scene_room_free(scene_room *r); /* observe.c */

int64_t session_monotonic_ns(void);
int64_t session_now_ns(void);            /* the wall clock, for stamps */
int64_t session_seconds(double seconds); /* to nanoseconds; clamped to what adds up without wrapping */

/* The error is kept for collided_error and the status is handed through. The caller's thread. */
collided_status session_fail(collided *c, collided_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
collided_status session_from_callback(collided *c); /* COLLIDED_OK unless a callback is running */

/* With the lock held. */
int session_send(collided *c, const wire_message *m); /* counts what the transport refuses */
void session_wake_keeper(collided *c);
void session_wake_caller(collided *c);
void session_keep_rejection(collided *c, const wire_reject *why);

bool session_unheard(collided *c); /* no daemon has been heard for SESSION_SILENCE_NS */

void *keeper_run(void *client); /* the keeper's thread */

/* bodies.c and poses.c: with the lock held. */
void body_free(collided *c, body_record *body);    /* its memory is for the next one */
void bodies_free(collided *c);                     /* the memory of all */
bool body_has_newer_pose(const body_record *body); /* than the one that is announced */
void body_refresh(body_record *body);              /* the announcement takes the newest pose */
void body_acked(collided *c, body_record *body);   /* sends the pose that was kept until now */
void bodies_remove_all(collided *c);
void poses_send_again(collided *c); /* the newest of each body that the daemon knows */

/* robots.c: with the lock held. */
void robot_forget(collided *c, int32_t carrier); /* that body carries none any more */
void robots_free(collided *c);

/* unheard.c: the keeper, with the lock held. */
int64_t unheard_tend(collided *c, int64_t now_ns); /* when it is due again */
void unheard_reported(collided *c, const wire_reject *why);

/* poses.c: the caller's thread, without the lock. As collided_publish, of bodies that stand where the joints in
 * `extensions` put them: where the daemon knows all of them, and the one that carries the robot, it is sent these. */
typedef struct jointed_poses {
    size_t count;
    const collided_body *bodies;
    const double *positions, *orientations;
    bool teleport;
    int32_t carrier;
    uint8_t *extensions;
    uint32_t extension_count;
} jointed_poses;
collided_status poses_publish_joints(collided *c, const jointed_poses *j, int64_t stamp_ns, int64_t step);

/* poses.c: a batch that tells of a step is about to be delivered; the caller's thread. */
void step_answered(collided *c, subscription_record *subscription, const wire_event_batch *b);

/* subscriptions.c and stream.c: the caller's thread, without the lock. */
void stream_receive(collided *c, const wire_message *m);
void stream_drop_parts(subscription_record *subscription);
void stream_tend(collided *c, int64_t now_ns); /* after receiving: asks again for what does not come */
int64_t stream_next_ns(const collided *c);     /* when that is due */
void subscriptions_sweep(collided *c);         /* frees what was unsubscribed */
void subscriptions_free(collided *c);

/* soft.c */
size_t soft_gather(struct soft_gathered **in, const wire_message *const *parts, size_t part_count); /* pairs */
void soft_deliver(const subscription_record *i, struct soft_gathered *g, const wire_event_batch *b);
void soft_gathered_free(struct soft_gathered *g);

#endif
