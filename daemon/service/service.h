/* service: the parts that stand between the links and the world, and what they share. Tick thread only.
 *
 *   limits   what a client may have and send            memory   how much all of it may take
 *   suspect  what a daemon died over
 *   inbox    commands of a tick, in canonical order          session  clients, and what is theirs
 *   poses    batches of poses to the world
 *   apply    commands to the world, refusals                 geometry hulls, meshes, height fields by content hash
 *   pending  bodies that wait for their geometry             builds   threads that build geometry
 *   stream   the world's events to the links                 answer   queries
 *   backlog  what waits for a slow reader                    record   recordings
 *   health   status and counters
 *   tick     one tick, live or replayed                  server   the loop */
#ifndef COLLIDED_SERVICE_SERVICE_H
#define COLLIDED_SERVICE_SERVICE_H

#include "base/array.h"
#include "base/bytes.h"
#include "base/metrics.h"
#include "base/pace.h"
#include "base/pair_map.h"
#include "base/quantiles.h"
#include "builds.h"
#include "config.h"
#include "exporter.h"
#include "link/link.h"
#include "page.h"
#include "wire/wire_lcm.h"
#include "wire/wire_log.h"
#include "world/world.h"

enum { LINKS_MAX = 8 };

/* ---- sessions ---- */

typedef struct owned_body {
    int32_t number;            /* the client's */
    uint32_t world_id;         /* WORLD_NONE: removed; the entry stays, so that a late copy does not bring it back */
    uint32_t shapes;           /* in the world, as they count in limits */
    int64_t sequence;          /* of the newest Body */
    ARRAY(int64_t) geometries; /* ids of those that it holds, in the order of its shapes */
} owned_body;

/* What a pose needs to know of a client's bodies, in their order: few bytes a body, which are gone through in runs. */
typedef struct pose_rows {
    ARRAY(int32_t) numbers;    /* the client's */
    ARRAY(uint32_t) world_ids; /* WORLD_NONE: removed */
    ARRAY(int64_t) sequences;  /* of the newest pose */
    size_t next;               /* behind the last run */
} pose_rows;

typedef struct owned_interest {
    int32_t number;
    uint32_t world_id;
    int64_t sequence;
    bool live;
} owned_interest;

typedef struct step_mark { /* a simulator's step: the highest of the last tick that had one, and that tick */
    int64_t step, tick;
} step_mark;

typedef struct simulation_mark { /* the time in a simulation: the latest of the last tick that was told one, and that
                                    tick */
    int64_t now_ns, tick;
} simulation_mark;

typedef struct refused_poses { /* of the newest step of a client */
    int32_t count;
    uint8_t reason; /* of the first of them, a wire_reason */
} refused_poses;

typedef struct digests { /* what the pose batches of a step say, but for when they were sent */
    ARRAY(uint64_t) list;
    bool sorted;
} digests;

typedef struct owed_pose { /* a pose of that step is to come (again) before its end counts */
    int64_t step;
    int32_t body;
} owed_pose;

typedef struct held_step { /* poses of a lock-step client, until the step is complete */
    int64_t step;          /* 0: none */
    ARRAY(uint8_t) bytes;  /* messages, each behind its size */
    digests digests;       /* of the messages */
    size_t poses;
    int64_t newest;        /* sequence among them; 0: none */
    bool broken;           /* some were refused: it cannot be ended by what is here */
    int64_t simulation_ns; /* 0: not told */
} held_step;

typedef struct flow { /* how many in a second that began with the first of them; monotonic */
    int64_t began_ns, count;
} flow;

enum { LOST_KEPT = 1024 };

typedef struct lost_client {
    int64_t client;
    uint32_t had; /* bodies and interests */
} lost_client;

/* What a client said before it left may come later than its goodbye, but not so much later. */
#define LATE_NS ((int64_t)5000000000)

typedef struct left_client {  /* in order */
    int64_t client, sequence; /* of its goodbye */
    int64_t since_ns;         /* monotonic */
} left_client;

/* What a client says that it has published, and what of it has come: unheard.c. Sequences; times are monotonic. */
typedef struct hearing {
    int64_t newest;         /* PoseBatch that has come, whatever became of it */
    int64_t said, waits_ns; /* the PoseBatch that is waited for, if it is beyond `newest`: since then */
    int64_t said_ns;        /* its last word; 0: it has said none */
    int64_t tell_ns;        /* when it may be told again */
    int64_t tell_wait_s;    /* 0: it is heard */
} hearing;

