/* incoming: bytes that claim to be a message of a client, on their way to the sink. The tick thread. */
#ifndef COLLIDED_LINK_INCOMING_H
#define COLLIDED_LINK_INCOMING_H

#include "link.h"
#include "wire/wire_lcm.h"

/* What a decoded message still has to be: one that clients send. The daemon's own kinds would otherwise come back to it
 * as commands. WIRE_OK, or WIRE_MALFORMED with the text in *refusal. */
wire_reason incoming_check_kind(wire_kind kind, wire_refusal *refusal);

typedef struct incoming_part {
    uint32_t done; /* so many of its poses have been handed over; in and out */
    bool whole;    /* out: nothing of it is left */
    uint64_t work; /* out: see link_sink.room */
} incoming_part;

/* Decodes LCM's encoding and hands the message, or its refusal, to the sink; of a batch of poses no more than there is
 * room for. True if it was a message. */
bool incoming_some(
    struct link *from, const link_sink *sink, wire_memory *memory, const void *data, size_t size, incoming_part *part);

#endif
