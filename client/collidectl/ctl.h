/* ctl: what the verbs of collidectl share: the options of this run, the connection, and how to fail. One thread. */
#ifndef COLLIDED_COLLIDECTL_CTL_H
#define COLLIDED_COLLIDECTL_CTL_H

#include "collided.h"
#include "loaders/package.h"
#include "loaders/pool.h"
#include "loaders/report.h"

#include <stdbool.h>
#include <stddef.h>

enum { PACKAGES_MAX = 64 };

typedef struct ctl_options { /* options.c tells what they mean */
    const char *connect, *as;
    double timeout_s;
    bool help;
    bool json, brief, fixed, stay, once;
    double wait_s, seconds;
    const char *srdf, *prefix, *state, *joints, *meshes;
    load_package packages[PACKAGES_MAX];
    size_t package_count;
    bool posed;
    collided_pose pose;
    const char *select_a, *select_b;
    unsigned facts;
    const char *accuracy; /* "boxes", "tolerance", "verdict" */
    double deadline_s, margin_m, range_m, tolerance_m, relative_tolerance, hysteresis_m, rate_hz, length_m, horizon_s,
        span_s;
    double linear[3], angular[3]; /* m/s and rad/s, world axes */
    bool has_linear, has_angular, teleport;
    double workers, speed;
    const char *interface, *peer, *system_root; /* NULL = none */
    const char *out;
    bool list;
    double excess_m;
    const char *output, *mcap; /* NULL = none */
} ctl_options;

typedef struct ctl {
    ctl_options options;
    char **arguments; /* after the verb, options taken out */
    int argument_count;
    pool pool;
    load_report report; /* of the loaders; warnings go to standard error */
    collided *client;
    char rejected[512]; /* the first refusal of the daemon, "" = none */
} ctl;

typedef struct ctl_verb {
    const char *name;
    const char *arguments; /* as --help shows them */
    int least, most;       /* of arguments */
    int (*run)(ctl *c);    /* returns an exit status of sysexits.h */
    const char *summary;
    const char *details; /* further lines of help, or "" */
} ctl_verb;

extern const ctl_verb ctl_verbs[];
const ctl_verb *ctl_find_verb(const char *name); /* NULL = none */

/* "collidectl: ..." in one line to standard error; returns `status`. */
__attribute__((format(printf, 2, 3))) int ctl_fail(int status, const char *format, ...);
int ctl_fail_loading(ctl *c); /* what the loaders' report says */

/* Connects; 0, or an exit status after saying why not. As a guest: under a random id; whatever it creates goes with
 * this process. As the owner: under the id made from --as, so that a later run goes on with the same bodies, which
 * stay. */
int ctl_connect_guest(ctl *c);
int ctl_connect_owner(ctl *c);
int ctl_connect_as(ctl *c, int64_t id, collided_on_loss on_loss);
void ctl_disconnect(ctl *c);

/* "collided" in the folder that this program lies in; "collided" alone (PATH) if it is not there. */
const char *ctl_find_daemon(ctl *c);

/* Says what a status of the client library means here; 0 for COLLIDED_OK. */
int ctl_check(ctl *c, collided_status status, const char *what);

double ctl_now_s(void); /* monotonic */

/* SIGINT or SIGTERM has come (after ctl_catch_signals). */
void ctl_catch_signals(void);
bool ctl_interrupted(void);
/* Polls until interrupted, or for `seconds` if that is above 0. An exit status. */
int ctl_poll(ctl *c, double seconds);

#endif
