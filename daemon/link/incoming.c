/* incoming: the one way by which encoded bytes, from whatever pipe or queue, become messages. The tick thread. */
#include "incoming.h"

#include <stdio.h>

wire_reason incoming_check_kind(wire_kind kind, wire_refusal *refusal)
{
    if (kind >= WIRE_CLIENT && kind <= WIRE_RECEIPT) return WIRE_OK;
    refusal->reason = WIRE_MALFORMED;
    snprintf(refusal->text, sizeof refusal->text, "%s: clients do not send this", wire_kind_name(kind));
    return WIRE_MALFORMED;
}

bool incoming_bytes(struct link *from, const link_sink *sink, wire_memory *memory, const void *data, size_t size)
{
    wire_message m = {0};
    wire_refusal refusal = {0};
    wire_memory_reset(memory);
    wire_reason reason = wire_lcm_decode(data, size, memory, &m, &refusal);
    if (reason == WIRE_OK) reason = incoming_check_kind(m.kind, &refusal);
    if (reason == WIRE_OK) {
        sink->message(sink->context, from, &m);
        return true;
    }
    int64_t client, sequence;
    int32_t object;
    wire_origin(&m, &client, &sequence, &object);
    sink->refused(sink->context, from, wire_lcm_kind(data, size), client, sequence, &refusal);
    return false;
}
