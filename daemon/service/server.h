/* server: the life of the daemon between its start and its end: links, world, the loop. */
#ifndef COLLIDED_SERVICE_SERVER_H
#define COLLIDED_SERVICE_SERVER_H

#include "config.h"
#include "link/link.h"

typedef struct server server;

/* NULL with one line in `why`, and nothing half-started. All signals must be blocked already (signals.h). */
server *server_create(const config *c, char *why, size_t why_size);

/* Runs until server_stop, or until a replay has ended. The exit status of the process. */
int server_run(server *s);

/* From any thread: end in order. */
void server_stop(server *s);

/* From any thread: an operator ends the recording, whoever began it. */
void server_end_recording(server *s);

void server_destroy(server *s);

/* For who runs a replay's ticks one by one (replay.h) instead of server_run. */
struct service *server_service(server *s);
struct link_sink server_sink(server *s);

#endif
