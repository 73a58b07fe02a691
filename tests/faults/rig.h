/* rig: real processes for the tests of this folder: a daemon with both links, in a network of the test program's own,
 * and clients in this process, or in further ones that a test stops and kills. Whatever a failed test leaves behind,
 * rig_end_all closes and ends, by its process id. One thread. */
#ifndef COLLIDED_TESTS_FAULTS_RIG_H
#define COLLIDED_TESTS_FAULTS_RIG_H

#include <collided.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <cmocka.h>

#define RIG_DDS "dds://61"
#define RIG_LCM "lcm://"
#define RIG_LINKS RIG_DDS " " RIG_LCM
/* For what must come and says nothing about speed, in seconds: for a machine that has ten other things to do. */
#define RIG_PATIENCE_S 30.0

/* A user and network namespace with loopback and multicast. False after saying why not; each test is then skipped. */
bool rig_isolate(void);
void rig_need_network(void); /* skips the test if there is none; rig_daemon does so, too */
int rig_end_all(void **state);
/* After rig_isolate: a file system of that size, which only we, and whom we start, can see, in a new folder. False
 * after saying why not; `folder` is then "". Whoever ends without umount leaves an empty folder behind. */
bool rig_small_disk(char folder[64], int kib);

double rig_now_s(void); /* monotonic */

/* ---- processes ---- */

pid_t rig_daemon(const char *option, const char *value); /* one option more, or NULL; both links; it is ready */
/* One of a pair, with that option more, or NULL. A pair is in step only while each gets processor time within three
 * times its lease: that of the option table (0.1 s) is too short for a machine that has ten other things to do, and is
 * tried with COLLIDED_NIGHTLY=1. */
double rig_pair_lease_s(void);
pid_t rig_one_of_a_pair(const char *option);
pid_t rig_one_of_a_pair_of(double lease_s, const char *option);          /* of that lease */
pid_t rig_start(const char *program, const char *const *arguments);      /* ended by NULL */
pid_t rig_self(const char *role, const char *uri, const char *argument); /* this program again, as another client */
void rig_kill(pid_t pid, int number);                                    /* a signal; SIGKILL also waits */
/* Its exit status, or 128 + the signal that ended it. Fails the test if it has not ended within that time. */
int rig_wait(pid_t pid, double seconds);
bool rig_alive(pid_t pid);
bool rig_has_ended(pid_t pid);                    /* rig_wait will tell how */
pid_t rig_child(pid_t parent);                    /* its only child; 0 = none */
bool rig_has_thread(pid_t pid, const char *name); /* by the name that it gave itself */
long rig_resident_kb(pid_t pid);

/* ---- clients in this process ---- */

enum { HEARD_KINDS = COLLIDED_EVENT_AVERTED + 1 };

typedef struct heard {           /* by a subscription */
    size_t kinds[HEARD_KINDS];   /* events by collided_event_kind */
    char cause[HEARD_KINDS][16]; /* of the last one of each kind */
    size_t touching;             /* contacts now, counted from begins, ends and snapshots */
    size_t snapshots, batches;
    int64_t epoch, batch, step, lost;
    bool closing;
} heard;

collided *rig_connect(const char *uri, double lease_s, collided_on_loss on_loss);
void rig_close(collided *c);
collided_body rig_box(collided *c, const char *name, double x); /* a cube of side 1 m */
collided_status rig_move(collided *c, collided_body body, double x, int64_t step);
void rig_watch(collided *c, heard *h, const char *name); /* all contacts of the body of that name, each tick */
int64_t rig_counter(collided *c, const char *name);      /* of the last Status heard: UNTIL it tells what is expected */

/* Polls until the condition holds; fails the test if it does not within that time. */
#define UNTIL(client, seconds, condition)                                                                              \
    do {                                                                                                               \
        double until_end_s = rig_now_s() + (seconds);                                                                  \
        while (!(condition)) {                                                                                         \
            if (rig_now_s() > until_end_s) fail_msg("not within %g s: %s", (double)(seconds), #condition);             \
            collided_poll(client, 0.005);                                                                              \
        }                                                                                                              \
    } while (0)

/* Polls until the condition has held for that time without a break; fails the test if it does not come to that. For
 * what a machine that stands still for a moment may break, and a fault breaks again and again. */
#define UNTIL_IT_HOLDS(client, seconds, condition)                                                                     \
    do {                                                                                                               \
        double holds_end_s = rig_now_s() + (seconds) + RIG_PATIENCE_S, holds_since_s = rig_now_s();                    \
        while (rig_now_s() < holds_since_s + (seconds)) {                                                              \
            collided_poll(client, 0.005);                                                                              \
            if (!(condition)) holds_since_s = rig_now_s();                                                             \
            if (holds_since_s > holds_end_s) fail_msg("it does not hold for %g s: %s", (double)(seconds), #condition); \
        }                                                                                                              \
    } while (0)

/* Polls for that time, in which the condition must hold all along. */
#define THROUGHOUT(client, seconds, condition)                                                                         \
    do {                                                                                                               \
        double throughout_end_s = rig_now_s() + (seconds);                                                             \
        while (rig_now_s() < throughout_end_s) {                                                                       \
            if (!(condition)) fail_msg("no longer: %s", #condition);                                                   \
            collided_poll(client, 0.005);                                                                              \
        }                                                                                                              \
    } while (0)

/* A test for each link. */
#define OVER(test, uri)                                                                                                \
    {                                                                                                                  \
#test " over " uri, test, NULL, rig_end_all, (void *)(uintptr_t)(uri)                                          \
    }
#define OVER_BOTH(test) OVER(test, RIG_DDS), OVER(test, RIG_LCM)

#endif
