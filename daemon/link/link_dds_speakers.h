/* link_dds_speakers: which DDS participant speaks for which client. Writers are known from discovery, their
 * participants' deaths from liveliness; owners.h decides. speakers_heartbeat may be called by any thread, all else by
 * the tick thread. */
#ifndef COLLIDED_LINK_LINK_DDS_SPEAKERS_H
#define COLLIDED_LINK_LINK_DDS_SPEAKERS_H

#include "owners.h"
#include "wire/wire.h"

#include <dds/dds.h>
#include <pthread.h>

typedef struct heartbeat { /* what has become of a writer's liveliness */
    dds_instance_handle_t writer;
    bool alive;
} heartbeat;

/* One participant of the daemon hears of writers by a reader of its own, which goes with it. */
typedef struct speakers_ear {
    dds_entity_t discovery;
    unsigned room; /* of that participant; 0: it is that of the link */
} speakers_ear;

typedef struct speakers {
    owners owners;
    ARRAY(dds_instance_handle_t) gone; /* writers: what they wrote may still lie unread */
    pthread_mutex_t lock;
    ARRAY(heartbeat) news; /* under lock */
} speakers;

void speakers_init(speakers *s, size_t max_clients, size_t each); /* 0: any number; all of them */
/* To be opened before any reader of messages: whoever these match has been discovered. False: DDS refuses. */
bool speakers_open(speakers_ear *ear, dds_entity_t participant, unsigned room, const dds_listener_t *listener);
void speakers_free(speakers *s);

void speakers_discover(speakers *s, const speakers_ear *ear);                      /* takes what has come */
void speakers_heartbeat(speakers *s, const dds_liveliness_changed_status_t *news); /* of a writer of Client */

/* May what this writer says under its client's name be taken? False with the reason in `why`. */
/* *unclaimed: it may, and nobody has noted for whom: it may greet and ask, and begin nothing. */
bool speakers_admit(speakers *s, const speakers_ear *ear, const wire_message *m, dds_instance_handle_t writer,
    bool *unclaimed, wire_refusal *why);
int64_t speakers_origin(const speakers *s, dds_instance_handle_t writer); /* its participant; 0: not known */
/* Whose replies go where: the partition of replies, from 1, in which this client reads; 0: the one without a name. */
int speakers_group(const speakers *s, int64_t client);
/* The partition of shared events, from 1, in which this client reads; 0: none. */
int speakers_events_group(const speakers *s, int64_t client);
unsigned speakers_room(const speakers *s, int64_t client); /* that it is in; 0: in none, or nobody speaks for it */
uint64_t speakers_participant(const speakers *s, int64_t client); /* that speaks for it; 0: nobody */
void speakers_release(speakers *s, int64_t client);               /* it has left in order */

/* When all messages have been read. The next client whose participant is lost; false: no more. */
bool speakers_lost(speakers *s, int64_t *client);

#endif
