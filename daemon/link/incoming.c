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

/* What is done of it is done. */
static void hand_over_part(struct link *from, const link_sink *sink, wire_message *m, incoming_part *part)
{
    wire_message some = *m;
    bool poses = m->kind == WIRE_POSE_BATCH;
    if (poses && part->done) link_cut_poses(&m->pose_batch, part->done, &some.pose_batch);
    size_t room = poses ? link_room_for(sink, m, &part->work) : SIZE_MAX;
    part->whole = room == SIZE_MAX;
    if (!part->whole) {
        link_cut_poses(&m->pose_batch, (uint32_t)room, &some.pose_batch);
        part->done += (uint32_t)room;
    }
    from->in_parts = !part->whole;
    sink->message(sink->context, from, part->whole ? m : &some);
    from->in_parts = false;
}

bool incoming_some(
    struct link *from, const link_sink *sink, wire_memory *memory, const void *data, size_t size, incoming_part *part)
{
    wire_message m = {0};
    wire_refusal refusal = {0};
    wire_memory_reset(memory);
    wire_reason reason = wire_lcm_decode(data, size, memory, &m, &refusal);
    if (reason == WIRE_OK) reason = incoming_check_kind(m.kind, &refusal);
    part->work = 0;
    if (reason == WIRE_OK) {
        hand_over_part(from, sink, &m, part);
        return true;
    }
    int64_t client, sequence;
    int32_t object;
    wire_origin(&m, &client, &sequence, &object);
    part->whole = true;
    sink->refused(sink->context, from, wire_lcm_kind(data, size), client, sequence, &refusal);
    return false;
}
