/* link_open: finds the transport of a URI, opens and closes it. The tick thread. */
#ifndef COLLIDED_LINK_LINK_OPEN_H
#define COLLIDED_LINK_LINK_OPEN_H

#include "link.h"

/* EX_OK and the link's key, or another status of sysexits.h with one line in `why`. Nothing is opened; `wake_fd` and
 * `counters` are not used. */
int link_check(const char *uri, const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size);
bool link_announces(const char *uri); /* see link_ops.announces */

/* The link for a URI, opened; what `options` points to is copied. NULL with the reason in `why`.
 *   dds://DOMAIN                              DOMAIN 0 to 230; "dds://" = 0
 *   lcm://udpm://239.255.76.67:7667?ttl=0     by the process collided-lcm; "lcm://" = LCM's default, ttl 0
 *   memory://NAME                             in this process: link_memory.h
 *   replay:///path/to/file.lcmlog             a recorded command log: link_replay.h */
struct link *link_open(const char *uri, const link_options *options, char *why, size_t why_size);
void link_close(struct link *l); /* flushes, then frees */

#endif
