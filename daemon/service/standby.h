/* standby: one of a pair of daemons. The active one hands each tick to the other before anybody is told of it: the
 * commands in the order in which it applied them, its clock, the hash of its events (journal.h). The standby carries
 * them out like a replay, so that its world, ids and batch numbers are the same, and publishes nothing. When the active
 * one's liveliness is lost, or it leaves, the standby goes on:
 *
 *   - under an epoch one higher, of the same line (wire.h: wire_same_line). Readers of the higher one believe nothing
 *     any more that comes under the lower one, so that a daemon that was only stopped cannot be heard twice; it hears
 *     of its successor, says so, and becomes the standby;
 *   - it publishes once more the batches of the last lease, which readers know by their numbers if they have them, and
 *     tells by a heartbeat the number of the last one: who was told more, or lost some, asks for a snapshot;
 *   - what clients had sent and the journal had not told yet is kept from its own links, and is applied now.
 *
 * The active one that hears nothing of its standby goes on alone only after a time in which that one would have taken
 * over if it could; and a standby that stood still for so long asks first whether it is waited for at all. Otherwise
 * both would tell different things under the same numbers.
 *
 * Functions take the service; without a pair (standby = no) they do nothing, and say that this daemon is active. Tick
 * thread. */
#ifndef COLLIDED_SERVICE_STANDBY_H
#define COLLIDED_SERVICE_STANDBY_H

#include "service.h"

/* After the links are open: looks for the other one, and says nothing to clients until it knows its own part. 0, or -1
 * with the reason: no link carries pairs. */
int standby_start(service *s, char *why, size_t why_size);
void standby_free(service *s); /* before the links are closed */

/* Each round, after the links have been taken from. True: this daemon is not the active one, and has no ticks. */
bool standby_round(service *s, const link_sink *sink);
bool standby_waits(const service *s);      /* the same, without doing anything */
int64_t standby_next_ns(const service *s); /* monotonic: when the next round is due, at the latest */

/* The active one: a tick is wanted although nothing has come, for a standby that asks for the state. */
bool standby_wants_tick(const service *s);
void standby_after_tick(service *s);

/* What came by a link. True: it is kept, or left to the active one, and nothing else is to be done. */
bool standby_takes(service *s, struct link *from, const wire_message *m);
bool standby_takes_lost(service *s, struct link *from, int64_t client);
bool standby_takes_reader(service *s, struct link *from, const char *stream);

/* The active one: will the links tell when that client is lost? If not, it has to be heard within its lease. */
bool standby_hears(const service *s, int64_t client);

/* A reader was told that batch of the stream under that epoch. True: by one that we took over from, which told it after
 * we had lost it. All streams begin anew, under a new line: ours goes on from something else. */
bool standby_was_outrun(service *s, const stream *to, int64_t epoch, int64_t batch);

/* The active one's journal; the tick before its events are published. */
void standby_journal_message(service *s, const struct link *from, const wire_message *m);
void standby_journal_lost(service *s, const struct link *from, int64_t client);
void standby_journal_reader(service *s, const struct link *from, const char *stream);
void standby_journal_build(service *s, int64_t client, int64_t hash, bool ready);
void standby_journal_tick(service *s);

/* The daemon is to end: true if a standby that is in step takes over, and nobody need be told of an end. */
bool standby_hands_over(service *s);

/* For people, in Status: "; active, hot standby: HOST:PID". "" without a pair. */
void standby_describe(const service *s, char *text, size_t size);

#endif
