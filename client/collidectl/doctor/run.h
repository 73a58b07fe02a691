/* run: one run of the doctor: what it was asked, what it has heard so far, and what its checks share. */
#ifndef COLLIDED_DOCTOR_RUN_H
#define COLLIDED_DOCTOR_RUN_H

#include "ear.h"
#include "facts.h"
#include "options.h"

enum { DDS_DOMAINS = 231, DDS_PARTICIPANTS = 64 /* a domain and host, on loopback: WIRE_DDS_INDICES */ };

typedef struct doctor {
    doctor_options options; /* with "" for what was NULL */
    bool over_lcm;
    unsigned domain;           /* DDS */
    const char *address;       /* LCM: what follows lcm:// */
    facts_interface interface; /* that DDS or LCM uses; its name "" = there is none of that name */
    ear *ear;                  /* NULL: it did not open, and `deaf` says why */
    bool stranger;             /* somebody does not speak our wire */
    bool opened;               /* it did, when the checks began */
    char deaf[256];
    char elsewhere[128];      /* a daemon that was heard in another domain or on another interface; "" = none */
    const ear_daemon *daemon; /* the one that clients follow; NULL = none was heard */
} doctor;

/* Reads the options; which must outlive the run. False if the URI is neither dds:// nor lcm://, or not well-formed. */
bool doctor_begin(doctor *d, const doctor_options *options);
void doctor_listen(doctor *d); /* opens the ear, and waits for a daemon */

bool doctor_uses_lcm(const doctor *d); /* the URI, or the daemon that was heard; without one: as by default */
void doctor_progress(const doctor *d, const char *format, ...) __attribute__((format(printf, 2, 3)));
ear *doctor_open_ear(const doctor *d, unsigned domain, const char *interface, char *why, size_t why_size);

#endif