/* What a client means by a hash. */
typedef struct geometry_claim {
    int64_t client, hash;
    int64_t geometry;   /* id; 0: taken back. The entry stays, so that a late copy does not bring it back */
    int64_t sequence;   /* of its newest word on it */
    int64_t unanswered; /* the sequence of the piece that came last of all, while it is being built: acknowledged, or
                           refused, when that is over; 0: there is none */
    int32_t last_piece; /* that piece */
    bool leaves;        /* taken back, but a body that waits, and was announced before, is to have it */
} geometry_claim;

typedef struct session {
    int64_t client;
    char *name;
    struct link *link;                              /* by which it came; answers go there */
    int64_t sequence;                               /* of the newest Client */
    int64_t left_sequence;                          /* of the goodbye of the process before it; 0: none is known */
    int64_t lease_ns, heard_ns;                     /* monotonic */
    int64_t letters_tick;                           /* the tick before which the newest of its commands came */
    step_mark step;                                 /* of its poses; step 0: it counts none */
    refused_poses refused;                          /* of that step */
    simulation_mark simulation;                     /* of its poses */
    bool stepped;                                   /* one has come since the last tick that it was answered in */
    bool withheld;                                  /* its answer is: something that the step brought is pending */
    int64_t answered_step;                          /* the last one of which nothing is */
    size_t body_count, shape_count, interest_count; /* in the world */
    int64_t geometry_bytes;                         /* of the geometries that it claims */
    size_t geometry_count;                          /* of those */
    int64_t origin;                                 /* who speaks for it, as its link knows it; 0: nobody knows */
    double spent_us;                                /* of expected work (shares.h), since it is here */
    int64_t geometry_sequence;                      /* of its newest word on one */
    size_t geometries_taken_back;                   /* entries that stay */
    bool claims_leave;                              /* some of its claims may be taken back once no body waits */
    pair_map pending_of;                            /* number of a body that waits for a build + 1 -> its place */
    pair_map pending_needs;                         /* a hash -> how often these bodies name it */
    int64_t pending_bytes;                          /* of those */
    size_t pending_count;                           /* of its bodies, all that wait */
    flow rejects;                                   /* told in the second that runs */
    hearing hearing;
    int32_t lock_step; /* in lock-step with others: how many of them there are to be; 0: it is not */
    int64_t published; /* the newest step that it has published whole */
    int64_t ended;     /* the sequence by which it ended one last; 0: it has ended none */
    bool idle;         /* it missed a step, and is not waited for until it publishes one */
    bool missed;       /* the step that was done last was done without it */
    held_step held;
    ARRAY(owed_pose) owed;  /* what was sent for steps and dropped or refused */
    digests done;           /* of the last step that was done with it */
    int64_t latest_pose_ns; /* the newest stamp of its poses; 0: none is stamped */
    uint64_t pose_count;    /* that it sent */
    uint64_t work;          /* units a tick of its subscriptions, while a Status is made */
    uint8_t on_loss;
    bool announced; /* its Client has come */
    bool lost;
    uint8_t reminders; /* it was lost, and may not know: how often it is yet told so, ... */
    uint32_t had;      /* ... until it has announced so many bodies and interests again, ... */
    int64_t lost_at;   /* ... beyond this sequence */
    bool left;         /* in order: what it keeps is meant to stay */
    pair_map claim_of; /* hash -> index */
    ARRAY(geometry_claim) claims;
    pair_map body_of; /* number + 1 -> index */
    ARRAY(owned_body) bodies;
    pose_rows rows;       /* of the same bodies */
    pair_map interest_of; /* number + 1 -> index */
    ARRAY(owned_interest) interests;
    ARRAY(int64_t) acks; /* to be sent after this tick */
} session;

/* ---- streams ---- */

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
    bool ending; /* its interest is gone, its last batch is not told yet: another may have its name */
    char *name;
    int64_t client;
    int32_t interest;
    struct link *link;
    bool each_tick;     /* its updates are not held back: it answers the steps of its client, too */
    bool told;          /* a batch has been sent */
    int64_t batch;      /* of the last batch made ... */
    int64_t batch_tick; /* ... and the tick of that; a snapshot is none */
    int64_t told_ns;    /* when it last said something, monotonic */
    uint64_t work;      /* units of the world's, told in Status so far */
    uint64_t events;    /* told on it */
    int64_t recorded;   /* the number of its last batch in a recording */
    backlog backlog;
} stream;

/* ---- geometries ---- */

