/* link_dds_joiners: the daemon's end of wire_dds_turn.h: clients of the library join a few at a time, so that a crowd
 * comes in as fast as the machine can, and does not hinder itself. The same thread calls out at the well-known ports of
 * the host, so that participants of other programs find the daemon at once. A thread of its own; nothing here is waited
 * for. */
#ifndef COLLIDED_LINK_LINK_DDS_JOINERS_H
#define COLLIDED_LINK_LINK_DDS_JOINERS_H

#include "base/metrics.h"
#include "wire/dds/wire_dds_qos.h"

#include <dds/dds.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

/* In a room, or outside of all, one by one: what a second newcomer asks for while the same is about to be sent to the
 * first, Cyclone sends to everybody who is there. Who is slow, or has lost a datagram, holds up the next for a moment,
 * and several of them do not hold up all. Rooms are filled a few at a time, each from the first to the last place, so
 * that those that are full have nothing more to do with those who come. */
enum {
    JOINERS_AT_ONCE = 24,
    JOINERS_ALONE_MS = 100,      /* outside, a turn is given no sooner after the last, unless that is over: */
    JOINERS_ALONE_MOST = 500,    /* twice as many ms as wait, from the one to the other */
    JOINERS_ALONE_ROOM_MS = 200, /* the same in a room */
    JOINERS_QUICK_MS = 30,       /* outside, what a turn takes beyond this passes once more before the next */
    JOINERS_MS = 2000,           /* who has not come in by then does not hinder the next any more */
    JOINERS_WAITING = 400,       /* that wait; the rest is told to ask again, ... */
    JOINERS_WAITING_USER = 300,  /* ... and of one user's processes */
    JOINERS_BEFORE_ROOMS = 16,   /* so many clients are in no room */
    JOINERS_ROOMS_TOGETHER = 4   /* are filled */
};

/* A call goes to the well-known ports and, as Cyclone will have it, to all who are known, of whom each is woken by it:
 * so the more of them there are the rarer it is. */
enum { JOINERS_CALL_MS = 500, JOINERS_CALL_EACH_MS = 16, JOINERS_CALL_MOST_MS = 4000 };

typedef struct joiner {
    int fd;
    uint32_t user;
    uint8_t room;     /* 0: none */
    int64_t until_ns; /* of a turn; 0: it waits */
} joiner;

/* The rooms of the link, as they are needed here; each is called by the thread of joiners alone. */
typedef struct joiners_rooms {
    void *link;
    bool (*may)(void *link);                        /* are there any? */
    bool (*open)(void *link, unsigned room);        /* from 1; false: it cannot be opened */
    unsigned (*present)(void *link, unsigned room); /* clients that are in it; 0: that are in none */
} joiners_rooms;

typedef struct joiners {
    joiners_rooms rooms;
    dds_entity_t participant; /* the daemon's, outside of rooms */
    uint32_t domain;
    bool runs;
    pthread_t thread;
    int stop_fd, listen_fd;                       /* below 0: not open; another daemon of this domain listens */
    joiner at[JOINERS_WAITING + JOINERS_AT_ONCE]; /* in the order of their coming */
    unsigned count;
    int64_t pause_until_ns;               /* outside of rooms no turn is given before */
    uint32_t last_user;                   /* who had the last turn: of several users each has his */
    uint8_t called;                       /* so often, modulo 256 */
    unsigned present[WIRE_DDS_ROOMS + 1]; /* clients, when somebody came last, with those who were to come */
    int64_t call_ns;                      /* the next call; monotonic */
    metric *waiting, *given, *overdue, *refused, *given_up, *rooms_open;
} joiners;

void joiners_start(joiners *t, uint32_t domain, dds_entity_t participant, const joiners_rooms *rooms, metrics *m);
void joiners_end(joiners *t);

#endif
