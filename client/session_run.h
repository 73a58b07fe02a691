/* session_run: a client's life: opening and closing it, receiving, waiting, and which daemon it follows. */
#ifndef COLLIDED_CLIENT_SESSION_RUN_H
#define COLLIDED_CLIENT_SESSION_RUN_H

#include "session.h"

/* Opens a client over the transport and starts the keeper; waits for the daemon as `def` says. NULL with the reason. */
collided *session_open(
    const transport_ops *ops, const char *address, const collided_def *def, char *why, size_t why_size);

/* With the lock held. */
bool session_hear(collided *c, int64_t epoch);               /* a sign of the daemon; false: of another one than ours */
bool session_hear_status(collided *c, const wire_status *s); /* likewise; it may say that its epoch ends */

/* The caller's thread, without the lock: receives and runs callbacks until `done` (called with the lock held) or the
 * deadline. True if done. */
bool session_wait(collided *c, int64_t deadline_ns, bool (*done)(const collided *c));
/* The same thread: waits until there is something to receive or to do, or for the deadline. Whatever has come since it
 * was last looked for keeps the descriptor readable, so that this may come before the looking. */
void session_sleep(collided *c, int64_t deadline_ns);
bool session_known(const collided *c); /* with the lock held: the daemon has heard and answered who we are */

#endif
