/* turn: the client's end of wire_dds_turn.h. Any thread. */
#ifndef COLLIDED_CLIENT_TURN_H
#define COLLIDED_CLIENT_TURN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { TURN_NOBODY = -1, TURN_FULL = -2, TURN_NONE = -3 };

/* Asks for a turn to join that domain on loopback: what turn_wait goes on with, a descriptor, TURN_FULL, or TURN_NOBODY
 * gives turns. *crowd: many do so, or are there. */
int turn_ask(uint32_t domain, int64_t until_ns, bool *crowd);
/* Waits for it, until the monotonic clock shows `until_ns`. The descriptor to be closed when the daemon knows us;
 * TURN_NOBODY: nobody gives turns any more; TURN_NONE: ours did not come, with the reason in `why`. */
int turn_wait(uint32_t domain, int asked, int64_t until_ns, char *why, size_t why_size);

#endif
