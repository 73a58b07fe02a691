/* link_memory: a hub in this process, between the daemon's end and any number of clients' ends. Messages wait, encoded,
 * in bounded queues: one towards the daemon, one for each client's end, which gets everything that is published.
 *
 * Any thread may use an end of its own. One lock guards all hubs; nobody sleeps under it. Who sends poses to a daemon
 * that waits runs its round (link_options.poses). */
#include "link_memory.h"

#include "base/array.h"
#include "incoming.h"
#include "opened.h"
#include "pipe/pipe.h"
#include "wake.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

enum { QUEUE_BYTES = 32 << 20 }; /* beyond, messages are dropped and counted */

typedef struct link_memory {
    struct link head;
    pipe_buffer incoming; /* under the lock */
    pipe_buffer taken;
    ARRAY(uint8_t) rest;          /* the message of which only a part was taken; ... */
    incoming_part part;           /* ... which part; ... */
    int64_t rest_of;              /* ... of whom */
    ARRAY(memory_end *) ends;     /* under the lock */
    unsigned offers;              /* under the lock: threads in link_options.poses */
    size_t lost[WIRE_KIND_COUNT]; /* under the lock: messages that did not fit, and nobody has been told yet; ... */
    bool has_lost;                /* ... some are */
    opened streams;
    wire_memory *memory;
    metric *messages_in, *refused, *queue_full, *messages_out, *out_dropped;
} link_memory;

struct memory_end {
    link_memory *hub; /* NULL: closed meanwhile */
    int64_t number;   /* of this end, never used again: whose messages they are */
    pipe_buffer queue;
};

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t offered = PTHREAD_COND_INITIALIZER;
static ARRAY(link_memory *) hubs;
static int64_t last_number; /* of an end; under the lock */

static link_memory *link_memory_of(struct link *l)
{
    return (link_memory *)l;
}

static link_memory *hub_named(const char *name)
{
    for (size_t i = 0; i < hubs.count; i++)
        if (strcmp(hubs.at[i]->head.options.address, name) == 0) return hubs.at[i];
    return NULL;
}

/* ---- the clients' ends ---- */

memory_end *memory_connect(const char *name)
{
    memory_end *e = NULL;
    pthread_mutex_lock(&lock);
    link_memory *hub = hub_named(name);
    if (hub) {
        e = base_zalloc(1, sizeof *e);
        e->hub = hub;
        e->number = ++last_number;
        array_push(&hub->ends, e);
    }
    pthread_mutex_unlock(&lock);
    return e;
}

static void forget_end(link_memory *hub, const memory_end *e)
{
    size_t i = 0;
    while (hub->ends.at[i] != e) i++;
    hub->ends.at[i] = hub->ends.at[--hub->ends.count];
}

void memory_disconnect(memory_end *e)
{
    if (!e) return;
    pthread_mutex_lock(&lock);
    if (e->hub) forget_end(e->hub, e);
    pthread_mutex_unlock(&lock);
    pipe_free(&e->queue);
    free(e);
}

static void wake_or_tick(link_memory *hub, bool poses)
{
    const link_options *o = &hub->head.options;
    if (!poses || !o->poses || !o->poses(o->poses_context, &hub->head)) wake(o->wake_fd);
    pthread_mutex_lock(&lock);
    if (--hub->offers == 0) pthread_cond_broadcast(&offered);
    pthread_mutex_unlock(&lock);
}

