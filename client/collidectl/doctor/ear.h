/* ear: hears every daemon in a DDS domain or on an LCM group, also those that the client library would pass over: of
 * another wire, or one of two. It decodes Status itself, asks queries as a guest whom the daemon does not remember, and
 * changes nothing. One vtable a transport; all is polled by the one thread that calls. */
#ifndef COLLIDED_DOCTOR_EAR_H
#define COLLIDED_DOCTOR_EAR_H

#include "wire/wire.h"

#include <stdbool.h>
#include <stddef.h>

enum { EAR_DAEMONS_MAX = 8, EAR_COUNTERS_MAX = 256, EAR_NAME_MAX = 64 };

typedef struct ear_counter {
    char name[EAR_NAME_MAX];
    int64_t first, last; /* in the first and the last Status that were heard; -1: not in it */
} ear_counter;

typedef struct ear_daemon {
    int64_t epoch; /* of its start, and what tells daemons apart */
    int64_t first_stamp_ns, last_stamp_ns;
    unsigned statuses; /* heard */
    uint8_t health;
    char name[128], release[64], links[512], limits[256];
    ear_counter *counters;
    size_t counter_count;
} ear_daemon;

typedef struct ear_stranger { /* what is there and is not of our wire */
    size_t count;             /* of messages or endpoints */
    char what[192];           /* the last one, for people */
} ear_stranger;

typedef struct ear ear;

typedef struct ear_ops {
    void (*poll)(ear *e); /* takes what has come; does not wait */
    bool (*send)(ear *e, const wire_message *query);
    bool (*ready)(ear *e); /* a query will be heard, and its answer too */
    bool (*close)(ear *e);
} ear_ops;

typedef struct ear_options {
    unsigned domain;       /* DDS */
    const char *address;   /* LCM: udpm://GROUP:PORT?... or "" */
    const char *interface; /* "" = loopback */
    const char *peer;      /* LCM: the address of another host, whose packets are noticed; "" = none */
} ear_options;

struct ear { /* the head of each transport's own struct */
    const ear_ops *ops;
    ear_daemon daemons[EAR_DAEMONS_MAX];
    size_t daemon_count, daemons_passed_over; /* more than EAR_DAEMONS_MAX */
    ear_stranger strangers;
    char reject[256];                       /* the last refusal that was heard, of any client; "" = none */
    size_t participants, mute_participants; /* DDS: others that were found; of these, whose endpoints are not known */
    bool peer_heard;                        /* LCM: a packet came from the peer */
    int64_t client;                         /* the guest's number in queries */
    int64_t sequence, answered;
    void *context; /* of the query that waits */
    void (*on_answer)(void *context, const wire_answer *answer);
};

ear *ear_open_dds(const ear_options *options, char *why, size_t why_size);
ear *ear_open_lcm(const ear_options *options, char *why, size_t why_size);
bool ear_close(ear *e); /* false: it could not be closed, and its domain cannot be opened again */

/* Listens for so long, or until there is a daemon and nothing new has come for `calm_s`. */
void ear_listen(ear *e, double seconds, double calm_s);

/* Asks, and waits for the answer; false if none came in time. Called once, with the answer, during this call. */
bool ear_ask(ear *e, wire_query query, double seconds, void (*on_answer)(void *context, const wire_answer *answer),
    void *context);

/* The one whom clients follow: the latest started; NULL = none. */
const ear_daemon *ear_followed(const ear *e);
const ear_counter *ear_counter_of(const ear_daemon *d, const char *name); /* NULL = it does not have it */
int64_t ear_value(const ear_daemon *d, const char *name);                 /* the last; 0 if it does not have it */

/* For the transports: what came. */
void ear_message(ear *e, const wire_message *m);
__attribute__((format(printf, 2, 3))) void ear_strange(ear *e, const char *format, ...);
double ear_now_s(void); /* monotonic */

#endif
