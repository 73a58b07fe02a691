/* transport_lcm: LCM over UDP multicast. Nothing keeps what was sent, so the session repeats it. Each role has an LCM
 * instance of its own, hence a receiving thread (liblcm's) and a descriptor of its own.
 *
 * What arrives is decoded by wire_lcm_decode, which is safe against any bytes. liblcm 1.3.1 itself is not: one crafted
 * fragment on a subscribed channel can end this process while liblcm puts it together. LCM has no security; it is for
 * networks on which every host is trusted. The daemon keeps LCM in a process of its own for that reason. */
#include "allocate.h"
#include "transport.h"
#include "wire/wire_lcm.h"

#include <ctype.h>
#include <lcm/lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LCM_URI_MAX = 256, LCM_QUEUE = 4096 /* messages; liblcm's default of 30 loses most of a burst */ };
/* A datagram carries 65,499 bytes unfragmented, and a pose takes up to 108: what is lost is lost alone. */
enum { LCM_POSES = 600 };

typedef struct lcm_receiver {
    lcm_t *lcm;
    wire_memory *memory;
    const transport_sink *sink; /* during receive */
} lcm_receiver;

typedef struct lcm_stream {
    char channel[WIRE_CHANNEL_MAX];
    lcm_subscription_t *subscription;
} lcm_stream;

typedef struct transport_lcm {
    transport head;
    lcm_receiver receivers[TRANSPORT_ROLES];
    lcm_stream *streams;
    size_t stream_count, stream_capacity;
    unsigned char *out;
    size_t out_capacity;
} transport_lcm;

static void received(const lcm_recv_buf_t *buffer, const char *channel, void *context)
{
    (void)channel;
    lcm_receiver *r = context;
    wire_message m;
    wire_refusal why;
    wire_memory_reset(r->memory);
    if (wire_lcm_decode(buffer->data, buffer->data_size, r->memory, &m, &why) == WIRE_OK)
        r->sink->message(r->sink->context, &m);
    else
        r->sink->refused(r->sink->context, &why);
}

/* liblcm takes channels for regular expressions; ours are names. */
static lcm_subscription_t *lcm_open_channel(lcm_receiver *r, const char *channel)
{
    char pattern[2 * WIRE_CHANNEL_MAX + 1];
    size_t at = 0;
    for (const char *c = channel; *c; c++) {
        if (!isalnum((unsigned char)*c)) pattern[at++] = '\\';
        pattern[at++] = *c;
    }
    pattern[at] = '\0';
    lcm_subscription_t *s = lcm_subscribe(r->lcm, pattern, received, r);
    if (s) (void)lcm_subscription_set_queue_capacity(s, LCM_QUEUE);
    return s;
}

static bool subscribe_kind(lcm_receiver *r, wire_kind kind, int64_t client)
{
    wire_message m = {.kind = kind};
    char channel[WIRE_CHANNEL_MAX];
    if (kind == WIRE_ANSWER) m.answer.client = client;
    if (kind == WIRE_ACK) m.ack.client = client;
    if (kind == WIRE_REJECT) m.reject.client = client;
    wire_lcm_channel(&m, channel);
    return lcm_open_channel(r, channel) != NULL;
}

/* What the URI does not say stays on this machine, with buffers for a burst. False if it does not fit. */
static bool provider(const char *address, char uri[LCM_URI_MAX])
{
    const char *base = address[0] ? address : "udpm://239.255.76.67:7667";
    const char *ttl = strstr(base, "ttl=") ? "" : "ttl=0";
    const char *buffer = strstr(base, "recv_buf_size=") ? "" : "recv_buf_size=4194304";
    const char *first = strchr(base, '?') ? "&" : "?";
    const char *second = *ttl ? "&" : first;
    int n = snprintf(uri, LCM_URI_MAX, "%s%s%s%s%s", base, *ttl ? first : "", ttl, *buffer ? second : "", buffer);
    return n > 0 && n < LCM_URI_MAX;
}

static void lcm_close(transport *base)
{
    transport_lcm *t = (transport_lcm *)base;
    for (int role = 0; role < TRANSPORT_ROLES; role++) {
        if (t->receivers[role].lcm) lcm_destroy(t->receivers[role].lcm);
        if (t->receivers[role].memory) wire_memory_destroy(t->receivers[role].memory);
    }
    free(t->streams);
    free(t->out);
    free(t);
}

