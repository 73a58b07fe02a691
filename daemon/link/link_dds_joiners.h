/* link_dds_joiners: the daemon's end of wire_dds_turn.h: clients of the library join a few at a time, so that a crowd
 * comes in as fast as the machine can, and does not hinder itself. The same thread calls out at the well-known ports of
 * the host, so that participants of other programs find the daemon at once. A thread of its own; nothing here is waited
 * for. */
#ifndef COLLIDED_LINK_LINK_DDS_JOINERS_H
#define COLLIDED_LINK_LINK_DDS_JOINERS_H

#include "base/metrics.h"

#include <dds/dds.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

/* One by one: what a second newcomer asks for while the same is about to be sent to the first, Cyclone sends to
 * everybody who is there. Who is slow, or has lost a datagram, holds up the next for a moment, and several of them do
 * not hold up all. */
enum {
    JOINERS_AT_ONCE = 24,
    JOINERS_ALONE_MS = 100,    /* a turn is given no sooner after the last one, unless that one is over: */
    JOINERS_ALONE_MOST = 500,  /* twice as many ms as wait, from the one to the other */
    JOINERS_QUICK_MS = 30,     /* what a turn takes beyond this passes once more before the next */
    JOINERS_MS = 2000,         /* who has not come in by then does not hinder the next any more */
    JOINERS_WAITING = 400,     /* that wait; the rest is told to ask again, ... */
    JOINERS_WAITING_USER = 300 /* ... and of one user's processes */
};

/* A call goes to the well-known ports and, as Cyclone will have it, to all who are known, of whom each is woken by it:
 * so the more of them there are the rarer it is. */
enum { JOINERS_CALL_MS = 500, JOINERS_CALL_EACH_MS = 16, JOINERS_CALL_MOST_MS = 4000 };

typedef struct joiner {
    int fd;
    uint32_t user;
    int64_t until_ns; /* of a turn; 0: it waits */
} joiner;

typedef struct joiners {
    uint32_t domain;
    bool runs;
    pthread_t thread;
    int stop_fd, listen_fd;                       /* below 0: not open; another daemon of this domain listens */
    joiner at[JOINERS_WAITING + JOINERS_AT_ONCE]; /* in the order of their coming */
    unsigned count;
    int64_t pause_until_ns;          /* no turn is given before */
    uint32_t last_user;              /* who had the last turn: of several users each has his */
    dds_entity_t participant, known; /* the daemon's, and a writer of its whose readers are those who are known */
    uint8_t called;                  /* so often, modulo 256 */
    unsigned present;                /* clients, at the last call */
    int64_t call_ns;                 /* the next call; monotonic */
    metric *waiting, *given, *overdue, *refused, *given_up;
} joiners;

/* `participant` is the daemon's, `known` a writer of its that each client of the library reads. */
void joiners_start(joiners *t, uint32_t domain, dds_entity_t participant, dds_entity_t known, metrics *m);
void joiners_end(joiners *t);

#endif
