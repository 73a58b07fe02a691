/* announce: the record of everything that this client has announced (itself, geometries, bodies, subscriptions), in the
 * order of its creation, until the daemon has acknowledged its removal. All functions: with the client's mutex held. */
#ifndef COLLIDED_CLIENT_ANNOUNCE_H
#define COLLIDED_CLIENT_ANNOUNCE_H

#include "session.h"

enum {
    ANNOUNCE_FIRST_REPEAT_MS = 50,  /* doubled with each repetition ... */
    ANNOUNCE_FIRST_DOUBT_MS = 100,  /* the same where the transport keeps what was sent: only an answer can be lost */
    ANNOUNCE_LAST_REPEAT_MS = 1000, /* ... up to this */
    ANNOUNCE_BURST_BYTES = 1 << 18, /* repeated at once at most: a sixteenth of the receivers' buffers */
    ANNOUNCE_ORDER_TRIES = 20       /* answers like "unknown client" taken as a matter of order */
};

/* Announces `message` (ownership passes) as the newest word on the record, and sends it. */
void announce(collided *c, announcement *a, wire_message *message);
/* Said before it: a body's name, or a subscription's stream, goes with this message. Until that is settled, and a
 * second longer, the answer that a name is taken, or a limit reached, is a matter of order. */
void announce_leaves_name(collided *c, announcement *a);
void announce_again(collided *c, announcement *a); /* with a new sequence, at once */
void announce_all_again(collided *c);              /* by the library's thread, with new sequences */
void announce_to_new_daemon(collided *c);          /* a new epoch: nothing of ours is acknowledged any more */
void announce_drop(collided *c, announcement *a);  /* out of the record; frees its message, not the record */

/* Sends what is due and returns when the next is (INT64_MAX = nothing is waiting). */
int64_t announce_tend(collided *c, int64_t now_ns);

announcement *announce_find(const collided *c, int64_t sequence);
void announce_acked(collided *c, int64_t sequence);
void announce_rejected(collided *c, const wire_reject *why);

#endif
