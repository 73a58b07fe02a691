/* raw_ping: what DDS alone takes for the same payload: a PoseBatch out and an EventBatch back, written and received in
 * listeners, with the quality of service and the configuration of the daemon and the client library. Two processes. */
#ifndef COLLIDED_TESTS_BENCH_RAW_PING_H
#define COLLIDED_TESTS_BENCH_RAW_PING_H

#include <stdint.h>

/* The other process: answers every PoseBatch by an EventBatch without events (so the floor is not too high), until it
 * is ended. Non-zero if DDS fails. */
int raw_echo(uint32_t domain);

typedef struct raw_ping raw_ping;
raw_ping *raw_open(uint32_t domain, uint32_t poses); /* NULL, told on stderr, if no echo is there within ten seconds */
int64_t raw_round_ns(raw_ping *r, int64_t timeout_ns); /* -1 = no answer in time */
/* Batches written as fast as they are taken in that time, in groups of `every` of which the last is answered: what a
 * subscriber that does nothing with them takes. -1 = a write failed or no answer came. */
int64_t raw_flood(raw_ping *r, double seconds, unsigned every);
void raw_close(raw_ping *r);

#endif
