/* geometry_state: geometries by their content. */
#ifndef COLLIDED_SERVICE_GEOMETRY_STATE_H
#define COLLIDED_SERVICE_GEOMETRY_STATE_H

#include "builds.h"
#include "wire/wire_lcm.h"

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
    mesh *mesh;                /* ... or this one, ... */
    soft_mesh *soft;           /* ... or this one, by its kind */
    uint32_t users;            /* bodies that hold it */
} geometry;

typedef struct reported_build { /* to a replay, or a standby: what the daemon that decides did in this tick */
    int64_t client, hash;
    bool ready; /* or put off */
} reported_build;

#endif
