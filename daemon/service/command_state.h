/* command_state: commands of a tick, bodies that wait for their geometry, and scratch of a batch of poses. */
#ifndef COLLIDED_SERVICE_COMMAND_STATE_H
#define COLLIDED_SERVICE_COMMAND_STATE_H

#include "base/array.h"
#include "link/link.h"
#include "wire/wire_lcm.h"

typedef struct kept_pose { /* the newest one of a body that waits */
    int64_t sequence;      /* 0: none */
    int64_t stamp_ns;
    double position[3], orientation[4], linear[3], angular[3];
    bool has_linear, has_angular;
} kept_pose;

typedef struct command {
    int64_t client, sequence;
    int64_t since_ns; /* monotonic: the tick in which it came; a Body waits for its hulls for HULL_WAIT_NS */
    int64_t origin;   /* whose it is, as its link knows it (link.h) */
    struct link *link;
    wire_kind kind;
    bool takes_back;     /* a Geometry */
    size_t offset, size; /* of its bytes in inbox.bytes; 0 bytes: the client is lost */
    bool has_waited;     /* a Body, for a build: it may be tried whatever came since */
    uint32_t pose;       /* the place of its pose in inbox.poses + 1; 0: it has none */
} command;

/* Topics have no order among each other: a Body may come before the Geometry that it names. */
#define HULL_WAIT_NS ((int64_t)1000000000)

typedef struct inbox {
    ARRAY(command) commands;
    ARRAY(uint8_t) bytes;
    ARRAY(kept_pose) poses; /* of bodies that have waited */
    wire_memory *memory;
    uint64_t effort; /* of the poses among them, see poses_room */
} inbox;

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

typedef struct posing {          /* scratch of one batch */
    bool is_run;                 /* its bodies follow each other among its client's, and all are in the world; ... */
    size_t first;                /* ... from here on. Then `owned`, `ids` and `places` are not filled */
    ARRAY(uint32_t) owned;       /* where its bodies are among its client's */
    ARRAY(uint32_t) ids, places; /* of those that are to be moved: in the world, in the batch, ... */
    ARRAY(int64_t) sequences;    /* ... of their newest pose before */
    ARRAY(uint32_t) left_out;
} posing;

typedef struct expanded_poses { /* scratch of one batch with joints: what its robots' links come to, see models.h */
    ARRAY(int32_t) bodies;      /* the count of this one counts for all */
    ARRAY(double) positions, orientations, linear, angular;
    ARRAY(uint8_t) teleports;
    bool any_teleport;
} expanded_poses;

#endif
