/* tick: one tick of the service: the same for live links and for a replay. Tick thread. */
#include "service.h"

/* Queries wait in the inbox like commands, and are answered from the world as the tick leaves it. */
void service_tick(service *s)
{
    world_batches batches;
    inbox_apply(s);
    world_tick(s->world, s->now_ns, &batches);
    s->events_hash = batches.hash;
    stream_publish(s, &batches);
    session_send_acks(s);
    inbox_answer(s);
    record_tick(s);
    geometry_sweep(s);
    s->latest_pose_ns = s->latest_step = 0;
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
}
