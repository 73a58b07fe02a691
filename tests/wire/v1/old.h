/* old: what the two clients of this folder share. They were built from the definitions beside them, use nothing else of
 * this project, and stay as they are: whatever daemon comes later has to serve them. Each announces two balls and a
 * subscription, moves the balls into each other and apart, asks for their distance, says something wrong, leaves, and
 * prints what it has heard. One thread. */
#ifndef COLLIDED_TESTS_WIRE_V1_OLD_H
#define COLLIDED_TESTS_WIRE_V1_OLD_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define OLD_CLIENT INT64_C(0x01dc11e47)
#define OLD_STREAM "old"
enum { OLD_BODY_A = 1, OLD_BODY_B = 2, OLD_SUBSCRIPTION = 3, OLD_BAD_BODY = 4 };
enum { SAY_CLIENT = 1, SAY_BODY_A, SAY_BODY_B, SAY_SUBSCRIPTION, SAY_BAD_BODY, SAY_QUERY, SAY_NEXT }; /* sequences */

static struct heard {
    bool acks[SAY_NEXT];
    int begins, ends, statuses, answers, rejects, unknown_kinds, extensions;
    double lo, hi; /* of the answer */
} heard;

static int64_t next_sequence = SAY_NEXT; /* of poses */

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Receives until the condition holds, and says it again every 0.3 s. The process fails after 30 s. */
#define UNTIL(say, condition)                                                                                          \
    do {                                                                                                               \
        double end_s = now_s() + 30, due_s = 0;                                                                        \
        while (!(condition)) {                                                                                         \
            if (now_s() > end_s) {                                                                                     \
                printf("not within 30 s: %s\n", #condition);                                                           \
                exit(1);                                                                                               \
            }                                                                                                          \
            if (now_s() >= due_s) {                                                                                    \
                say;                                                                                                   \
                due_s = now_s() + 0.3;                                                                                 \
            }                                                                                                          \
            receive();                                                                                                 \
        }                                                                                                              \
    } while (0)

static void take_ack(int64_t sequence)
{
    if (sequence > 0 && sequence < SAY_NEXT) heard.acks[sequence] = true;
}

/* Constants are those of the client's own definitions. */
static void take_event(int kind, int begin, int end, int averted)
{
    heard.begins += kind == begin;
    heard.ends += kind == end;
    if (kind <= averted) return;
    heard.unknown_kinds++;
    printf("unknown kind %d\n", kind);
}

static int summary(void)
{
    printf("begins %d ends %d answers %d rejects %d unknown kinds %d extensions %d\n", heard.begins, heard.ends,
        heard.answers, heard.rejects, heard.unknown_kinds, heard.extensions);
    return heard.lo <= -0.1 && heard.hi >= -0.1 && heard.hi - heard.lo < 1e-6 ? 0 : 1;
}

#endif