/* Content. While it comes it is one client's; whole, it may be shared by all who sent the very same numbers. */
typedef struct geometry {
    int64_t id;      /* the daemon's own, never used again; 0: this place is free */
    int64_t hash;    /* as its senders say, and as its content has it when whole: other content may have the same */
    uint32_t claims; /* clients that announce it and have not taken it back */
    uint32_t same;   /* place of another whole one with the same hash; PAIR_MAP_NONE: there is none */
    uint8_t kind;
    int32_t pieces, come; /* come: pieces that have arrived */
    size_t vertex_numbers, index_numbers;
    geometry_numbers *numbers; /* as they came: a recording tells them again; ... */
    double *vertices;          /* ... they own these ... */
    int32_t *indices;          /* ... and these */
    uint8_t *has;              /* a flag a piece, while it is coming */
    int64_t client;            /* who sent it first: in its name it is built */
    int64_t completed;         /* the how-manieth of all whose last piece has come; 0: it has not */
    bool is_building;          /* all has come; bodies wait for it */
    build *build;              /* while it is */
    hull *hull;                /* when ready: this one ... */
    mesh *mesh;                /* ... or this one, by its kind */
    uint32_t users;            /* bodies that hold it */
} geometry;

typedef struct told_build { /* to a replay, or a standby: what the daemon that decides did in this tick */
    int64_t client, hash;
    bool ready; /* or put off */
} told_build;

/* ---- inbox ---- */

typedef struct kept_pose { /* the newest one of a body that waits */
    int64_t sequence;      /* 0: none */
    int64_t stamp_ns;
    double position[3], orientation[4], linear[3], angular[3];
    bool has_linear, has_angular;
} kept_pose;

typedef struct letter {
    int64_t client, sequence;
    int64_t since_ns; /* monotonic: the tick in which it came; a Body waits for its hulls for HULL_WAIT_NS */
    int64_t origin;   /* whose it is, as its link knows it (link.h) */
    struct link *link;
    wire_kind kind;
    bool takes_back;     /* a Geometry */
    size_t offset, size; /* of its bytes in inbox.bytes; 0 bytes: the client is lost */
    bool has_waited;     /* a Body, for a build: it may be tried whatever came since */
    uint32_t pose;       /* the place of its pose in inbox.poses + 1; 0: it has none */
} letter;

/* Topics have no order among each other: a Body may come before the Geometry that it names. */
#define HULL_WAIT_NS ((int64_t)1000000000)

typedef struct inbox {
    ARRAY(letter) letters;
    ARRAY(uint8_t) bytes;
    ARRAY(kept_pose) poses; /* of bodies that have waited */
    wire_memory *memory;
    uint64_t effort; /* of the poses among them, see poses_room */
} inbox;

/* ---- bodies that wait for their geometry ---- */

/* A Body that names a geometry that has not come, or is being built: the latter is waited for without end. */
typedef struct pending_body {
    int64_t client, sequence;
    int64_t since_ns; /* monotonic: since then it waits for what has not come */
    int64_t hash;     /* of the first geometry that it lacks */
    struct link *link;
    int32_t body;
    uint32_t shapes;
    bool is_new; /* the client has no such body in the world */
    bool builds; /* what it lacks is being built */
    kept_pose pose;
    char *name;
    ARRAY(int64_t) hashes; /* of all its geometries */
    ARRAY(uint8_t) bytes;  /* the message */
} pending_body;

typedef ARRAY(pending_body) pending_bodies;

/* A limit that was reached is told in Status for so long. */
#define LIMITS_TOLD_NS ((int64_t)60000000000)

/* ---- poses ---- */

typedef struct posing {          /* scratch of one batch */
    bool is_run;                 /* its bodies follow each other among its client's, and all are in the world; ... */
    size_t first;                /* ... from here on. Then `owned`, `ids` and `places` are not filled */
    ARRAY(uint32_t) owned;       /* where its bodies are among its client's */
    ARRAY(uint32_t) ids, places; /* of those that are to be moved: in the world, in the batch, ... */
    ARRAY(int64_t) sequences;    /* ... of their newest pose before */
    ARRAY(uint32_t) left_out;
} posing;

/* ---- all of it ---- */

typedef struct counters { /* metrics that the service itself counts */
    metric *messages_in[WIRE_KIND_COUNT];
    metric *rejects[WIRE_REASON_COUNT];
    metric *rejects_untold, *clients_lost, *duplicates, *batches_out, *events_out, *late_poses, *clock_steps;
    metric *budget_over, *record_failures, *heartbeats, *steps, *steps_missed, *answers, *acks, *tick_ns, *busy_ns,
        *round_longest_ns;
    metric *ticks_on_arrival, *unheard;
    metric *records_refused;
    metric *memory_refused, *suspects_refused;
    metric *batches_skipped;
    metric *queries_cut;
    metric *unknown_extensions;
    metric *takeovers, *steps_down, *out_of_step, *journalled;
} counters;

