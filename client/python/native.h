/* native: what the Python package adds to collided.h, in C. Batches are copied here as they come, without Python, so
 * that no Python code runs inside collided_poll: an exception or Ctrl-C cannot get lost there. cffi reads this file,
 * too. */
#ifndef COLLIDED_PYTHON_NATIVE_H
#define COLLIDED_PYTHON_NATIVE_H

#include "collided.h"

/* One event, in one piece, without pointers: a row of the numpy array `Batch.events`. */
typedef struct native_event {
    int64_t contact;
    double lo, hi;
    double axis[3], point_a[3], point_b[3];
    double age_a_s, age_b_s, closing_m_s;
    int32_t kind, achieved;
    int32_t a, b; /* of Batch.names */
    int32_t shape_a, shape_b;
    int32_t first_point, points; /* of Batch.points */
    int32_t impact;              /* of Batch.impacts; -1 = none */
    char cause[16];
    int32_t reserved;
} native_event;

/* As collided_impact, with poses as arrays. */
typedef struct native_impact {
    double lo_s, hi_s;
    int64_t start_ns;
    double position_a[3], wxyz_a[4], position_b[3], wxyz_b[4];
    bool estimated;
    uint8_t reserved[7];
} native_impact;

/* A batch that has come, and all of it: one allocation, freed by native_free. */
typedef struct native_batch {
    struct native_batch *next;
    collided_batch head; /* its pointers are not valid */
    char refusal[32];
    native_event *events;
    size_t event_count;
    collided_contact_point *points;
    size_t point_count;
    native_impact *impacts;
    size_t impact_count;
    char *names; /* each distinct name of the batch once, ended by '\0' */
    size_t names_size;
} native_batch;

typedef struct native_rejection {
    char message[24], reason[24], text[640];
    int32_t object;
} native_rejection;

typedef struct native_inbox native_inbox;

/* An inbox of a client, to be freed after collided_close. NULL: no memory. */
native_inbox *native_open(collided *c);
void native_close(native_inbox *inbox);
/* collided_subscribe, of which the inbox receives the batches. */
collided_subscription native_subscribe(native_inbox *inbox, collided *c, const collided_subscription_def *def);
/* The next batch that has come, which is the caller's; NULL = none. */
native_batch *native_take(native_inbox *inbox);
void native_free(native_batch *batch);
/* The next refusal that has come; false = none. Of more than 256 that nobody takes the later ones are counted. */
bool native_take_rejection(native_inbox *inbox, native_rejection *out);
/* Refusals that there was no room for, since this was asked last. */
size_t native_dropped(native_inbox *inbox);
/* Batches that there was no memory for, since this was asked last: what is known of the world has gaps. */
size_t native_lost(native_inbox *inbox);
/* A copy of quaternions (x, y, z, w) as (w, x, y, z). */
void native_wxyz(double *out, const double *xyzw, size_t count);

#endif
