/* transport: how messages travel between this client and a daemon. One table of functions a transport, chosen by the
 * URI's scheme. send, flush and drain are called with the client's mutex held. Receiving has two roles, each with its
 * own readers and file descriptor, so that the library's thread and the caller's never wait for each other: control
 * (acks, rejects, status; the library's thread) and streams (event batches, answers; the caller's thread). */
#ifndef COLLIDED_CLIENT_TRANSPORT_H
#define COLLIDED_CLIENT_TRANSPORT_H

#include "wire/wire.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct transport transport;

typedef enum transport_role { TRANSPORT_CONTROL, TRANSPORT_STREAMS, TRANSPORT_ROLES } transport_role;

typedef struct transport_options {
    const char *address;   /* what follows "scheme://" */
    const char *interface; /* network interface; "" = loopback only */
    const char *security;  /* folder of certificates and permissions; "" = none */
    int64_t client;
    int64_t lease_ns;
    int64_t until_ns; /* of the monotonic clock: how long opening may wait for its turn; 0 = it may not */
    /* Something has come for TRANSPORT_STREAMS: may a thread of the transport's receive it itself, now? It has done so
     * if this is true; otherwise the role's descriptor has to become readable. NULL: never. */
    bool (*arrived)(void *context);
    void *arrived_context;
} transport_options;

typedef struct transport_sink {
    void *context;
    void (*message)(void *context, const wire_message *m);   /* checked; valid during the call */
    void (*refused)(void *context, const wire_refusal *why); /* something came that is not a message of ours */
} transport_sink;

typedef struct transport_ops {
    const char *scheme;
    bool repeats;       /* nothing keeps what was sent: heartbeats, early repetition, all anew for a new daemon */
    uint32_t poses_max; /* poses a message that travel well */
    /* NULL, with a line in `why` that says what failed and what to do. */
    transport *(*open)(const transport_options *options, char *why, size_t why_size);
    int (*send)(transport *t, const wire_message *m); /* 0, or -1 when the transport refused */
    bool (*permits)(transport *t, wire_kind kind); /* may this client write such messages? NULL: there is no security */
    void (*flush)(transport *t);
    /* Waits at most so long until the receivers have what was sent, where a transport can know. */
    void (*drain)(transport *t, int64_t timeout_ns);
    /* The daemon is matched in both directions: a query will be heard, and so will its answer. */
    bool (*ready)(transport *t);
    /* No daemon is heard: tells those of us that may have begun since we told them last. NULL: it need not be asked. */
    void (*seek)(transport *t);
    void (*joined)(transport *t); /* the daemon knows us, or we gave up: others may have their turn. NULL: no turns */
    int (*fd)(transport *t, transport_role role); /* readable when there is something to receive */
    void (*receive)(transport *t, transport_role role, const transport_sink *sink); /* all that has come; no waiting */
    /* Begins and ends to read a stream; by the thread of the role TRANSPORT_STREAMS, outside of receive. */
    int (*stream_open)(transport *t, const char *stream);
    void (*stream_close)(transport *t, const char *stream);
    /* The daemon does not hear us: new writers in the place of the old ones, of what is announced as well if `all`, all
     * of which has to be said again then. With the lock held; NULL: there are no writers. */
    void (*renew)(transport *t, bool all);
    /* Deletes the old ones, which may take a second: the library's thread, without the lock. NULL as above. */
    void (*retire)(transport *t);
    void (*forget)(transport *t, const wire_message *removed); /* a removal that was acknowledged */
    void (*close)(transport *t);
} transport_ops;

struct transport { /* the head of each transport's own struct */
    const transport_ops *ops;
};

extern const transport_ops transport_dds_ops, transport_lcm_ops, transport_pipe_ops;

#endif
