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
    pthread_cond_t wake;
    reminder_entry at[REMINDER_MOST];
    unsigned count;
    bool runs, ends;
} reminder;

void reminder_start(reminder *r);
void reminder_put(
    reminder *r, dds_entity_t writer); /* that was just written to; before _start and after _end nothing */
void reminder_end(reminder *r);

#endif
