/* link_dds_turns: the daemon's end of wire_dds_turn.h: clients of the library join a few at a time, so that a crowd
 * comes in as fast as the machine can, and does not hinder itself. A thread of its own; nothing here is waited for. */
#ifndef COLLIDED_LINK_LINK_DDS_TURNS_H
#define COLLIDED_LINK_LINK_DDS_TURNS_H

#include "base/metrics.h"

#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>

/* Few at once: what two of them ask for at the same time, of what is known to all, Cyclone sends to everybody who is
 * there (it merges what is sent again for several), so that a crowd's way in would cost its square. */
enum {
    TURNS_AT_ONCE = 1,
    TURNS_MS = 500,          /* who has not come in by then does not hinder the next any more */
    TURNS_WAITING = 400,     /* that wait; the rest is told to ask again, ... */
    TURNS_WAITING_USER = 300 /* ... and of one user's processes */
};

typedef struct turn {
    int fd;
    uint32_t user;
    int64_t until_ns; /* of a turn; 0: it waits */
} turn;

typedef struct turns {
    uint32_t domain;
    bool runs;
    pthread_t thread;
    int stop_fd, listen_fd;                 /* below 0: not open; another daemon of this domain listens */
    turn at[TURNS_WAITING + TURNS_AT_ONCE]; /* in the order of their coming */
    unsigned count;
    uint32_t last_user; /* who had the last turn: of several users each has his */
    metric *waiting, *given, *overdue, *refused;
} turns;

void turns_start(turns *t, uint32_t domain, metrics *m);
void turns_end(turns *t);

#endif
