/* peer: how the daemons of a pair (one active, one hot standby) hear of each other and hand over records, over a link
 * that can carry it. Tick thread.
 *
 * Records arrive in order and complete, or not at all: pieces are numbered by the link, and a gap is told. Nothing here
 * blocks; a peer that stands still loses what a bounded history cannot hold. */
#ifndef COLLIDED_LINK_PEER_H
#define COLLIDED_LINK_PEER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct link;

typedef enum peer_role { PEER_JOINING, PEER_STANDBY, PEER_ACTIVE, PEER_LEAVING } peer_role;

typedef struct peer_announcement {
    int64_t sender; /* of its start, ns since the Unix epoch: what tells daemons apart */
    int64_t epoch;  /* of the streams that it publishes or follows; 0: none yet */
    uint8_t role;
    bool alive; /* false: its liveliness is lost, or it has ended */
    char name[128], release[32];
} peer_announcement;

typedef struct peer_sink {
    void *context;
    void (*announcement)(
        void *context, const peer_announcement *announcement); /* it is new, has changed, is lost or is back */
    void (*record)(void *context, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size);
    void (*gap)(void *context, int64_t sender); /* records of it were lost; those that follow come as ever */
} peer_sink;

typedef struct peer_ops {
    /* Others hear of it from now on, and notice within the lease when it is gone. 0, or -1. */
    int (*join)(struct link *l, int64_t lease_ns);
    void (*say)(struct link *l, const peer_announcement *announcement); /* `alive` is of no meaning */
    bool (*send)(struct link *l, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size);
    void (*receive)(struct link *l, const peer_sink *sink); /* all that has come */
} peer_ops;

#endif
