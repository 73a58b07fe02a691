/* shares: how much one participant (DDS), one end (memory) or one client (LCM, where participants cannot be told apart)
 * may take of what is there for all, however many client ids it uses. Each of them has an account here, its purse.
 *
 * Of each limit of the world (clients, bodies, shapes, subscriptions, geometries) `share` percent, so that the rest
 * stays free for others. And of time: each command and query has a price in microseconds of expected work (prices.c),
 * and a purse may spend `max_client_work` of them a second, with a burst that loads a large scene at once. What exceeds
 * that, or would make a tick long, waits here in its order, by purse, and the purses take turns; the waiting of all
 * takes at most `max_waiting` of memory, of which the share holds, too.
 *
 * All of it is decided by the clock, before a message is recorded or journalled: a recording has what was admitted, in
 * the tick in which it was, so that a replay and a standby need no purses. Tick thread. */
#ifndef COLLIDED_SERVICE_SHARES_H
#define COLLIDED_SERVICE_SHARES_H

#include "service.h"

typedef struct price { /* us of expected work */
    double in_tick;    /* in the tick that takes it */
    double in_all;     /* with what follows from it beside and behind that tick */
} price;

/* `bodies`: in the world, as many as there are to be matched or looked through. */
price price_of(const wire_message *m, size_t bodies);

typedef enum shares_verdict { SHARES_GO, SHARES_WAIT, SHARES_REFUSED, SHARES_DONE } shares_verdict;

shares *shares_create(void);
void shares_register(shares *h, metrics *m);
void shares_destroy(shares *h);

/* What becomes of a message that has come: GO: it is to be taken now, and counts; WAIT: it is kept here; REFUSED: `why`
 * names the limit; DONE: it was a greeting of the operator's tool, answered although there is no place for it: it may
 * ask, and is given nothing that it could keep. */
shares_verdict shares_admit(service *s, struct link *from, const wire_message *m, wire_refusal *why);

/* Each round, after the links have been taken from: what may go now is taken. */
void shares_release(service *s);
/* Of what was admitted since the last tick, commands that the next one is to carry out: what they are expected to take,
 * by their prices, and by how much longer commands took of late. */
double shares_expected_us(const service *s);
/* How long the tick took to carry these out, of a processor. Only of much is learnt: ask shares_learn first. */
bool shares_learn(const service *s);
void shares_carried_out(service *s, int64_t took_ns);
/* After the commands of a tick have been carried out. */
void shares_ticked(service *s);
/* Monotonic: when something that waits may go on; INT64_MAX: nothing does. */
int64_t shares_next_ns(const service *s);
/* Something waits for the next tick, which makes room. */
bool shares_want_tick(const service *s);

/* What came of all clients of a participant in the second that runs: for limits.c. Valid until another message. */
typedef enum shares_flow_kind { SHARES_MESSAGES, SHARES_POSES } shares_flow_kind;
flow *shares_flow(service *s, const struct link *from, int64_t client, shares_flow_kind kind);

/* A client is lost: what it said and was not taken is dropped. */
void shares_forget(service *s, int64_t client);

/* What the participant that sends this has in the world, about, in bytes. */
int64_t shares_bytes(const service *s, const struct link *from, const wire_message *m);

/* A query took so long, which its purse pays beyond what was expected. */
void shares_answered(service *s, const command *l, const wire_message *m, int64_t took_ns);
/* It is too late in this tick for that one: it is the first that its purse takes in the next. */
void shares_defer(service *s, const command *l, const wire_message *m);

#endif
