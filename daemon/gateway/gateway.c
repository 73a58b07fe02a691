/* collided-lcm: LCM in a process of its own. It subscribes to what clients send, hands over only messages that our own
 * decoder has checked, as the same bytes, and publishes what the daemon writes. The daemon starts it, with the pipe on
 * descriptor 3; when the pipe ends, it ends. It may be killed at any time: it keeps nothing.
 *
 * Threads: this one, and liblcm's, which receives into liblcm's own queue. */
#include "confine.h"

#include "pipe/pipe.h"
#include "wire/wire_lcm.h"

#include <lcm/lcm.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum {
    LCM_QUEUE = 10000,         /* messages; liblcm's 30 lose most of a burst */
    TO_DAEMON_BYTES = 16 << 20 /* beyond, liblcm's queue waits until the daemon has read */
};

typedef struct gateway {
    lcm_t *lcm;
    wire_memory *memory;
    pipe_buffer to_daemon;
    pipe_buffer from_daemon;
    time_t drops_reported_s;
    uint32_t drops; /* datagrams that the daemon was told of */
} gateway;

static void refuse(gateway *g, const wire_message *m, wire_kind kind, const wire_refusal *why)
{
    pipe_refusal r = {.kind = (int32_t)kind, .reason = (int32_t)why->reason};
    int32_t object;
    wire_origin(m, &r.client, &r.sequence, &object);
    memcpy(r.text, why->text, sizeof r.text);
    pipe_put_refusal(&g->to_daemon, &r);
}

/* liblcm takes the length of a message from what a stranger wrote (datagram_filter.c): a negative one comes as 4 GB, of
 * which nothing is read here. */
static bool length_can_be(const lcm_recv_buf_t *received, const char *channel, wire_refusal *why)
{
    bool possible = received->data && received->data_size <= PIPE_DATA_MAX && strlen(channel) <= PIPE_CHANNEL_MAX;
    if (possible) return true;
    why->reason = WIRE_MALFORMED;
    snprintf(why->text, sizeof why->text, "a datagram whose message would have %u bytes", received->data_size);
    return false;
}

/* liblcm calls this from lcm_handle. What follows decodes is not trusted: see the daemon, which decodes again. */
static void on_message(const lcm_recv_buf_t *received, const char *channel, void *context)
{
    gateway *g = context;
    wire_message m = {0};
    wire_refusal why = {0};
    wire_memory_reset(g->memory);
    if (!length_can_be(received, channel, &why))
        refuse(g, &m, WIRE_NOTHING, &why);
    else if (wire_lcm_decode(received->data, received->data_size, g->memory, &m, &why) == WIRE_OK)
        memcpy(
            pipe_put(&g->to_daemon, PIPE_MESSAGE, channel, received->data_size), received->data, received->data_size);
    else
        refuse(g, &m, wire_lcm_kind(received->data, received->data_size), &why);
}

/* False: what came is no frame. */
static bool publish_what_came(gateway *g)
{
    pipe_frame f;
    int got;
    while ((got = pipe_take(&g->from_daemon, &f)) == 1) {
        char channel[PIPE_CHANNEL_MAX + 1];
        memcpy(channel, f.channel, f.channel_length);
        channel[f.channel_length] = '\0';
        if (lcm_publish(g->lcm, channel, f.data, (unsigned)f.size) != 0)
            fprintf(stderr, "collided-lcm: %s: %zu bytes were not sent: %m\n", channel, f.size);
    }
    return got == 0;
}

/* Once a second, as far as anything wakes us: the daemon's Status does. */
static void report_of_drops(gateway *g)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
    if (now.tv_sec == g->drops_reported_s) return;
    g->drops_reported_s = now.tv_sec;
    uint32_t drops = confine_drops(), more = drops - g->drops;
    g->drops = drops;
    if (more) memcpy(pipe_put(&g->to_daemon, PIPE_DROPPED, "", sizeof more), &more, sizeof more);
}

/* Until the pipe ends. */
static void serve(gateway *g)
{
    struct pollfd p[] = {{.fd = PIPE_FD}, {.fd = lcm_get_fileno(g->lcm), .events = POLLIN}};
    for (;;) {
        bool full = pipe_used(&g->to_daemon) > TO_DAEMON_BYTES;
        p[0].events = (short)(POLLIN | (pipe_used(&g->to_daemon) ? POLLOUT : 0));
        if (poll(p, full ? 1 : 2, -1) < 0) continue;
        if (p[0].revents && pipe_read(&g->from_daemon, PIPE_FD) < 0) return;
        if (!publish_what_came(g)) return;
        if (!full && (p[1].revents & POLLIN)) lcm_handle(g->lcm);
        report_of_drops(g);
        if (!pipe_send(&g->to_daemon, PIPE_FD)) return;
    }
}

static bool start_lcm(gateway *g, const char *url, const char *interface)
{
    if (!confine_route_is(url, interface) || !confine_port_is_free(url)) return false;
    g->lcm = lcm_create(url);
    if (!g->lcm) return false;
    lcm_subscription_t *s = lcm_subscribe(g->lcm, "collided\\.in\\..*", on_message, g);
    if (!s) return false;
    lcm_subscription_set_queue_capacity(s, LCM_QUEUE);
    return confine_sockets(interface);
}

int main(int argc, char **argv)
{
    if (argc != 3) {
        fprintf(stderr, "collided-lcm is started by collided: collided-lcm udpm://ADDRESS:PORT?OPTIONS INTERFACE\n");
        return PIPE_EXIT_USAGE;
    }
    signal(SIGINT, SIG_IGN); /* ends with the daemon's pipe, after the last words have passed, not before */
    signal(SIGTERM, SIG_IGN);
    confine_process();
    gateway g = {.memory = wire_memory_create()};
    bool started = start_lcm(&g, argv[1], argv[2]);
    if (started) {
        confine_growth();
        pipe_put(&g.to_daemon, PIPE_READY, "", 0);
        serve(&g);
    } else {
        fprintf(stderr, "collided-lcm: %s: LCM did not start\n", argv[1]);
    }
    if (g.lcm) lcm_destroy(g.lcm);
    pipe_free(&g.to_daemon);
    pipe_free(&g.from_daemon);
    wire_memory_destroy(g.memory);
    return started ? EXIT_SUCCESS : PIPE_EXIT_NETWORK;
}
