/* neighbour: an ordinary client who asks and publishes all the while that somebody else attacks the daemon, and writes
 * down how long he waited and whether he was told the truth. Two cubes of his own, far from everybody: one stands,
 * the other goes to and fro beside it at distances that are known. In turn he publishes a pose and waits for the event
 * that follows from it, and asks for the distance. */
#ifndef COLLIDED_TESTS_HOSTILE_NEIGHBOUR_H
#define COLLIDED_TESTS_HOSTILE_NEIGHBOUR_H

#include <stdatomic.h>
#include <stdint.h>

enum { NEIGHBOUR_BINS = 2048 /* of a histogram: 16 a doubling, from 1 us on */ };

typedef struct neighbour_waits { /* one histogram */
    atomic_uint_fast64_t bins[NEIGHBOUR_BINS];
} neighbour_waits;

/* In memory that both processes share. The parent reads and clears; the neighbour writes. */
typedef struct neighbour_report {
    neighbour_waits answers, events, machine;       /* machine: how much longer than asked a sleep of his took */
    atomic_uint_fast64_t rounds, wrong, unanswered; /* wrong: an interval without the truth, or without a proof of it */
    atomic_uint_fast64_t longest_tick_ns;           /* of the daemon's rounds: receiving, tick, answers */
    atomic_uint_fast64_t most_cpu_ns;               /* ... what one of them took of a processor at most */
    atomic_uint_fast64_t epoch, restarts;           /* restarts: how often the daemon's epoch has changed */
    atomic_bool ready, end;                         /* end: set by the parent */
    char error[256];                                /* why he gave up; "" = he did not */
} neighbour_report;

/* The life of the process; returns its exit status. */
int neighbour_live(const char *uri, neighbour_report *r);

/* Nearest rank, ms; 0 = nothing was measured. */
double neighbour_percentile_ms(const neighbour_waits *w, double share);
uint64_t neighbour_count(const neighbour_waits *w);
void neighbour_clear(neighbour_report *r);

#endif
