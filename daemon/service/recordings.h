/* recordings: recordings, and the state with which one begins, or a standby. Tick thread. */
#ifndef COLLIDED_SERVICE_RECORDINGS_H
#define COLLIDED_SERVICE_RECORDINGS_H

#include "service.h"
#include "state_parts.h"

/* standby_state.c: the whole state between two ticks, for a standby, and for a recording that begins in the middle */
void state_put(service *s, state_parts *all);
size_t state_size(const service *s); /* about as many bytes as that will be, but for the numbers of geometries */
/* Of this release and build? If not, it says of which. */
bool state_fits(const uint8_t *bytes, size_t size, char *why, size_t why_size);
bool state_take(service *s, bytes_in *from, char *why, size_t why_size); /* into an empty service */

/* record.c, record_state.c */
size_t record_state_size(const service *s); /* about as many bytes as record_state takes */
/* All that is announced now, as if it came anew: begins with it, and goes on for so long (ns), but tells something at
 * least. True when all has been told; what clients say meanwhile is recorded beside it. */
void record_state_begin(service *s);
bool record_state_more(service *s, int64_t most_ns);
void record_state_end(service *s); /* whatever is left */
/* The state follows with the tick's end. `client`: who asked for it, or NULL: the configuration. */
int record_start(service *s, const char *path, const int64_t *client, char *why, size_t why_size);
/* May a query of that client end it? If not, it says who may. */
bool record_may_end(const service *s, int64_t client, char *why, size_t why_size);
void record_watch(service *s); /* notices recordings that end of themselves, and that are on the disk; each round */
bool record_wants_tick(const service *s); /* it is about to begin */
int64_t record_next_ns(const service *s); /* when to do so again, monotonic; INT64_MAX: with anything else */
void record_stop_now(service *s);         /* of a daemon that ends: waits for the disk */
/* As configured, of a daemon of a pair that becomes active: FILE, or FILE.1, FILE.2, ... if it is there. */
void record_begin(service *s);
void record_message(service *s, const wire_message *m);
void record_events(service *s, const world_batches *batches); /* before they are published */
void record_tick(service *s);
void record_lost(service *s, int64_t client);
void record_build(service *s, int64_t client, int64_t hash, bool ready);
void record_steps(service *s); /* how far lock-step is, if it has begun */
void record_stop(service *s);

#endif