typedef struct lock_step {
    size_t members;   /* clients in it */
    bool begun;       /* a step was done since there are members: before, so many are waited for as they say */
    int64_t done;     /* the last step that was */
    int32_t missing;  /* members that it was done without */
    bool asked_again; /* a member has not heard of that one */
    bool pending;     /* something of that one is, so that the next one waits */
    int64_t waited;   /* the step that somebody waits for, ... */
    int64_t since_ns; /* ... since then, monotonic; 0: nobody does */
    bool told;        /* that it takes long */
} lock_step;

typedef struct record_wish { /* the last one on recordings, and what was answered */
    int64_t client, sequence;
    uint8_t status;
    char text[WIRE_TEXT_MAX + 1];
} record_wish;

typedef struct record_telling { /* of what a recording that begins in the middle is told: how far that has come */
    bool runs;
    bool geometries_told;
    int64_t hash;           /* of the last claim of the next client on a geometry that was told; 0: none */
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

typedef struct measures { /* for the page that Prometheus reads */
    histogram latency, tick, age, width;
    quantiles latencies, ticks; /* since the last Status, which tells them */
} measures;

typedef struct taken_state {    /* of the recording that is replayed */
    bool is_there;              /* since the last tick ended; ... */
    bool stands;                /* ... and it is that of the tick that ends now, which is not run */
    uint64_t events;            /* that the daemon had told until then */
    char wrong[128], left[192]; /* it is damaged; or it is of another build, and was left out: "" = not */
} taken_state;

typedef struct shares shares; /* shares.h */

typedef struct service {
    config config;
    char daemon_name[128];
    metrics *metrics;
    counters count;
    measures measures;
    struct sheet *sheet; /* the figures of a Status */
    exporter *exporter;  /* NULL: none */
    page_text page;      /* its next page */
    world *world;
    struct link *links[LINKS_MAX];
    size_t link_count;
    int wake_fd;
    int64_t epoch, tick, started_ns;
    int64_t now_ns, monotonic_ns; /* of this tick */
    int64_t wall_ahead_ns;        /* of the monotonic clock, at the last tick; 0: there was none */
    int64_t latest_pose_ns;       /* the newest stamp of all poses ... */
    int64_t measured_pose_ns;     /* ... and before the last tick */
    step_mark latest_step;        /* of all clients */
    simulation_mark simulation;   /* of all clients */
    lock_step lock_step;
    int64_t last_batch;        /* the highest number in streams that have ended */
    int64_t next_heartbeat_ns; /* monotonic; none is due before */
    int64_t next_watch_ns;     /* of what waits on streams, monotonic; INT64_MAX: nothing does */
    size_t streams_behind, streams_starving;
    char starving[384]; /* the first stream that starves, for people; "" = none does */
    size_t clients_unheard;
    char unheard[256]; /* the first of them, for people; "" = all are heard */
    wire_memory *backlog_memory;
    uint64_t events_hash;
    pace pace;                           /* of a budget */
    uint64_t slice;                      /* units of this tick's slice; 0: it is not cut */
    double slice_unit_ns;                /* what a unit of it takes, as learnt */
    int64_t pending_ns, pending_last_ns; /* since when something has been pending, and at which tick last, monotonic */
    uint64_t recorded_work;              /* of this tick, in a replay ... */
    bool recorded_budget;                /* ... of one with a budget */
    struct memory_gauge *memory;         /* memory.h */
    struct suspect_watch *suspects;      /* suspect.c's; NULL: nothing is kept */
    int64_t pairs_most;                  /* in this tick, of max_pairs, for want of memory, or as recorded; 0: all */
    taken_state taken;
    int64_t status_tick; /* of the last Status */
    bool replaying, stopping;
    broad_kind told_broad; /* what the log says last; BROAD_AUTO: nothing yet */
    uint8_t health;
    bool whole;                     /* nobody has anything to announce any more that was there before the start */
    int64_t began_ns, announced_ns; /* the links were opened; something new was announced last; monotonic */
    char settling[160];             /* why it is not whole */

    flow rejects; /* of clients without a session */
    ARRAY(session *) sessions;
    pair_map session_of;                 /* client -> index */
    lost_client lost_clients[LOST_KEPT]; /* a ring of the newest that were lost, some of which may live */
    size_t lost_count;
    left_client left_clients[LOST_KEPT]; /* a ring of the newest */
    size_t left_count;
    ARRAY(stream) streams;                 /* by the world's interest id */
    pair_map open_streams, ending_streams; /* by name: see stream_names.c */
    ARRAY(geometry) geometries;
    pair_map geometry_of;    /* id -> place */
    pair_map geometry_whole; /* hash -> place of one that is whole; `same` leads to the others */
    int64_t geometry_last;   /* the newest id */
    bool claims_leave;       /* some session's do */
    size_t geometry_hint;    /* no place before it is free */
    int64_t geometries_completed;
    size_t geometries_building;
    builds *builds;
    uint64_t built_units;          /* in this tick, at once */
    ARRAY(told_build) told_builds; /* for this tick */
    pending_bodies pending;
    size_t pending_new, pending_shapes; /* of those that wait for a build: bodies that are new, and shapes */
    size_t pending_missing;             /* those that wait for what has not come, ... */
    int64_t pending_since_ns;           /* ... and since when the first of them */
    size_t pending_gaps;                /* places of those that are gone */
    bool pending_left;                  /* there are more that may be tried than this tick has taken up */
    struct {
        int64_t lacks;   /* the first geometry that it lacks */
        bool has_waited; /* for a build */
        kept_pose pose;  /* of a body that has */
    } carried;           /* with the command that is carried out */
    bool poses_only;     /* a link's thread stands in: nothing but poses is carried out */
    inbox inbox;
    posing posing;
    bool stepped;              /* since the last tick: its streams are told of the step */
    ARRAY(world_shape) shapes; /* scratch of apply */
    ARRAY(compound *) compounds;
    ARRAY(filter_rule) rules;
    wire_log_writer *recording;   /* NULL: nothing is recorded, ... */
    wire_log_writer *record_next; /* ... but this is about to, when there is room for its beginning */
    bytes_out record_room;        /* for the state that it begins with */
    struct record_file *recording_to;
    record_beginner recording_of;
    record_telling record_telling;
    ARRAY(struct record_file *) record_ends; /* recordings that have ended, and are not on the disk yet */
    bool state_due; /* the recording began in the middle: its state is written when the tick ends */
    record_wish record_wish;
    record_reply record_reply;
    char limits[512];        /* named limits that were reached in the last LIMITS_TOLD_NS */
    int64_t limit_ns;        /* when the last of them was, monotonic */
    bool hull_came;          /* since waiting commands were last tried */
    bool geometries_loose;   /* some may have nobody who wants them any more */
    struct standby *standby; /* NULL: not one of a pair */
    shares *shares;          /* of each participant */
    bool status_due;         /* before its time */
    struct part *part;       /* scratch of stream.c: of a batch that is being told */
    /* What a measurement asks instead of what the clients ask; NULL: nothing. */
    void (*amend_interest)(const void *context, world_interest *def);
    const void *amend_context;
    /* Who hears of each tick before it is published; NULL: nobody. */
    void (*on_batches)(void *context, const world_batches *batches);
    void *on_batches_context;
    /* Called ten times a second while a standby waits for a build that the active daemon has had; NULL: nobody. */
    void (*on_waiting)(void *context);
    void *on_waiting_context;
    /* Who hears of each command and query before it is carried out; NULL: nobody. */
    void (*on_command)(void *context, const wire_message *m);
    void *on_command_context;
} service;

/* session.c */
session *session_find(service *s, int64_t client);
session *session_get(service *s, int64_t client, struct link *from); /* NULL: too many clients */
owned_body *session_body(session *c, int32_t number);
owned_body *session_add_body(session *c, int32_t number);
void session_add_row(session *c, int32_t number, uint32_t world_id, int64_t pose_sequence); /* of the body added last */
static inline int64_t *session_pose_sequence(session *c, const owned_body *b)
{
    return &c->rows.sequences.at[b - c->bodies.at];
}
void session_count_body(session *c, owned_body *b, uint32_t world_id, size_t shapes);
owned_interest *session_interest(session *c, int32_t number);
owned_interest *session_add_interest(session *c, int32_t number);
void session_find_interests(session *c);               /* by their numbers, where all have come at once */
int64_t session_newest_sequence(const session *c);     /* of all that it said and was applied */
void session_heard(service *s, const wire_message *m); /* a sign of life, before it is applied */
void session_lost(service *s, session *c, const char *how);
/* A lost client that is heard again, with a message of that kind, is told that it was lost, until it has announced as
 * much as it had. */
void session_remind(service *s, session *c, wire_kind kind);
void session_leave(service *s, session *c);
/* Its goodbye came later than words of the next process under that id: what it had, and nothing else, ends. */
void session_leave_before(service *s, session *c, int64_t sequence);
void session_remember_left(service *s, int64_t client, int64_t sequence);
/* The sequence of its goodbye, if it left a short time ago, or another process under its id has come since; else 0. */
int64_t session_left_at(service *s, int64_t client);
void session_check_leases(service *s);
int64_t session_next_lease_ns(const service *s); /* monotonic; INT64_MAX: none */
void session_ack(session *c, int64_t sequence);
void session_send_acks(service *s);
size_t session_bodies(const session *c); /* in the world */
void session_free_all(service *s);

/* geometry.c */
typedef struct geometry_share { /* what one piece holds of the whole: vertices first, then indices */
    size_t first_vertex, vertices, first_index, indices;
} geometry_share;
int64_t geometry_bytes(int64_t vertex_numbers, int64_t index_numbers); /* of its numbers in memory */
geometry_share geometry_share_of(const geometry *g, int32_t piece);
/* *later: it is not acknowledged now, but when it has been built. */
wire_reason geometry_put(service *s, session *c, const wire_geometry *m, wire_refusal *why, bool *later);
int64_t geometry_claimed(service *s, int64_t client, int64_t hash); /* its id; 0: the client has sent none */
const geometry *geometry_at(const service *s, int64_t id);          /* NULL: there is none */
/* The hull or mesh of a shape of that type, WIRE_SHAPE_*; false: it is not whole, or of another kind. */
bool geometry_lend(const service *s, int64_t id, uint8_t wire_type, shape *to);
void geometry_hold(service *s, int64_t id);
void geometry_release(service *s, int64_t id);
void geometry_forget(service *s, session *c); /* what it alone announced and no body holds may go */
void geometry_sweep(service *s);              /* frees what nobody wants; after a tick */
void geometry_free_all(service *s);
/* Behind the others, as it was elsewhere: numbers and `has` become its own. It is built, if it was. */
wire_reason geometry_restore(service *s, const geometry *bare, wire_refusal *why);
void geometry_restore_builds(service *s); /* when all are there: what was being built is being built again */
typedef enum geometry_state { GEOMETRY_MISSING, GEOMETRY_BUILDING, GEOMETRY_READY } geometry_state;
/* Of what the client means by that hash. */
geometry_state geometry_state_of(service *s, int64_t client, int64_t hash);
void geometry_builds_end(service *s); /* the first thing in a tick: what is ready from then on */
void geometry_tell(service *s, int64_t client, int64_t hash, bool ready); /* what another daemon did in this tick */
void geometry_let_go(service *s); /* what was taken back, and no body waits for any more */

/* inbox.c */
void inbox_put(service *s, struct link *from, const wire_message *m);
void inbox_put_lost(service *s, struct link *from, int64_t client);
void inbox_apply(service *s);
void inbox_answer(service *s); /* the queries among them; after the tick */

/* pending.c */
/* That letter, a Body, was tried in vain: s->carried.lacks says why. Answered, if a limit refuses it. */
void pending_put(service *s, const letter *l, const wire_body *m);
/* Is it newer than what waits of the same body for a build, or the same, or older? */
typedef enum pending_copy { PENDING_NEWER, PENDING_SAME, PENDING_OLDER } pending_copy;
pending_copy pending_is_copy(const service *s, const session *c, const wire_body *m);
/* It has been carried out, or waits: what waited for a build before it is gone, but its pose, if that is newer. */
void pending_supersede(service *s, session *c, const wire_body *m, kept_pose *pose);
bool pending_wake(service *s); /* those that may be tried become letters again, behind the others: were there any? */
bool pending_due(const service *s);
void pending_tidy(service *s);             /* after the commands of a tick: until then some places are of nobody */
void pending_wait_anew(service *s);        /* they have waited for nothing yet */
int64_t pending_next_ns(const service *s); /* when one of them has waited too long, monotonic; INT64_MAX: never */
bool pending_needs(const session *c, int64_t hash); /* one of its bodies that wait for a build */
bool pending_keeps_pose(service *s, session *c, const wire_pose_batch *m, uint32_t i); /* of a body that waits */
void pending_forget(service *s, int64_t client, int64_t before); /* of that client, announced before */
void pending_restore(service *s, pending_body *p);               /* becomes the service's */
void pending_free_all(service *s);

/* poses.c */
void apply_note_simulation(simulation_mark *last, int64_t tick, int64_t simulation_ns);
void apply_poses(service *s, struct link *from, const wire_pose_batch *m, bool may_wait);
void apply_forget_refused(session *c, int64_t tick, int64_t step); /* before the poses of that step */
void apply_count_refused(session *c, uint32_t more, wire_reason reason);
bool poses_are_enough(const service *s); /* for a tick: what they move is worth one */
/* See link_sink.room. */
size_t poses_room(service *s, const wire_pose_batch *m, uint64_t *work);
void apply_poses_now(service *s, session *c, struct link *from, const wire_pose_batch *m); /* c: NULL if unknown */
void poses_give(service *s, session *c, const owned_body *b, const kept_pose *p);          /* if none is newer */
void poses_free(service *s);

/* apply.c */
/* False: it names a hull that has not come; nothing was done, and it may be tried again. */
bool apply_command(service *s, struct link *from, const wire_message *m, bool may_wait);
void apply_reject(service *s, struct link *to, wire_kind kind, int64_t client, int64_t sequence, int32_t object,
    const wire_refusal *why);
void apply_name_limit(service *s, const char *option); /* it is reached */
bool apply_limit(service *s, size_t now, long most, const char *option, wire_refusal *why);

/* unheard.c: clients that publish, and of whom nothing comes */
void unheard_poses(service *s, const wire_pose_batch *m); /* one has come, whatever becomes of it */
void unheard_word(service *s, const wire_receipt *m);     /* a Receipt of no stream: epoch 0 */
void unheard_watch(service *s);                           /* before each Status */

/* limits.c: what a client may have, and how fast it may talk */
bool limits_admit(service *s, struct link *from, const wire_message *m, wire_refusal *why);
bool limits_bodies(service *s, const session *c, bool is_new, wire_refusal *why);
bool limits_shapes(service *s, const session *c, size_t instead_of, size_t more, wire_refusal *why);
bool limits_interests(service *s, const session *c, wire_refusal *why);
bool limits_geometry(service *s, const session *c, const wire_geometry *m, wire_refusal *why);
bool limits_tell_reject(service *s, int64_t client);

/* stream.c */
bool stream_taken(service *s, const session *c, const wire_interest *m, uint32_t world_id, wire_refusal *why);
void stream_open(service *s, session *c, const wire_interest *m, uint32_t world_id);
void stream_end(service *s, uint32_t world_id, uint8_t cause); /* and the interest with it, in the next tick */
void stream_close(service *s, uint32_t world_id);
/* stream_names.c: to be found by its name, which has to be there, and by whether it ends. */
void stream_names_add(service *s, uint32_t world_id);
void stream_names_drop(service *s, uint32_t world_id);
stream *stream_named(service *s, const char *name);        /* the open one, or NULL */
const stream *stream_ending(service *s, const char *name); /* the one of them that ended last, or NULL */
void stream_reader(service *s, struct link *from, const char *name);
bool stream_lacks_reader(service *s, const char *name); /* it is open, and none has come */
/* What the tick tells, snapshots apart, on every stream, whether it has a reader or not: as it is recorded. The message
 * is valid during the visit. Before stream_publish, which closes streams. */
typedef void stream_visit(void *context, const wire_message *m);
void stream_each(service *s, const world_batches *batches, stream_visit *visit, void *context);
void stream_ask_all(service *s); /* before the tick: lock-step clients are told also what is as it was */
void stream_publish(service *s, const world_batches *batches);
void stream_heartbeats(service *s); /* on those that have been silent for a period */
void stream_free_all(service *s);

void stream_receipt(service *s, const wire_receipt *m);

/* backlog.c */
bool backlog_is_behind(const backlog *b); /* something waits */
int64_t backlog_count(const backlog *b);  /* so many messages */
bool backlog_is_passed(const service *s, const stream *to, const world_batch *batch, int32_t parts);
bool backlog_begin(service *s, stream *to, const world_batch *batch); /* false: it is not kept, but skipped */
void backlog_skip(service *s, stream *to, int32_t parts);
void backlog_put(stream *to, const wire_message *m);
/* A snapshot that comes in portions: with the head of its parts; a part, whose number it fills in; and all of them, in
 * front of what has come to wait since. */
void backlog_build(service *s, stream *to, const wire_event_batch *head);
void backlog_add_built(service *s, stream *to, wire_message *m);
void backlog_built(service *s, stream *to);
void backlog_send(service *s, stream *to); /* as much as may be under way */
void backlog_receipt(service *s, stream *to, const wire_receipt *m);
void backlog_watch(service *s); /* sends what is due, and finds out who starves; each round */
void backlog_clear(backlog *b);
void backlog_free(backlog *b);

/* steps.c */
/* The sequence of what the daemon says in a client's name, and records. A batch without bodies ends a step for a client
 * that missed it: what it published of it is dropped. One with a body says that poses of that step were refused. */
#define STEP_IN_ITS_NAME INT64_MAX
bool steps_admit(const service *s, const wire_message *m, wire_refusal *why); /* that sequence is not for clients */
bool steps_take(service *s, session *c, struct link *from, const wire_pose_batch *m); /* true: it is of lock-step */
void steps_refused(service *s, struct link *from, const wire_message *m); /* for its rate: it has not been recorded */
void steps_join(service *s, session *c, int32_t lock_step);               /* 0: leaves */
bool steps_due(const service *s);           /* a step is complete, or asked for again: a tick is due */
void steps_complete(service *s);            /* applies a step that is */
void steps_watch(service *s);               /* who misses a step; before each round, not in a replay */
int64_t steps_next_ns(const service *s);    /* when somebody may miss one, monotonic; INT64_MAX: nobody */
void steps_settle(service *s);              /* after the world's tick: who may be answered */
void steps_began(service *s, int64_t done); /* a replay begins in the middle, before its first tick */
void steps_record(service *s, session *c);
void steps_free(session *c);

/* answer.c */
void answer_query(service *s, struct link *from, const wire_query *q);
void answer_owed(service *s); /* to who ended a recording */

/* tick.c */
void service_set_budget(service *s);                                  /* of the configuration */
void service_replay_budget(service *s, bool budgeted, uint64_t work); /* of the tick that is replayed next */
/* tick.c. A slice is chosen by what earlier ones took, before the tick, and is recorded where it made a difference: so
 * a replay, which is told it, does the same. */
void service_choose_slice(service *s, int64_t spent_ns); /* by this round, before the tick */
void service_learn_slice(service *s, int64_t took_ns);
bool service_is_behind(const service *s);      /* something is pending for long, or was so a moment ago */
uint64_t service_slice_told(const service *s); /* for the recording; 0: it made none */
/* How many pairs the tick that has just been run could have, for want of memory; 0: that has left out none. */
int64_t service_pairs_limited(const service *s);
void service_tick(service *s);             /* of number s->tick, at s->now_ns */
const char *service_validate(service *s);  /* between ticks: what is broken of what is kept twice, or NULL */
void service_follow_clock(service *s);     /* what the world knows goes back with it */
bool service_clock_back(const service *s); /* the wall clock was set back since the last tick: one is due */
void service_take(service *s, struct link *from, const wire_message *m); /* a command that is admitted */
void service_tell_broad(service *s); /* logs the broad phase that stands, if the log says another one */

/* ready.c: is the world whole? */
void ready_begin(service *s);            /* the links are open; it is not */
void ready_announced(service *s);        /* something that the world did not have has come */
bool ready_check(service *s);            /* false: not yet, and `settling` says why. Once true, always */
int64_t ready_next_ns(const service *s); /* when to check again, monotonic; INT64_MAX: never */

/* server.c */
void service_reset(service *s); /* clients and world are gone as if they had never been; the links stay */

/* health.c */
void health_define(measures *m);
void health_register(service *s);
void health_publish(service *s);
enum { HEALTH_LIMITS_MAX = 1700 };
void health_limits(
    const service *s, char *text, size_t size); /* starving streams, unheard clients, suspects; "" = all is well */
const char *health_release(void);

/* standby_state.c: the whole state between two ticks, for a standby, and for a recording that begins in the middle */
void state_put(service *s, bytes_out *to);
size_t state_size(const service *s); /* about as many bytes as that will be */
/* Of this release and build? If not, it says of which. */
bool state_fits(const uint8_t *bytes, size_t size, char *why, size_t why_size);
bool state_take(service *s, bytes_in *from, char *why, size_t why_size); /* into an empty service */

/* record.c, record_state.c */
size_t record_state_size(const service *s); /* about as many bytes as record_state takes */
/* All that is announced now, as if it came anew: begins with it, and goes on for so long (ns), but tells something at
 * least. True when all has been told; what clients say meanwhile is recorded beside it. */
void record_state_begin(service *s);
bool record_state_more(service *s, int64_t most_ns);
void record_state_end(service *s); /* whatever is left */
/* The state follows with the tick's end. `client`: who asked for it, or NULL: the configuration. */
int record_start(service *s, const char *path, const int64_t *client, char *why, size_t why_size);
/* May a query of that client end it? If not, it says who may. */
bool record_may_end(const service *s, int64_t client, char *why, size_t why_size);
void record_watch(service *s); /* notices recordings that end of themselves, and that are on the disk; each round */
bool record_wants_tick(const service *s); /* it is about to begin */
int64_t record_next_ns(const service *s); /* when to do so again, monotonic; INT64_MAX: with anything else */
void record_stop_now(service *s);         /* of a daemon that ends: waits for the disk */
/* As configured, of a daemon of a pair that becomes active: FILE, or FILE.1, FILE.2, ... if it is there. */
void record_begin(service *s);
void record_message(service *s, const wire_message *m);
void record_events(service *s, const world_batches *batches); /* before they are published */
void record_tick(service *s);
void record_lost(service *s, int64_t client);
void record_build(service *s, int64_t client, int64_t hash, bool ready);
void record_steps(service *s); /* how far lock-step is, if it has begun */
void record_stop(service *s);

#endif
