/* announcement: one thing that a client has announced, as the record of announce.h keeps it. */
#ifndef COLLIDED_CLIENT_ANNOUNCEMENT_H
#define COLLIDED_CLIENT_ANNOUNCEMENT_H

#include "wire/wire.h"

typedef enum announce_state { ANNOUNCE_PENDING, ANNOUNCE_ACKED, ANNOUNCE_REFUSED } announce_state;

typedef struct announcement {
    wire_message *message; /* owned; NULL: known to the daemon, but never announced by this process */
    announce_state state;
    bool renew;       /* the next sending is a new announcement: new sequence, newest pose */
    bool leaves_name; /* of a body or subscription: the daemon may know it by a name or stream that it no longer has */
    unsigned tries;   /* sendings since it became pending */
    int64_t due_ns;   /* pending: when it is sent (again), by the monotonic clock */
    int64_t renewed_ns; /* when it was last announced anew after an answer that asked for it */
    struct announcement *next, *previous;
} announcement; /* the first member of each record; all zero = empty */

#endif
