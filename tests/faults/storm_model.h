/* storm_model: what the processes of a storm share (storm.c), and what a listener holds against every batch that it is
 * handed: each contact id begins once and ends once, after its end nothing more is said of it, a snapshot on a stream
 * that lost nothing is what was told, and a new epoch begins with a snapshot; one of the same line, where a standby has
 * taken over, goes on. One thread a process; what is shared lies in memory that all of them map, and is written by its
 * owner alone. */
#ifndef COLLIDED_TESTS_FAULTS_STORM_MODEL_H
#define COLLIDED_TESTS_FAULTS_STORM_MODEL_H

#include <collided.h>

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { STORM_OWNERS = 4, STORM_BODIES = 6, STORM_LISTENERS = 4, STORM_OPEN_MAX = 1024, STORM_FAULT_MAX = 512 };

typedef struct storm_contact {
    int64_t id;
    uint64_t pair; /* both bodies, as storm_body_key has them */
    bool seen;     /* in the snapshot at hand */
} storm_contact;

typedef struct storm_model { /* of one subscription */
    int64_t epoch, batch, begun, ended, unheard, snapshots, lost, epochs, takeovers;
    size_t open_count;
    storm_contact open[STORM_OPEN_MAX];
    uint8_t *over;           /* a bit for each id of this epoch that has ended */
    _Atomic uint64_t digest; /* of the set that is open now */
    _Atomic int faulty;      /* 1: `fault` says what was wrong first */
    char fault[STORM_FAULT_MAX];
} storm_model;

typedef struct storm_owner {
    _Atomic int starts, life, quiet; /* how often it was started; the part of its names that says so; it publishes the
                                        same poses from now on */
    bool there[STORM_BODIES];        /* and not removed */
    double place[STORM_BODIES][2];   /* x, y: m, multiples of STORM_GRID_M */
} storm_owner;

typedef struct storm_shared {
    _Atomic int quiet; /* the storm is over */
    storm_owner owners[STORM_OWNERS];
    storm_model listeners[STORM_LISTENERS];
} storm_shared;

/* Balls of radius 0.5 m on a grid on which no two centres are 1 m apart: touching is never a matter of rounding. */
#define STORM_GRID_M 0.3

collided_subscription storm_listen(collided *c, storm_model *m); /* to all contacts; `m` is as new */
bool storm_known(int owner); /* it comes back under the id that it had, and its bodies are held meanwhile */
void storm_name(char name[32], int owner, int life, int body);

uint64_t storm_random(uint64_t *state); /* splitmix64 */

/* What a listener must have open in the end, by comparing all bodies with all others. */
uint64_t storm_truth(const storm_shared *s, size_t *count);
uint64_t storm_digest(const storm_model *m);
void storm_print_difference(const storm_shared *s, const storm_model *m);

#endif
