/* options: what a run of the doctor is asked to look at, and whom it tells what it finds. */
#ifndef COLLIDED_DOCTOR_OPTIONS_H
#define COLLIDED_DOCTOR_OPTIONS_H

#include "finding.h"

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

#endif
