/* turn: the client's end of wire_dds_turn.h. Any thread. */
#ifndef COLLIDED_CLIENT_TURN_H
#define COLLIDED_CLIENT_TURN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Waits for a turn to join that domain on loopback, until the monotonic clock shows `until_ns`. The descriptor to be
 * closed when the daemon knows us; -1: nobody gives turns; -2: it did not come, with the reason in `why`. */
int turn_wait(uint32_t domain, int64_t until_ns, char *why, size_t why_size);

#endif
