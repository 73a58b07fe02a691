/* observe: what comes of scenes, and of poses with events; see observe.c. The caller's thread. */
#ifndef COLLIDED_CLIENT_OBSERVE_H
#define COLLIDED_CLIENT_OBSERVE_H

#include "session.h"
#include "wire/wire_extensions.h"

void observe_deliver(collided *c, subscription_record *i, const wire_event_batch *b);
const collided_pose *observe_event_poses(collided *c, const wire_message *const *parts, size_t part_count);

/* queries.c: asks, and hands over the answer itself, to be freed; NULL unless COLLIDED_OK is returned. */
collided_status query_answer(collided *c, wire_query query, double timeout_s, wire_message **answer);

#endif