void memory_send_bytes(memory_end *e, const void *data, size_t size)
{
    pthread_mutex_lock(&lock);
    link_memory *hub = e->hub;
    bool first = false;
    if (hub) {
        bool fits =
            size <= PIPE_DATA_MAX && pipe_used(&hub->incoming) + pipe_frame_size(sizeof e->number, size) <= QUEUE_BYTES;
        first = fits && pipe_used(&hub->incoming) == 0;
        if (!fits) {
            metric_count(hub->queue_full, 1);
            hub->lost[wire_lcm_kind(data, size)]++;
            first = !hub->has_lost;
            hub->has_lost = true;
        }
        if (fits)
            pipe_put_frame(&hub->incoming, &(pipe_frame){.kind = PIPE_MESSAGE,
                                               .channel = (const char *)&e->number,
                                               .channel_length = sizeof e->number,
                                               .data = data,
                                               .size = size});
        hub->offers += first;
    }
    pthread_mutex_unlock(&lock);
    if (first) wake_or_tick(hub, wire_lcm_kind(data, size) == WIRE_POSE_BATCH);
}

void memory_send(memory_end *e, const wire_message *m)
{
    size_t size = wire_lcm_size(m);
    uint8_t *data = base_alloc(size, 1);
    wire_lcm_encode(m, data, size);
    memory_send_bytes(e, data, size);
    free(data);
}

bool memory_receive(memory_end *e, wire_memory *memory, wire_message *out)
{
    bool got = false;
    pipe_frame f;
    wire_refusal why;
    pthread_mutex_lock(&lock);
    while (!got && pipe_take(&e->queue, &f) == 1) {
        wire_memory_reset(memory);
        void *copy = wire_memory_take(memory, f.size); /* what is decoded may borrow from its bytes */
        memcpy(copy, f.data, f.size);
        got = wire_lcm_decode(copy, f.size, memory, out, &why) == WIRE_OK;
    }
    pthread_mutex_unlock(&lock);
    return got;
}

/* ---- the daemon's end ---- */

/* The address is the key. */
static int memory_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    if (snprintf(key, LINK_KEY_MAX, "memory %s", options->address) < LINK_KEY_MAX) return EX_OK;
    snprintf(why, why_size, "memory://%.60s...: the name is too long", options->address);
    return EX_CONFIG;
}

static int memory_open(struct link *head, const link_options *options, char *why, size_t why_size)
{
    link_memory *l = link_memory_of(head);
    pthread_mutex_lock(&lock);
    bool taken = hub_named(options->address) != NULL;
    if (!taken) array_push(&hubs, l);
    pthread_mutex_unlock(&lock);
    if (taken) {
        snprintf(why, why_size, "memory://%s: is open already in this process", options->address);
        return -1;
    }
    metrics *m = options->counters;
    l->memory = wire_memory_create();
    l->messages_in = metrics_add(m, "memory_messages_in", "messages of clients in this process");
    l->refused = metrics_add(m, "memory_refused", "messages in this process that were refused");
    l->queue_full = metrics_add(m, "memory_queue_full", "messages dropped because the tick did not take them");
    l->messages_out = metrics_add(m, "memory_messages_out", "messages published to this process");
    l->out_dropped = metrics_add(m, "memory_out_dropped", "messages dropped because a client did not take them");
    return 0;
}

static void take_one(link_memory *l, const link_sink *sink, int64_t origin, const void *data, size_t size)
{
    l->head.origin = origin;
    bool was = incoming_some(&l->head, sink, l->memory, data, size, &l->part);
    metric_count(was ? l->messages_in : l->refused, 1);
}

/* One message, or as much of it as there is room for. False: none is left. */
static bool take_next(link_memory *l, const link_sink *sink)
{
    pipe_frame f;
    if (l->rest.count) {
        take_one(l, sink, l->rest_of, l->rest.at, l->rest.count);
        if (l->part.whole) l->rest.count = 0;
        return true;
    }
    if (pipe_take(&l->taken, &f) != 1) return false;
    int64_t origin;
    memcpy(&origin, f.channel, sizeof origin);
    l->part.done = 0;
    take_one(l, sink, origin, f.data, f.size);
    if (l->part.whole) return true;
    array_reserve(&l->rest, f.size);
    memcpy(l->rest.at, f.data, f.size);
    l->rest.count = f.size;
    l->rest_of = origin;
    return true;
}

