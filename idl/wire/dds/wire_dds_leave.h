/* wire_dds_leave: the end of a participant and its domain, in bounded time, for everybody who made one. Any thread. */
#ifndef COLLIDED_WIRE_DDS_LEAVE_H
#define COLLIDED_WIRE_DDS_LEAVE_H

#include <stdbool.h>
#include <stdint.h>

enum { WIRE_DDS_LEAVE_S = 2 };

/* What wire_dds_leave did not do, in words for whoever runs the program. */
#define WIRE_DDS_LEFT_BEHIND                                                                                           \
    "DDS does not end: a firewall drops what this machine sends to itself (see: collidectl doctor); its domain is "    \
    "left behind until this process ends"

/* Deletes a domain without participants (a dds_entity_t; not positive: none). Cyclone 0.10.2 ends its receiving threads
 * by a datagram to itself, and waits for them; behind a firewall that drops it, it would wait for ever. False: it still
 * waits, after WIRE_DDS_LEAVE_S, in a thread of its own; nothing of the caller's is touched any more, but this domain
 * must not be opened again, because dds_create_domain would wait for it. */
bool wire_dds_leave(int32_t domain);

#endif
