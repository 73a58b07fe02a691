/* link_pipe: one client at the other end of two socket pairs that this process was started with: an observer of a
 * replay (service/replay_served.h). "pipe://A,B": on descriptor A come the client's messages, and go acknowledgements,
 * refusals and Status; on B go batches of events and answers. Frames are those of gateway/pipe. What is published waits
 * here until the sockets take it, all of it: who serves looks at link_pipe_waiting before he lets more be published. */
#ifndef COLLIDED_LINK_PIPE_H
#define COLLIDED_LINK_PIPE_H

#include "link.h"

#include <poll.h>

extern const link_ops link_pipe_ops;

enum { LINK_PIPE_FDS = 2 };

/* What to wait for, in fds[LINK_PIPE_FDS]; bytes that wait; has the client closed its end? */
void link_pipe_poll(const struct link *l, struct pollfd *fds);
size_t link_pipe_waiting(const struct link *l);
bool link_pipe_is_gone(const struct link *l);

#endif
