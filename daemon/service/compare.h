/* compare: what a tick reported against what a recording has of it: the first event, or the first field of a batch,
 * that differs, with both values. Main thread, in a replay. */
#ifndef COLLIDED_SERVICE_COMPARE_H
#define COLLIDED_SERVICE_COMPARE_H

#include "link/link_replay.h"
#include "service.h"

enum { COMPARE_FIELDS_MAX = 16, COMPARE_VALUE_MAX = 160 };

typedef struct compared_field {
    char name[48]; /* as on the wire, with the index where there are several: "axes[2]" */
    char recorded[COMPARE_VALUE_MAX], replayed[COMPARE_VALUE_MAX];
} compared_field;

typedef struct difference {
    char stream[WIRE_NAME_MAX + 1]; /* "": there is none to name */
    int64_t event;                  /* of its events in this tick, from 0; -1: the batch itself */
    char recorded[COMPARE_VALUE_MAX + 2 * WIRE_NAME_MAX],
        replayed[COMPARE_VALUE_MAX + 2 * WIRE_NAME_MAX]; /* in words */
    compared_field fields[COMPARE_FIELDS_MAX];
    size_t field_count, more; /* more: fields that differ, too, and are not told */
} difference;

/* After world_tick, before anything of it is published. False: it is what was recorded, bit for bit. */
bool compare_batches(service *s, link_replay_reported reported, const world_batches *batches, difference *out);

#endif
