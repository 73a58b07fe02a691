/* doctor: checks what goes wrong in practice between a daemon and its clients, and names the command that mends it. It
 * only reads this system and listens; besides that it asks the daemon a few queries as a guest. One thread of ours. */
#ifndef COLLIDED_DOCTOR_DOCTOR_H
#define COLLIDED_DOCTOR_DOCTOR_H

#include <stddef.h>

typedef enum doctor_verdict { DOCTOR_OK, DOCTOR_PROBLEM, DOCTOR_UNKNOWN } doctor_verdict;

const char *doctor_verdict_name(doctor_verdict verdict); /* "ok", "problem", "cannot tell" */

enum { DOCTOR_TEXT_MAX = 640 };

typedef struct doctor_finding {
    doctor_verdict verdict;
    char seen[DOCTOR_TEXT_MAX]; /* one line: what was seen, with its numbers */
    char mend[DOCTOR_TEXT_MAX]; /* of a problem: one line for the shell. "ssh HOST ..." = to be run there */
} doctor_finding;

typedef struct doctor_options {
    const char *uri;         /* dds://DOMAIN or lcm://... */
    const char *interface;   /* NULL = this machine only */
    const char *peer;        /* address of another host that should be heard; NULL = none */
    const char *system_root; /* where proc/ is read; "" = / */
    const char *release;     /* ours */
    const char *daemon;      /* the daemon's program, for commands that start one */
    double timeout_s;        /* how long to wait for a daemon */
    void *context;
    void (*found)(void *context, const char *check, const doctor_finding *finding); /* in the order of the table */
    void (*progress)(void *context, const char *what); /* before what takes longer than a second */
} doctor_options;

/* Runs all checks. The number of problems; -1 if the URI is neither dds:// nor lcm://, or not well-formed. */
int doctor_run(const doctor_options *options);

/* The table: name and summary of check `i`; NULL beyond the last. */
const char *doctor_check_name(size_t i, const char **summary);

#endif
