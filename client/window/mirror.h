/* mirror: the world as the pages of collided-web are shown it: bodies, contacts and the newest events, as the client
 * library tells of them. Each change has a number, so that what a page lacks is found by the number of what it was sent
 * last. One thread. */
#ifndef COLLIDED_WINDOW_MIRROR_H
#define COLLIDED_WINDOW_MIRROR_H

#include "collided.h"

enum { MIRROR_EVENTS = 4096, MIRROR_GONE = 16384, MIRROR_NOBODY = -1 };

typedef struct mirror_body { /* its place is its id for pages; a name keeps it */
    char *name, *group, *owner;
    bool live;
    unsigned flags;
    int64_t client;
    double deadline_s;
    collided_pose pose;
    collided_shape *shapes; /* in the order of the wire: children behind their compound */
    uint32_t *geometries;   /* of each shape: its number; UINT32_MAX = none */
    size_t shape_count;
    uint64_t changed, posed; /* numbers of the last changes */
} mirror_body;

typedef struct mirror_geometry { /* its place is its number */
    int64_t client, hash;
    uint32_t type;      /* of the shapes that have it */
    uint32_t body;      /* one of them */
    uint64_t announced; /* number of the change that brought it */
} mirror_geometry;

typedef struct mirror_contact {
    int64_t id, tick, start_ns;
    double lo, hi, closing, age_a, age_b, lo_s, hi_s;
    double axis[3], point_a[3], point_b[3];
    collided_pose pose_a, pose_b;
    bool has_poses, estimated;
    uint32_t a, b, shape_a, shape_b;
    uint8_t base, kind, achieved; /* base: what it is while it is known */
    uint64_t changed;
} mirror_contact;

typedef struct mirror_event {
    int64_t contact, tick, stamp_ns, start_ns;
    double lo, hi, closing, age_a, age_b, lo_s, hi_s;
    uint32_t a, b, shape_a, shape_b;
    uint8_t kind, cause, achieved, estimated;
    bool snapshot;
} mirror_event;

typedef struct mirror_gone { /* of contacts and bodies */
    uint64_t changed;
    int64_t id;
} mirror_gone;

typedef struct mirror_index mirror_index;

typedef struct mirror {
    uint64_t changes;                       /* the number of the newest change of anything */
    uint64_t scene, poses, contacts_change; /* ... of these */
    uint64_t scene_since, contacts_since;   /* what was sent before these numbers is to be forgotten */
    int64_t epoch, tick, stamp_ns;
    mirror_body *bodies;
    size_t body_count, body_capacity;
    size_t live;
    mirror_geometry *geometries;
    size_t geometry_count, geometry_capacity;
    mirror_contact *contacts;
    size_t contact_count, contact_capacity;
    mirror_event events[MIRROR_EVENTS];                               /* a ring */
    uint64_t event_count;                                             /* of all */
    mirror_gone bodies_gone[MIRROR_GONE], contacts_gone[MIRROR_GONE]; /* rings */
    uint64_t bodies_gone_count, contacts_gone_count;
    int64_t *ids; /* of the daemon's ids: places; MIRROR_NOBODY = none */
    size_t id_capacity;
    mirror_index *names, *by_id, *near, *by_hash;
    uint64_t lost; /* batches that the daemon's streams lost */
} mirror;

mirror *mirror_create(void);
void mirror_destroy(mirror *m);

/* Callbacks of the client library; the context is the mirror. */
void mirror_scene(void *context, const collided_scene *scene);
void mirror_batch(void *context, const collided_batch *batch);

void mirror_forget_contacts(mirror *m); /* nobody is told of them any more */
void mirror_forget(mirror *m);          /* another daemon, or none: all but the names' places */

int64_t mirror_find(const mirror *m, const char *name); /* its place; MIRROR_NOBODY */

#endif
