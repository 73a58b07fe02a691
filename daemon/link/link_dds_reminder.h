/* link_dds_reminder: what a stream tells a reader that has just come may be lost: Cyclone's readers drop what comes
 * before a writer's first heartbeat of RTPS, and its writers overhear who asks for it at once. On loopback heartbeats
 * are rare (wire_dds_qos.c): so a thread of its own sends two of that writer soon after. Nothing waits for it. */
#ifndef COLLIDED_LINK_LINK_DDS_REMINDER_H
#define COLLIDED_LINK_LINK_DDS_REMINDER_H

#include <dds/dds.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

enum { REMINDER_MOST = 256 /* writers at one time; of others the heartbeats are as rare as ever */ };

typedef struct reminder_entry {
    dds_entity_t writer;
    int64_t at_ns; /* monotonic */
    bool again;    /* this is the first one */
} reminder_entry;

typedef struct reminder {
    pthread_t thread;
    pthread_mutex_t lock; /* guards what follows */
    pthread_cond_t wake, reminded;
    reminder_entry at[REMINDER_MOST];
    unsigned count;
    dds_entity_t reminds; /* it is at this one just now; 0: at none */
    bool runs, ends;
} reminder;

void reminder_start(reminder *r);
/* A writer that was just written to; before _start and after _end nothing. */
void reminder_put(reminder *r, dds_entity_t writer);
/* Before a writer is deleted, and after its last _put. Waits while it is reminded of: some microseconds. */
void reminder_forget(reminder *r, dds_entity_t writer);
void reminder_end(reminder *r);

#endif
