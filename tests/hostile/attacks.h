/* attacks: what one client may send, within the documented limits, that once held the daemon, or takes what others
 * need. Each is carried out by a process of its own, with the client library, and ends by itself. */
#ifndef COLLIDED_TESTS_HOSTILE_ATTACKS_H
#define COLLIDED_TESTS_HOSTILE_ATTACKS_H

#include <stdbool.h>
#include <stddef.h>

typedef struct attack {
    const char *name, *what; /* what: one line for people */
    void (*run)(const char *uri, bool full);
    double
        most_ms; /* that a neighbour may have to wait, but for one time in a hundred: 50; more is not good enough yet */
} attack;

/* full: at the documented maximum; otherwise as much as a test of a few seconds can do. */
extern const attack attacks[];
extern const size_t attack_count;

#endif