static void report_dropped(link_memory *l, const link_sink *sink)
{
    size_t lost[WIRE_KIND_COUNT];
    pthread_mutex_lock(&lock);
    bool some = l->has_lost;
    memcpy(lost, l->lost, sizeof lost);
    memset(l->lost, 0, sizeof l->lost);
    l->has_lost = false;
    pthread_mutex_unlock(&lock);
    for (int kind = 0; kind < WIRE_KIND_COUNT && some; kind++)
        if (lost[kind] && sink->lost) sink->lost(sink->context, &l->head, (wire_kind)kind, 0, lost[kind]);
}

/* What has come; where it is more than this round takes, the rest waits. */
static size_t memory_take_all(struct link *head, const link_sink *sink)
{
    link_memory *l = link_memory_of(head);
    uint64_t before = metric_get(l->messages_in);
    opened_report(&l->streams, head, sink);
    report_dropped(l, sink);
    for (bool swapped = false, more = true; more;) {
        if (take_next(l, sink)) {
            more = !l->rest.count;
            continue;
        }
        more = !swapped;
        swapped = true;
        pthread_mutex_lock(&lock);
        pipe_buffer taken = l->incoming;
        l->incoming = l->taken;
        l->taken = taken;
        pthread_mutex_unlock(&lock);
    }
    if (l->rest.count) wake(head->options.wake_fd);
    return (size_t)(metric_get(l->messages_in) - before);
}

static void memory_publish(struct link *head, const wire_message *m)
{
    link_memory *l = link_memory_of(head);
    size_t size = wire_lcm_size(m);
    pthread_mutex_lock(&lock);
    for (size_t i = 0; i < l->ends.count; i++) {
        pipe_buffer *q = &l->ends.at[i]->queue;
        bool fits = size <= PIPE_DATA_MAX && pipe_used(q) + pipe_frame_size(0, size) <= QUEUE_BYTES;
        if (fits) wire_lcm_encode(m, pipe_put(q, PIPE_MESSAGE, "", size), size);
        metric_count(fits ? l->messages_out : l->out_dropped, 1);
    }
    pthread_mutex_unlock(&lock);
}

static void memory_flush(struct link *head)
{
    (void)head; /* publish has put it into the queues */
}

static void memory_stream_open(struct link *head, const char *stream, int64_t client)
{
    (void)client;
    opened_add(&link_memory_of(head)->streams, stream);
    wake(head->options.wake_fd);
}

static void memory_stream_close(struct link *head, const char *stream)
{
    (void)head; /* nothing is kept for a stream */
    (void)stream;
}

static void memory_describe(struct link *head, char *text, size_t size)
{
    snprintf(text, size, "memory %s: this process", head->options.address);
}

static void memory_close(struct link *head)
{
    link_memory *l = link_memory_of(head);
    pthread_mutex_lock(&lock);
    size_t i = 0;
    while (hubs.at[i] != l) i++;
    hubs.at[i] = hubs.at[--hubs.count];
    if (hubs.count == 0) array_free(&hubs);
    for (i = 0; i < l->ends.count; i++) l->ends.at[i]->hub = NULL;
    while (l->offers) pthread_cond_wait(&offered, &lock);
    pthread_mutex_unlock(&lock);
    array_free(&l->ends);
    pipe_free(&l->incoming);
    pipe_free(&l->taken);
    array_free(&l->rest);
    opened_free(&l->streams);
    wire_memory_destroy(l->memory);
}

const link_ops link_memory_ops = {
    .scheme = "memory",
    .size = sizeof(link_memory),
    .has_liveliness = false,
    .acknowledges = true,
    .check = memory_check,
    .open = memory_open,
    .receive = memory_take_all,
    .receive_poses = memory_take_all,
    .publish = memory_publish,
    .flush = memory_flush,
    .stream_open = memory_stream_open,
    .stream_close = memory_stream_close,
    .describe = memory_describe,
    .close = memory_close,
};
