/* link_pipe: frames in, frames out, never waiting. One thread, the tick thread. */
#include "link_pipe.h"

#include "incoming.h"
#include "opened.h"
#include "pipe/pipe.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

typedef enum pipe_way { WAY_CONTROL, WAY_STREAMS, WAYS = LINK_PIPE_FDS } pipe_way;

typedef struct link_pipe {
    struct link head;
    int fds[WAYS];
    pipe_buffer in, out[WAYS];
    opened streams;
    wire_memory *memory;
    bool gone;
    metric *messages_in, *refused, *messages_out;
} link_pipe;

static link_pipe *link_pipe_of(struct link *l)
{
    return (link_pipe *)l;
}

static const link_pipe *link_pipe_at(const struct link *l)
{
    return (const link_pipe *)l;
}

/* It is no link of a configuration: the descriptors are whoever's who started this process. */
static int link_pipe_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    (void)key;
    snprintf(why, why_size, "pipe://%.40s: only a replay is served through a pipe (--replay_pipe)", options->address);
    return EX_CONFIG;
}

static int link_pipe_open(struct link *head, const link_options *options, char *why, size_t why_size)
{
    link_pipe *l = link_pipe_of(head);
    char *end, *last = NULL;
    long a = strtol(options->address, &end, 10), b = *end == ',' ? strtol(end + 1, &last, 10) : -1;
    if (!last || *last || a < 3 || b < 3 || a > INT_MAX || b > INT_MAX) {
        snprintf(why, why_size, "pipe://%.40s: two descriptors are wanted, as in pipe://3,4", options->address);
        return -1;
    }
    l->fds[WAY_CONTROL] = (int)a;
    l->fds[WAY_STREAMS] = (int)b;
    l->memory = wire_memory_create();
    l->messages_in = metrics_add(options->counters, "pipe_messages_in", "messages of the observer of this replay");
    l->refused = metrics_add(options->counters, "pipe_refused", "messages of the observer that were refused");
    l->messages_out = metrics_add(options->counters, "pipe_messages_out", "messages published to the observer");
    return 0;
}

static void take_whole(link_pipe *l, const link_sink *sink, const pipe_frame *f)
{
    incoming_part part = {.whole = false};
    while (!part.whole) {
        bool was = incoming_some(&l->head, sink, l->memory, f->data, f->size, &part);
        metric_count(was ? l->messages_in : l->refused, 1);
    }
}

static size_t link_pipe_receive(struct link *head, const link_sink *sink)
{
    link_pipe *l = link_pipe_of(head);
    size_t count = 0;
    opened_report(&l->streams, head, sink);
    for (int64_t n = 1; n > 0 && !l->gone;) {
        pipe_frame f;
        int got;
        n = pipe_read(&l->in, l->fds[WAY_CONTROL]);
        for (; (got = pipe_take(&l->in, &f)) == 1; count++) take_whole(l, sink, &f);
        l->gone |= n < 0 || got < 0;
    }
    return count;
}

static void link_pipe_publish(struct link *head, const wire_message *m)
{
    link_pipe *l = link_pipe_of(head);
    size_t size = wire_lcm_size(m);
    pipe_way way = m->kind == WIRE_EVENT_BATCH || m->kind == WIRE_ANSWER ? WAY_STREAMS : WAY_CONTROL;
    if (l->gone) return;
    wire_lcm_encode(m, pipe_put(&l->out[way], PIPE_MESSAGE, "", size), size);
    metric_count(l->messages_out, 1);
}

static void link_pipe_flush(struct link *head)
{
    link_pipe *l = link_pipe_of(head);
    for (int way = 0; way < WAYS; way++)
        if (!pipe_send(&l->out[way], l->fds[way])) l->gone = true;
}

static void link_pipe_stream_open(struct link *head, const char *stream, int64_t client)
{
    (void)client;
    opened_add(&link_pipe_of(head)->streams, stream);
}

static void link_pipe_stream_close(struct link *head, const char *stream)
{
    (void)head; /* nothing is kept for a stream */
    (void)stream;
}

static void link_pipe_describe(struct link *head, char *text, size_t size)
{
    snprintf(text, size, "pipe %s: the observer of this replay", head->options.address);
}

static void link_pipe_close(struct link *head)
{
    link_pipe *l = link_pipe_of(head);
    for (int way = 0; way < WAYS; way++) {
        close(l->fds[way]);
        pipe_free(&l->out[way]);
    }
    pipe_free(&l->in);
    opened_free(&l->streams);
    wire_memory_destroy(l->memory);
}

void link_pipe_poll(const struct link *head, struct pollfd *fds)
{
    const link_pipe *l = link_pipe_at(head);
    for (int way = 0; way < WAYS; way++)
        fds[way] = (struct pollfd){.fd = l->fds[way],
            .events = (short)((way == WAY_CONTROL ? POLLIN : 0) | (pipe_used(&l->out[way]) ? POLLOUT : 0))};
}

size_t link_pipe_waiting(const struct link *head)
{
    const link_pipe *l = link_pipe_at(head);
    return pipe_used(&l->out[WAY_CONTROL]) + pipe_used(&l->out[WAY_STREAMS]);
}

bool link_pipe_is_gone(const struct link *head)
{
    return link_pipe_at(head)->gone;
}

const link_ops link_pipe_ops = {
    .scheme = "pipe",
    .size = sizeof(link_pipe),
    .has_liveliness = true, /* its client lives as long as the pipe */
    .acknowledges = false,
    .loses_nothing = true,
    .check = link_pipe_check,
    .open = link_pipe_open,
    .receive = link_pipe_receive,
    .receive_poses = link_pipe_receive,
    .publish = link_pipe_publish,
    .flush = link_pipe_flush,
    .stream_open = link_pipe_stream_open,
    .stream_close = link_pipe_stream_close,
    .describe = link_pipe_describe,
    .close = link_pipe_close,
};
