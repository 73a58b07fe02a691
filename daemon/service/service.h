/* service: what the parts that stand between the links and the world share, and the tick, the loop and the figures.
 * Tick thread only. What the parts have is in client_state.h, stream_state.h, geometry_state.h, command_state.h and
 * recording_state.h; what they do, in the headers that are named here:
 *
 *   clients.h    session  clients, and what is theirs        limits   what a client may have and send
 *                unheard  who publishes, and does not reach us
 *   commands.h   inbox    commands of a tick, in canonical order
 *                apply    commands to the world, refusals    poses    batches of poses to the world
 *                pending  bodies that wait for their geometry
 *                steps    clients in lock-step               answer   queries
 *   geometries.h geometry hulls, meshes, height fields by content hash
 *   streams.h    stream   the world's events to the links    backlog  what waits for a slow reader
 *   recordings.h record   recordings
 *   service.h    tick     one tick, live or replayed         server   the loop
 *                health   status and counters                ready    is the world whole?
 *   and their own: memory how much all of it may take; suspect what a daemon died over; builds threads that build
 *   geometry */
#ifndef COLLIDED_SERVICE_SERVICE_H
#define COLLIDED_SERVICE_SERVICE_H

#include "base/bytes.h"
#include "base/metrics.h"
#include "base/pace.h"
#include "base/quantiles.h"
#include "client_state.h"
#include "command_state.h"
#include "config.h"
#include "exporter.h"
#include "geometry_state.h"
#include "page.h"
#include "recording_state.h"
#include "stream_state.h"
#include "vertex_state.h"
#include "wire/wire_log.h"

enum { LINKS_MAX = 8 };

/* A limit that was reached is told in Status for so long. */
#define LOSSES_REPORTED_NS ((int64_t)5000000000)
#define LIMITS_REPORTED_NS ((int64_t)60000000000)

typedef struct counters { /* metrics that the service itself counts */
    metric *messages_in[WIRE_KIND_COUNT];
    metric *rejects[WIRE_REASON_COUNT];
    metric *rejects_untold, *clients_lost, *duplicates, *batches_out, *events_out, *late_poses, *joints_beyond,
        *clock_steps;
    metric *budget_over, *record_failures, *heartbeats, *steps, *steps_missed, *answers, *acks, *tick_ns, *busy_ns,
        *round_longest_ns, *round_most_cpu_ns;
    metric *ticks_on_arrival, *unheard, *messages_lost;
    metric *records_refused;
    metric *memory_refused, *suspects_refused;
    metric *batches_skipped;
    metric *queries_cut;
    metric *unknown_extensions;
    metric *scene_batches, *scene_poses;
    metric *incomplete_frames;
    metric *takeovers, *steps_down, *out_of_step, *journalled;
} counters;

