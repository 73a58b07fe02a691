/* link: a batch of poses that is handed over in parts. The tick thread. */
#include "link.h"

static void cut_out(wire_pose_batch *p, uint32_t from, uint32_t count)
{
    p->bodies = (wire_i32s){count, p->bodies.at + from};
    p->positions = (wire_f64s){3 * count, p->positions.at + 3 * (size_t)from};
    p->orientations = (wire_f64s){4 * count, p->orientations.at + 4 * (size_t)from};
    if (p->linear.count) p->linear = (wire_f64s){3 * count, p->linear.at + 3 * (size_t)from};
    if (p->angular.count) p->angular = (wire_f64s){3 * count, p->angular.at + 3 * (size_t)from};
    if (p->teleports.count) p->teleports = (wire_u8s){count, p->teleports.at + from};
}

void link_cut_poses(wire_pose_batch *rest, uint32_t count, wire_pose_batch *part)
{
    *part = *rest;
    part->step = 0;
    part->extensions = (wire_u8s){0, NULL}; /* joints, likewise with the last one */
    cut_out(part, 0, count);
    cut_out(rest, count, rest->bodies.count - count);
}

size_t link_room_for(const link_sink *sink, const wire_message *m, uint64_t *work)
{
    *work = 0;
    if (m->kind != WIRE_POSE_BATCH || !sink->room) return SIZE_MAX;
    size_t room = sink->room(sink->context, &m->pose_batch, work);
    return room < m->pose_batch.bodies.count ? room : SIZE_MAX;
}
