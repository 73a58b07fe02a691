/* link_dds_peers: the two topics of peer.h over DDS: collided_Peer keeps each daemon's announcement for whoever comes
 * later, and its writer's liveliness is the daemon's; collided_Journal carries records in pieces. Both are read by
 * daemons alone. Listeners only note and call `wake`; all else is the tick thread's. */
#ifndef COLLIDED_LINK_LINK_DDS_PEERS_H
#define COLLIDED_LINK_LINK_DDS_PEERS_H

#include "base/array.h"
#include "peer.h"

#include <dds/dds.h>
#include <pthread.h>

typedef struct dds_peer {
    dds_instance_handle_t writer; /* of its announcement */
    peer_announcement announcement;
    int64_t next_number;      /* of its records; 0: none has come */
    bool broken;              /* a piece was lost: the rest of that record is no use */
    ARRAY(uint8_t) assembled; /* pieces of a record that is not whole */
} dds_peer;

typedef struct dds_peer_news {
    dds_instance_handle_t writer;
    bool alive;
} dds_peer_news;

typedef struct dds_peers {
    dds_entity_t participant; /* the link's; 0: nobody has joined */
    dds_entity_t announcements_out, announcements_in, journal_out, journal_in;
    int64_t number; /* of the last piece sent */
    void (*wake)(void *context);
    void *context;
    pthread_mutex_t lock;
    ARRAY(dds_peer_news) news;    /* under lock */
    ARRAY(dds_peer_news) writers; /* of announcements: the last news of each */
    ARRAY(dds_peer) peers;
} dds_peers;

void dds_peers_init(dds_peers *p, void (*wake)(void *context), void *context);
bool dds_peers_join(dds_peers *p, dds_entity_t participant, int64_t lease_ns);
void dds_peers_free(dds_peers *p); /* the entities go with their participant */

void dds_peers_say(dds_peers *p, const peer_announcement *announcement);
bool dds_peers_send(dds_peers *p, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size);
void dds_peers_receive(dds_peers *p, const peer_sink *sink);

#endif
