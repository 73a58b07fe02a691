/* stage: a daemon under a service manager that kills whoever does not give a sign of life within ten seconds, a
 * neighbour (neighbour.h), and an attack (attacks.h), each a process of its own in this process's network namespace.
 * One thread; the process must not have opened a link of its own: the others are forked from it. */
#ifndef COLLIDED_TESTS_HOSTILE_STAGE_H
#define COLLIDED_TESTS_HOSTILE_STAGE_H

#include "attacks.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct stage_result {
    double answer_ms_p99, event_ms_p99; /* of the neighbour, from the attack's beginning until he is at ease again */
    double machine_ms_p99;              /* how late his process woke from a sleep: what the machine added */
    double longest_tick_ms;
    double most_cpu_ms; /* what one tick took of a processor at most, whatever else the machine had to do */
    long rss_mb;        /* of the daemon, the most of ten looks a second */
    int restarts;
    uint64_t rounds, wrong, unanswered;
    bool attack_failed; /* it crashed, or could not begin */
    char error[256];    /* why nothing was measured; "" = all went well */
} stage_result;

/* Carries out one attack over the link of that URI. Waits for it to end: at most ten minutes (full) or two. */
void stage_play(const attack *a, const char *uri, bool full, stage_result *out);

#endif
