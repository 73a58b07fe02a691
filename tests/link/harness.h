/* harness: what the tests of the links share: sample messages of every kind, a sink that keeps what it is told, and a
 * network namespace. */
#ifndef COLLIDED_TESTS_LINK_HARNESS_H
#define COLLIDED_TESTS_LINK_HARNESS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/clock.h"
#include "base/metrics.h"
#include "link/link.h"
#include "wire/wire_lcm.h"

enum { CLIENT_ID = 7, NAME_BYTES = 128, CLIENT_LEASE_MS = 1000 };
/* For what must come, in seconds, on a machine that has ten other things to do. */
#define RIG_PATIENCE_S 30.0

/* A valid message of that kind; each string and number differs from its default. Static memory. */
wire_message sample_message(wire_kind kind);
/* `count` poses (at most 1000). */
wire_message sample_poses(int32_t count, int64_t sequence);
wire_message sample_events(const char *stream, int64_t batch);

/* Messages are equal when their encodings are. */
bool same_message(const wire_message *a, const wire_message *b);

typedef struct heard {
    size_t messages[WIRE_KIND_COUNT];
    size_t differing;      /* messages that differ from sample_message of their kind */
    size_t removed;        /* messages with removed = 1 */
    int64_t last_sequence; /* of PoseBatch */
    size_t disordered;     /* PoseBatches whose sequence did not grow */
    size_t refused;
    wire_kind refused_kind;
    int64_t refused_client, refused_sequence;
    wire_refusal why;
    size_t lost;
    int64_t lost_client;
    size_t readers;
    char reader[NAME_BYTES]; /* the stream of the last one */
} heard;

typedef struct rig { /* a link with a sink */
    struct link *link;
    link_sink sink;
    heard heard;
    metrics *counters;
    int wake_fd;
} rig;

/* The link must open. `program`: of the LCM gateway, or NULL. */
void rig_open(rig *r, const char *uri, const char *program);
void rig_close(rig *r);
void rig_receive(rig *r);
void rig_publish(rig *r, const wire_message *m); /* and flush */
uint64_t rig_counter(const rig *r, const char *name);

/* Receives until the condition holds; fails after `seconds`. */
#define RIG_UNTIL(r, seconds, condition)                                                                               \
    do {                                                                                                               \
        int64_t rig_end = clock_monotonic_ns() + (int64_t)((seconds)*1e9);                                             \
        while (rig_receive(r), !(condition))                                                                           \
            if (rig_wait((r), rig_end)) fail_msg("not within %g s: %s", (double)(seconds), #condition);                \
    } while (0)
bool rig_wait(rig *r, int64_t end_ns); /* for the wake-up, or 20 ms; true: the time is over */
bool rig_is_woken(rig *r, int timeout_ms);

/* Moves this process, before it has threads, into a network of its own, with loopback up. False with a printed reason
 * where the system does not permit it. */
bool netns_enter(void);
bool netns_multicast_route(bool on); /* 224.0.0.0/4 over lo */

#endif
