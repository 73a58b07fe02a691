/* link_replay: a recorded command log as a link: the same commands, tick by tick, through the same sink. The events
 * that stand beside them are no commands: they are kept for a comparison.
 *
 * "replay:///path/to/file.lcmlog". link_receive hands over the commands of exactly one recorded tick; link_replay_tick
 * then tells that tick's number, clock and hash, so that the service runs it as it ran live. What it publishes goes
 * to link_replay_listen's listener, if there is one. */
#ifndef COLLIDED_LINK_REPLAY_H
#define COLLIDED_LINK_REPLAY_H

#include "link.h"
#include "wire/wire_log.h"

extern const link_ops link_replay_ops;

/* After link_receive: true and the tick that ended, or false: the log has ended (or is damaged: then `why` is not "").
 */
bool link_replay_tick(struct link *l, wire_log_tick *out, char *why, size_t why_size);

/* What the recording has of the events of that tick: EventBatch messages in LCM's encoding, each behind its size, a
 * size_t. Empty where none were recorded. Until the next link_receive. */
typedef struct link_replay_reported {
    const uint8_t *bytes;
    size_t size;
} link_replay_reported;
link_replay_reported link_replay_events(struct link *l);

/* Who hears what the daemon publishes; nobody at first. */
typedef void (*link_replay_listener)(void *context, const wire_message *m);
void link_replay_listen(struct link *l, link_replay_listener listener, void *context);

#endif
