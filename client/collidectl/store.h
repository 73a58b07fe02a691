/* store: what earlier runs of collidectl created under one --as: body numbers by name, and where robots came from, so
 * that a later run can go on with them. It is a memory, not the truth: whether a body still exists is known to the
 * daemon alone. */
#ifndef COLLIDED_COLLIDECTL_STORE_H
#define COLLIDED_COLLIDECTL_STORE_H

#include "ctl.h"
#include "loaders/robot.h"

#include <stdint.h>

typedef struct store_body {
    const char *name;
    int32_t id;
} store_body;

typedef struct store_robot {
    const char *name;                 /* prefix + the URDF's name */
    const char *urdf, *srdf, *prefix; /* whole paths; "" = none */
    load_package packages[PACKAGES_MAX];
    size_t package_count;
    collided_pose base;
    const char **joints; /* names and last values of all joints */
    double *values;
    size_t joint_count;
} store_robot;

typedef struct store {
    pool *pool;
    char *path;
    int lock; /* file descriptor; -1 = none */
    int32_t next_id;
    store_body *bodies;
    size_t body_count, body_room;
    store_robot *robots;
    size_t robot_count, robot_room;
} store;

/* Room for one more than `count` items: the same, or a larger copy. */
void *store_grow(pool *p, void *items, size_t count, size_t *room, size_t size);

int32_t store_find(const store *s, const char *name);                  /* -1 = none */
int32_t store_id_for(const store *s, const char *name, int32_t *next); /* known, or *next, which then grows */
void store_put(store *s, const char *name, int32_t id);
store_robot *store_find_robot(const store *s, const char *name); /* NULL = none */
/* The URDF at `source` as a robot, replacing one of the same name; paths are made whole. */
void store_put_robot(store *s, const robot *r, collided_pose base, const double *values);
/* The joint values of `r`, which was loaded from what `to` says. */
void store_set_values(store *s, store_robot *to, const robot *r, const double *values);

#endif
