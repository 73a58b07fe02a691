/* client_state: what the service knows of a client, and of those that have gone. */
#ifndef COLLIDED_SERVICE_CLIENT_STATE_H
#define COLLIDED_SERVICE_CLIENT_STATE_H

#include "base/array.h"
#include "base/pair_map.h"
#include "link/link.h"
#include "wire/wire_lcm.h"
#include "world/world.h"

typedef struct owned_body {
    int32_t number;            /* the client's */
    uint32_t world_id;         /* WORLD_NONE: removed; the entry stays, so that a late copy does not bring it back */
    uint32_t shapes;           /* in the world, as they count in limits */
    uint32_t soft;             /* vertices of a soft one, as they count in limits; 0: it is rigid */
    int64_t sequence;          /* of the newest Body */
    ARRAY(int64_t) geometries; /* ids of those that it holds, in the order of its shapes */
    struct model *model;       /* the robot that it carries; NULL: none */
} owned_body;

/* What a pose needs to know of a client's bodies, in their order: few bytes a body, which are gone through in runs. */
typedef struct pose_rows {
    ARRAY(int32_t) numbers;    /* the client's */
    ARRAY(uint32_t) world_ids; /* WORLD_NONE: removed */
    ARRAY(int64_t) sequences;  /* of the newest pose */
    size_t next;               /* behind the last run */
} pose_rows;

typedef struct owned_subscription {
    int32_t number;
    uint32_t world_id;
    int64_t sequence;
    bool live;
} owned_subscription;

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
    int64_t simulation_ns; /* 0: not given */
} held_step;

typedef struct flow { /* how many in a second that began with the first of them; monotonic */
    int64_t began_ns, count;
} flow;

enum { LOST_KEPT = 1024 };

typedef struct lost_client {
    int64_t client;
    uint32_t had; /* bodies and subscriptions */
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
    int64_t report_ns;      /* when it may be reported again */
    int64_t report_wait_s;  /* 0: it is heard */
    bool lost, lost_poses;  /* something of it, perhaps, was lost on its way, and it has not been told; poses alone */
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
    struct link *link;                                  /* by which it came; answers go there */
    int64_t sequence;                                   /* of the newest Client */
    int64_t left_sequence;                              /* of the goodbye of the process before it; 0: none is known */
    int64_t lease_ns, last_seen_ns;                     /* monotonic */
    int64_t commands_tick;                              /* the tick before which the newest of its commands came */
    step_mark step;                                     /* of its poses; step 0: it counts none */
    refused_poses refused;                              /* of that step */
    simulation_mark simulation;                         /* of its poses */
    bool stepped;                                       /* one has come since the last tick that it was answered in */
    bool withheld;                                      /* its answer is: something that the step brought is pending */
    int64_t answered_step;                              /* the last one of which nothing is */
    size_t body_count, shape_count, subscription_count; /* in the world */
    size_t soft_vertices;                               /* of its soft bodies, as they count in limits */
    int64_t geometry_bytes;                             /* of the geometries that it claims */
    size_t geometry_count;                              /* of those */
    int64_t origin;                                     /* who speaks for it, as its link knows it; 0: nobody knows */
    double spent_us;                                    /* of expected work (shares.h), since it is here */
    int64_t geometry_sequence;                          /* of its newest word on one */
    size_t geometries_taken_back;                       /* entries that stay */
    bool claims_leave;                                  /* some of its claims may be taken back once no body waits */
    pair_map pending_of;                                /* number of a body that waits for a build + 1 -> its place */
    pair_map pending_needs;                             /* a hash -> how often these bodies name it */
    int64_t pending_bytes;                              /* of those */
    size_t pending_count;                               /* of its bodies, all that wait */
    flow rejects;                                       /* told in the second that runs */
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
    uint32_t had;      /* ... until it has announced so many bodies and subscriptions again, ... */
    int64_t lost_at;   /* ... beyond this sequence */
    bool left;         /* in order: what it keeps is meant to stay */
    pair_map claim_of; /* hash -> index */
    ARRAY(geometry_claim) claims;
    pair_map body_of; /* number + 1 -> index */
    ARRAY(owned_body) bodies;
    pose_rows rows;           /* of the same bodies */
    pair_map subscription_of; /* number + 1 -> index */
    ARRAY(owned_subscription) subscriptions;
    ARRAY(int64_t) acks; /* to be sent after this tick */
} session;

typedef struct lock_step {
    size_t members;   /* clients in it */
    bool begun;       /* a step was done since there are members: before, so many are waited for as they say */
    int64_t done;     /* the last step that was */
    int32_t missing;  /* members that it was done without */
    bool asked_again; /* a member has not heard of that one */
    bool pending;     /* something of that one is, so that the next one waits */
    int64_t waited;   /* the step that somebody waits for, ... */
    int64_t since_ns; /* ... since then, monotonic; 0: nobody does */
    bool reported;    /* that it takes long */
} lock_step;

#endif
