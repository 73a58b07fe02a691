/* transport_pipe: a daemon at the other end of two socket pairs, which this process holds: collided, replaying a
 * recording for us (daemon/service/replay_served.h). "pipe://A,B": descriptor A for the control role, B for streams;
 * both are closed with the client. Frames: size of the rest (u32, host order), kind (u8), 0 (u8), and a message in
 * LCM's encoding. The daemon reads whatever else it does, so that sending waits for it, and nothing is lost. */
#include "allocate.h"
#include "transport.h"
#include "wire/wire_lcm.h"

#include <errno.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

enum { HEAD = 6, SIZE_BYTES = 4, KIND_MESSAGE = 1, FRAME_MAX = 16 << 20, READ_BYTES = 256 << 10, PIPE_POSES = 65536 };

typedef struct piped { /* one role's descriptor, and what of a frame has come on it */
    int fd;
    bool ended;
    unsigned char *at;
    size_t begin, end, capacity;
    wire_memory *memory;
} piped;

typedef struct transport_pipe {
    transport head;
    piped roles[TRANSPORT_ROLES];
    unsigned char *out;
    size_t out_capacity;
} transport_pipe;

static transport_pipe *pipe_of(transport *t)
{
    return (transport_pipe *)t;
}

static void pipe_close(transport *base)
{
    transport_pipe *t = pipe_of(base);
    for (int role = 0; role < TRANSPORT_ROLES; role++) {
        if (t->roles[role].fd >= 0) close(t->roles[role].fd);
        if (t->roles[role].memory) wire_memory_destroy(t->roles[role].memory);
        free(t->roles[role].at);
    }
    free(t->out);
    free(t);
}

static transport *pipe_open(const transport_options *options, char *why, size_t why_size)
{
    char *end, *last = NULL;
    long a = strtol(options->address, &end, 10), b = *end == ',' ? strtol(end + 1, &last, 10) : -1;
    if (!last || *last || last == end + 1 || a < 0 || b < 0 || a > INT_MAX || b > INT_MAX) {
        (void)snprintf(why, why_size, "pipe://%.40s: two descriptors are wanted, as in pipe://3,4", options->address);
        return NULL;
    }
    transport_pipe *t = allocate(1, sizeof *t);
    t->head.ops = &transport_pipe_ops;
    t->roles[TRANSPORT_CONTROL].fd = (int)a;
    t->roles[TRANSPORT_STREAMS].fd = (int)b;
    for (int role = 0; role < TRANSPORT_ROLES; role++) t->roles[role].memory = wire_memory_create();
    return &t->head;
}

static bool put_all(int fd, const unsigned char *at, size_t size)
{
    while (size) {
        ssize_t n = send(fd, at, size, MSG_NOSIGNAL);
        if (n < 0 && errno == EAGAIN) (void)poll(&(struct pollfd){.fd = fd, .events = POLLOUT}, 1, -1);
        if (n < 0 && errno != EINTR && errno != EAGAIN) return false;
        if (n <= 0) continue;
        at += n;
        size -= (size_t)n;
    }
    return true;
}

static int pipe_send_message(transport *base, const wire_message *m)
{
    transport_pipe *t = pipe_of(base);
    size_t size = wire_lcm_size(m);
    t->out = reserve(t->out, &t->out_capacity, HEAD + size, 1);
    size = wire_lcm_encode(m, t->out + HEAD, t->out_capacity - HEAD);
    uint32_t rest = (uint32_t)(size + HEAD - SIZE_BYTES);
    memcpy(t->out, &rest, SIZE_BYTES);
    t->out[4] = KIND_MESSAGE;
    t->out[5] = 0;
    if (!size || t->roles[TRANSPORT_CONTROL].ended) return -1;
    return put_all(t->roles[TRANSPORT_CONTROL].fd, t->out, HEAD + size) ? 0 : -1;
}

static void pipe_flush(transport *base)
{
    (void)base; /* all has been sent */
}

static void pipe_drain(transport *base, int64_t timeout_ns)
{
    (void)base;
    (void)timeout_ns;
}

static bool pipe_ready(transport *base)
{
    (void)base;
    return true;
}

static int pipe_fd(transport *base, transport_role role)
{
    return pipe_of(base)->roles[role].fd;
}

/* A descriptor that is never readable takes its place: nothing comes any more, and nobody is to be woken for it. */
static void end_role(piped *p)
{
    int never = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (never >= 0) {
        (void)dup2(never, p->fd);
        (void)close(never);
    }
    p->ended = true;
}

static bool read_some(piped *p)
{
    if (p->begin) memmove(p->at, p->at + p->begin, p->end - p->begin);
    p->end -= p->begin;
    p->begin = 0;
    p->at = reserve(p->at, &p->capacity, p->end + READ_BYTES, 1);
    ssize_t n = recv(p->fd, p->at + p->end, p->capacity - p->end, MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) end_role(p);
    if (n <= 0) return false;
    p->end += (size_t)n;
    return true;
}

/* The size of the whole frame at the front, if all of it is there. 0: not yet. */
static size_t front(piped *p)
{
    uint32_t rest;
    if (p->end - p->begin < HEAD) return 0;
    memcpy(&rest, p->at + p->begin, SIZE_BYTES);
    size_t whole = SIZE_BYTES + (size_t)rest;
    bool is_frame = whole >= HEAD && whole <= FRAME_MAX && p->at[p->begin + 4] == KIND_MESSAGE && !p->at[p->begin + 5];
    if (!is_frame) end_role(p);
    return is_frame && p->end - p->begin >= whole ? whole : 0;
}

static void pipe_receive(transport *base, transport_role role, const transport_sink *sink)
{
    piped *p = &pipe_of(base)->roles[role];
    wire_message m;
    wire_refusal why;
    while (!p->ended && read_some(p)) {
        for (size_t whole = 0; !p->ended && (whole = front(p)) > 0; p->begin += whole) {
            wire_memory_reset(p->memory);
            if (wire_lcm_decode(p->at + p->begin + HEAD, whole - HEAD, p->memory, &m, &why) == WIRE_OK)
                sink->message(sink->context, &m);
            else
                sink->refused(sink->context, &why);
        }
    }
}

static int pipe_stream_open(transport *base, const char *stream)
{
    (void)base; /* all streams come on one way, each batch with the name of its own */
    (void)stream;
    return 0;
}

static void pipe_stream_close(transport *base, const char *stream)
{
    (void)base;
    (void)stream;
}

const transport_ops transport_pipe_ops = {
    .scheme = "pipe",
    .repeats = false,
    .poses_max = PIPE_POSES,
    .open = pipe_open,
    .send = pipe_send_message,
    .flush = pipe_flush,
    .drain = pipe_drain,
    .ready = pipe_ready,
    .fd = pipe_fd,
    .receive = pipe_receive,
    .stream_open = pipe_stream_open,
    .stream_close = pipe_stream_close,
    .close = pipe_close,
};
