/* turn: the client's end of wire_dds_turn.h. Any thread. */
#ifndef COLLIDED_CLIENT_TURN_H
#define COLLIDED_CLIENT_TURN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { TURN_NOBODY = -1, TURN_NONE = -2 };

/* What the daemon says to whoever asks. */
typedef struct turn_greeting {
    bool crowd;    /* many ask, or are there */
    unsigned room; /* to join; 0: none */
} turn_greeting;

/* Asks for a turn to join that domain on loopback, again and again as long as too many wait, until the monotonic clock
 * shows `until_ns`. A descriptor, for turn_wait; TURN_NOBODY: nobody gives turns; TURN_NONE: the time is over, with the
 * reason in `why`. */
int turn_ask(uint32_t domain, int64_t until_ns, turn_greeting *greeting, char *why, size_t why_size);
/* Waits for it. The descriptor, to be closed when the daemon knows us; otherwise, when it is closed, as turn_ask. */
int turn_wait(int asked, int64_t until_ns, char *why, size_t why_size);
/* Tells a daemon of that domain that we are in that room, and look for it. Waits for nothing. */
void turn_knock(uint32_t domain, unsigned room);

#endif