static bool open_receiver(transport_lcm *t, transport_role role, const char *uri)
{
    lcm_receiver *r = &t->receivers[role];
    r->memory = wire_memory_create();
    r->lcm = lcm_create(uri);
    return r->memory && r->lcm;
}

static transport *lcm_open(const transport_options *options, char *why, size_t why_size)
{
    char uri[LCM_URI_MAX];
    if (!provider(options->address, uri)) {
        (void)snprintf(why, why_size, "lcm: the address is longer than %d bytes", LCM_URI_MAX - 64);
        return NULL;
    }
    transport_lcm *t = allocate(1, sizeof *t);
    t->head.ops = &transport_lcm_ops;
    lcm_receiver *control = &t->receivers[TRANSPORT_CONTROL], *streams = &t->receivers[TRANSPORT_STREAMS];
    bool opened =
        open_receiver(t, TRANSPORT_CONTROL, uri) && open_receiver(t, TRANSPORT_STREAMS, uri) &&
        subscribe_kind(control, WIRE_STATUS, options->client) && subscribe_kind(control, WIRE_ACK, options->client) &&
        subscribe_kind(control, WIRE_REJECT, options->client) && subscribe_kind(streams, WIRE_ANSWER, options->client);
    if (opened) return &t->head;
    (void)snprintf(why, why_size,
        "lcm: cannot open %s; is the address a multicast address, and is there a route for it (ip route add "
        "224.0.0.0/4 dev lo)?",
        uri);
    lcm_close(&t->head);
    return NULL;
}

static int lcm_send(transport *base, const wire_message *m)
{
    transport_lcm *t = (transport_lcm *)base;
    size_t size = wire_lcm_size(m);
    t->out = reserve(t->out, &t->out_capacity, size, 1);
    size = wire_lcm_encode(m, t->out, t->out_capacity);
    char channel[WIRE_CHANNEL_MAX];
    wire_lcm_channel(m, channel);
    if (!size) return -1;
    return lcm_publish(t->receivers[TRANSPORT_CONTROL].lcm, channel, t->out, (unsigned)size) == 0 ? 0 : -1;
}

static void lcm_flush(transport *base)
{
    (void)base;
} /* lcm_publish sends at once */

static void lcm_drain(transport *base, int64_t timeout_ns) /* nobody tells what arrived */
{
    (void)base;
    (void)timeout_ns;
}

static bool lcm_ready(transport *base) /* there is nothing to match */
{
    (void)base;
    return true;
}

static int lcm_fd(transport *base, transport_role role)
{
    return lcm_get_fileno(((transport_lcm *)base)->receivers[role].lcm);
}

static void lcm_receive(transport *base, transport_role role, const transport_sink *sink)
{
    lcm_receiver *r = &((transport_lcm *)base)->receivers[role];
    r->sink = sink;
    while (lcm_handle_timeout(r->lcm, 0) > 0) continue;
    r->sink = NULL;
}

static int lcm_stream_open(transport *base, const char *stream)
{
    transport_lcm *t = (transport_lcm *)base;
    lcm_stream s;
    wire_lcm_stream_channel(stream, s.channel);
    s.subscription = lcm_open_channel(&t->receivers[TRANSPORT_STREAMS], s.channel);
    if (!s.subscription) return -1;
    t->streams = reserve(t->streams, &t->stream_capacity, t->stream_count + 1, sizeof *t->streams);
    t->streams[t->stream_count++] = s;
    return 0;
}

static void lcm_stream_close(transport *base, const char *stream)
{
    transport_lcm *t = (transport_lcm *)base;
    char channel[WIRE_CHANNEL_MAX];
    wire_lcm_stream_channel(stream, channel);
    for (size_t i = 0; i < t->stream_count; i++) {
        if (strcmp(t->streams[i].channel, channel) != 0) continue;
        (void)lcm_unsubscribe(t->receivers[TRANSPORT_STREAMS].lcm, t->streams[i].subscription);
        t->streams[i] = t->streams[--t->stream_count];
        return;
    }
}

const transport_ops transport_lcm_ops = {
    .scheme = "lcm",
    .repeats = true,
    .poses_max = LCM_POSES,
    .open = lcm_open,
    .send = lcm_send,
    .flush = lcm_flush,
    .drain = lcm_drain,
    .ready = lcm_ready,
    .fd = lcm_fd,
    .receive = lcm_receive,
    .stream_open = lcm_stream_open,
    .stream_close = lcm_stream_close,
    .close = lcm_close,
};
