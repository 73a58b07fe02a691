/* daemon: a tiny counterpart of the client over real transports: it acknowledges, counts poses, answers queries and
 * opens each stream with a snapshot. One thread. */
#ifndef COLLIDED_TESTS_CLIENT_DAEMON_H
#define COLLIDED_TESTS_CLIENT_DAEMON_H

#include "wire/wire.h"

#include <stdatomic.h>
#include <stdbool.h>

typedef struct daemon_state {
    atomic_bool stop;
    atomic_int clients, bodies, removed, poses, queries, subscriptions, malformed, clients_left;
    _Atomic double last_x;
} daemon_state;

/* The transport's side: a thread function. */
void *daemon_dds(void *state);
void *daemon_lcm(void *state);

typedef void daemon_send(void *context, const wire_message *m);
void daemon_react(daemon_state *d, const wire_message *m, daemon_send *send, void *context);
wire_message daemon_status(void);

/* A network namespace of this process' own, with loopback and multicast on it. False, with the reason on stdout, where
 * that is not permitted. Before any thread is started. */
bool namespace_enter(void);

#endif
