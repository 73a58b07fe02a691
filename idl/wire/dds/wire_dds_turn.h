/* wire_dds_turn: where a daemon on loopback gives out turns. Whoever comes makes the daemon and itself exchange some
 * hundred packets; when hundreds come at once, none of them gets a processor for long enough to finish, and what two
 * ask for at a time is sent to all. So the clients of the library ask for a turn before they join the domain, on a Unix
 * socket of the abstract namespace (as loopback, it belongs to the network namespace): they connect, wait for one byte,
 * join, and hang up when they have found the daemon's ends. Where nobody listens, or who listens is not to be believed,
 * they join at once; so does whoever is not of the library. Any thread.
 *
 * The daemon greets whoever connects with three bytes: WAIT or FULL; whether it is one of a crowd, 1 or 0; and the room
 * that it is to join (wire_dds_qos.h), 0: none. A client that looks for its daemon again connects, says KNOCK and the
 * number of its room, and hangs up: a daemon that has been started anew opens that room. */
#ifndef COLLIDED_WIRE_DDS_TURN_H
#define COLLIDED_WIRE_DDS_TURN_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>

enum {
    WIRE_DDS_TURN_WAIT = 'w',  /* at the beginning: it is heard, and will have its turn */
    WIRE_DDS_TURN_FULL = 'f',  /* or: too many wait, it may ask again */
    WIRE_DDS_TURN_COME = 'c',  /* it may join */
    WIRE_DDS_TURN_KNOCK = 'k', /* from a client: */
    WIRE_DDS_TURN_GREETING = 3 /* bytes */
};

/* So many that are there or wait are a crowd: whoever joins it has patience (WIRE_DDS_CLIENT_OF_CROWD). */
enum { WIRE_DDS_CROWD = 64 };

static inline socklen_t wire_dds_turn_address(uint32_t domain, struct sockaddr_un *out)
{
    *out = (struct sockaddr_un){.sun_family = AF_UNIX};
    int n = snprintf(out->sun_path + 1, sizeof out->sun_path - 1, "collided/turns/%u", (unsigned)domain);
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)n);
}

#endif
