/* one_daemon: a daemon in this process, which a fuzz target drives tick by tick with a clock of its own, and what it
 * says. One thread; the one that runs it is the daemon's tick thread. */
#ifndef COLLIDED_TESTS_FUZZ_ONE_DAEMON_H
#define COLLIDED_TESTS_FUZZ_ONE_DAEMON_H

#include "fuzz.h"
#include "service/clients.h"
#include "service/streams.h"

#include "base/log.h"
#include "link/link_memory.h"
#include "service/config.h"
#include "service/server.h"
#include "service/service.h"
#include "service/shares.h"

#include <string.h>

typedef struct one_daemon {
    server *server;
    service *service;
    link_sink sink;
    memory_end *end; /* hears all that it says */
    wire_memory *memory;
    int64_t now_ns;
} one_daemon;

static inline void one_daemon_begin(one_daemon *d)
{
    char why[512];
    config c;
    config_default(&c);
    c.workers = 1;
    strcpy(c.links, "memory://fuzz");
    log_setup(LOG_ERROR, 0);
    d->server = server_create(&c, why, sizeof why);
    PROMISE(d->server);
    d->service = server_service(d->server);
    d->sink = server_sink(d->server);
    d->end = memory_connect("fuzz");
    d->memory = wire_memory_create();
    d->now_ns = INT64_C(1000000000000);
    d->service->now_ns = d->service->monotonic_ns = d->now_ns;
}

static inline void one_daemon_end(one_daemon *d)
{
    memory_disconnect(d->end);
    server_destroy(d->server);
    wire_memory_destroy(d->memory);
}

/* As if it had come by its link. */
static inline void one_daemon_give(one_daemon *d, const wire_message *m)
{
    d->sink.message(d->sink.context, d->service->links[0], m);
}

static inline void one_daemon_tick(one_daemon *d, int64_t by_ns)
{
    service *s = d->service;
    d->now_ns += by_ns;
    s->now_ns = s->monotonic_ns = d->now_ns;
    s->links[0]->ops->receive(s->links[0], &d->sink); /* who reads which stream */
    shares_release(s);
    session_check_leases(s);
    s->tick++;
    service_tick(s);
    stream_heartbeats(s);
}

/* The next message that it has said; valid until the one after it. */
static inline bool one_daemon_hear(one_daemon *d, wire_message *m)
{
    wire_refusal why;
    wire_memory_reset(d->memory);
    if (!memory_receive(d->end, d->memory, m)) return false;
    PROMISE(wire_check(m, &why) == WIRE_OK); /* we say nothing that we would refuse */
    for (uint32_t i = 0; m->kind == WIRE_EVENT_BATCH && i < m->event_batch.kinds.count; i++)
        PROMISE(m->event_batch.lo.at[i] <= m->event_batch.hi.at[i]);
    return true;
}

#endif