typedef struct measures { /* for the page that Prometheus reads */
    histogram latency, tick, age, width;
    quantiles latencies, ticks; /* since the last Status, which tells them */
} measures;

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
    size_t heartbeat_turn;     /* stream that is looked at first when some are */
    int64_t next_watch_ns;     /* of what waits on streams, monotonic; INT64_MAX: nothing does */
    size_t scenes;             /* streams of scenes: what they have is told by scene.c */
    int64_t next_scene_ns;     /* when one of them may be told more, monotonic */
    int64_t scene_tick;        /* the tick as of which that was found out ... */
    bool scene_behind;         /* ... and somebody was not told then what it brought */
    size_t streams_behind, streams_starving;
    char starving[384]; /* the first stream that starves, for people; "" = none does */
    size_t clients_unheard;
    char unheard[256];         /* the first of them, for people; "" = all are heard */
    char samples_lost[160];    /* what a transport lost in the last LOSSES_REPORTED_NS, for people; "" = nothing */
    int64_t samples_lost_ns;   /* when it did so last, monotonic */
    int64_t unheard_report_ns; /* when the next of them may be told, monotonic, ... */
    size_t unheard_first;      /* ... and which session's turn it is */
    wire_memory *backlog_memory;
    int64_t backlog_round_ns; /* the round, ... */
    size_t backlog_sent;      /* ... and the bytes of what waited that were sent in it */
    size_t backlog_turn;      /* the stream that goes first in the next */
    bool backlog_crowded;     /* more waits than a round takes */
    uint64_t events_hash;
    pace pace;                           /* of a budget */
    uint64_t slice;                      /* units of this tick's slice; 0: it is not cut */
    double slice_unit_ns;                /* what a unit of it takes, as learnt */
    double effort_unit_ns;               /* the same of world_effort; ... */
    double received_us;                  /* expected work of what came in this round and is no poses */
    double receive_look_us;              /* of it, when the clock is read again */
    int64_t receive_began_ns;            /* this thread's, of a processor; 0: the clock says nothing */
    int64_t pending_ns, pending_last_ns; /* since when something has been pending, and at which tick last, monotonic */
    uint64_t recorded_work;              /* of this tick, in a replay ... */
    bool recorded_budget;                /* ... of one with a budget */
    struct memory_gauge *memory;         /* memory.h */
    struct suspect_watch *suspects;      /* suspect.c's; NULL: nothing is kept */
    int64_t pairs_most;                  /* in this tick, of max_pairs, for want of memory, or as recorded; 0: all */
    taken_state taken;
    int64_t status_tick; /* of the last Status */
    bool replaying, stopping;
    broad_kind reported_broad; /* what the log says last; BROAD_AUTO: nothing yet */
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
    ARRAY(stream) streams;                 /* by the world's subscription id */
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
    uint64_t built_units;                  /* in this tick, at once */
    ARRAY(reported_build) reported_builds; /* for this tick */
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
    vertex_state vertices;
    posing posing;
    expanded_poses expanded;
    int64_t joints_report_ns;  /* when one beyond its limits may be logged again, monotonic */
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
    char limits[512];        /* named limits that were reached in the last LIMITS_REPORTED_NS */
    int64_t limit_ns;        /* when the last of them was, monotonic */
    bool hull_came;          /* since waiting commands were last tried */
    bool geometries_loose;   /* some may have nobody who wants them any more */
    struct standby *standby; /* NULL: not one of a pair */
    shares *shares;          /* of each participant */
    bool status_due;         /* before its time */
    bool status_asked;       /* somebody has come who reads it: soon */
    struct part *part;       /* scratch of stream.c: of a batch that is being told */
    /* What a measurement asks instead of what the clients ask; NULL: nothing. */
    void (*amend_subscription)(const void *context, world_subscription *def);
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

/* tick.c */
void service_set_budget(service *s);                                  /* of the configuration */
void service_replay_budget(service *s, bool budgeted, uint64_t work); /* of the tick that is replayed next */
/* tick.c. A slice is chosen by what earlier ones took, before the tick, and is recorded where it made a difference: so
 * a replay, which is told it, does the same. */
void service_choose_slice(service *s, int64_t spent_ns); /* by this round, before the tick */
void service_learn_slice(service *s, int64_t took_ns);
/* Likewise what it takes to put bodies anew, of a tick for which so much of world_effort was due. */
void service_learn_effort(service *s, uint64_t effort, int64_t took_ns);
bool service_is_behind(const service *s);          /* something is pending for long, or was so a moment ago */
uint64_t service_slice_reported(const service *s); /* for the recording; 0: it made none */
/* How many pairs the tick that has just been run could have, for want of memory; 0: that has left out none. */
int64_t service_pairs_limited(const service *s);
void service_tick(service *s);             /* of number s->tick, at s->now_ns */
const char *service_validate(service *s);  /* between ticks: what is broken of what is kept twice, or NULL */
void service_follow_clock(service *s);     /* what the world knows goes back with it */
bool service_clock_back(const service *s); /* the wall clock was set back since the last tick: one is due */
void service_take(service *s, struct link *from, const wire_message *m); /* a command that is admitted */
void service_report_broad(service *s); /* logs the broad phase that stands, if the log says another one */

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

#endif