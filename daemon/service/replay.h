/* replay: a recording instead of live links: the same ticks with the same clock, each held against the hash, and the
 * events, that were recorded. */
#ifndef COLLIDED_SERVICE_REPLAY_H
#define COLLIDED_SERVICE_REPLAY_H

#include "service.h"

/* At config.replay_speed. Prints ticks, events and hash (a JSON object with config.json), and the first tick that
 * differs: in which event, in which of its fields, with both values, if the events were recorded. Ends early, after a
 * tick, once *stop is set. The exit status: 0, EX_SOFTWARE if a hash or an event differs, EX_DATAERR if the file is
 * damaged. */
int replay_run(service *s, const link_sink *sink, const _Atomic bool *stop);

/* The commands and the clock of one recorded tick, for service_tick; no budget. False: the log has ended (or is
 * damaged: then `why` is not ""). */
bool replay_take(service *s, const link_sink *sink, wire_log_tick *t, char *why, size_t why_size);

#endif
