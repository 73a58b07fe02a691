/* plain: one small legal message of each kind whose numbers, texts and arrays a test may change, and what it expects
 * of wire_check then. One thread. */
#ifndef COLLIDED_TESTS_WIRE_PLAIN_H
#define COLLIDED_TESTS_WIRE_PLAIN_H

#include "wire/wire.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

/* Everything that plain messages point to; plain_message sets it anew. */
typedef struct plain_arrays {
    double pose[7], sizes[6], radii[2], deviations[2], shape_poses[14], positions[6], orientations[8], linear[6],
        angular[6];
    double vertices[12], origin[3], half[3], direction[3], lo[2], hi[2], axes[6], points[6], manifold[9], distances[3];
    uint8_t types[2], actions[2], kinds[2], causes[2], counts[2], stale[2];
    int32_t bodies[2], shapes[2], indices[6];
    int64_t geometries[2], contacts[2], ages[2], features[3];
    double paddings[2], margins[2];
    const char *texts[2];
} plain_arrays;
extern plain_arrays plain;

wire_message plain_message(wire_kind kind);

/* A text of so many bytes, until the next call. */
const char *plain_text(size_t bytes);

void expect_accepted(const wire_message *m, const char *change);
void expect_refused(const wire_message *m, const char *change, wire_reason reason, const char *words);

/* The plain message of a kind, called m, after `change`. */
#define ACCEPTED(kind, change)                                                                                         \
    do {                                                                                                               \
        wire_message m = plain_message(kind);                                                                          \
        change;                                                                                                        \
        expect_accepted(&m, #change);                                                                                  \
    } while (0)
#define REFUSED(kind, change, reason, words)                                                                           \
    do {                                                                                                               \
        wire_message m = plain_message(kind);                                                                          \
        change;                                                                                                        \
        expect_refused(&m, #change, reason, words);                                                                    \
    } while (0)

#endif
