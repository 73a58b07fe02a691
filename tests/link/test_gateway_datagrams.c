/* What a stranger can send to the port of LCM: datagrams of every kind of message, whole and in fragments, mutated in
 * header, channel and data, to the real collided-lcm. It must live through all of them, hand over only what our decoder
 * takes, and go on to hear who sends well-formed messages. 10^6 datagrams with COLLIDED_NIGHTLY=1, or as many as
 * COLLIDED_DATAGRAMS says; COLLIDED_SEED repeats a run. */
#include "link/gateway_process.h"
#include "pipe/pipe.h"
#include "sample.h"

#include <arpa/inet.h>
#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

enum {
    PORT = 7667,
    DATAGRAM_MAX = 65507,
    SHORT_HEAD = 8,
    FRAGMENT_HEAD = 20,
    BURST_DATAGRAMS = 100, /* and bytes: what the smallest of the kernel's buffers holds */
    BURST_BYTES = 60000,
    CI_DATAGRAMS = 60000,
    NIGHTLY_DATAGRAMS = 1000000,
    FRAGMENTS_MOST = 5,
    AT_BODIES = 52,     /* how many, in the data of a PoseBatch: behind fingerprint, version and five numbers */
    RING_TWICE = 20000, /* datagrams as large as the marker */
    PATIENCE_MS = 30000
};

bool netns_enter(void); /* netns.c; harness.h has names that sample.h has as well */
bool netns_multicast_route(bool on);
static bool isolated;

typedef struct rig {
    sampler sampler;
    wire_memory *memory;
    int out, pipe, words;
    pid_t gateway;
    pipe_buffer from_gateway, to_gateway;
    int64_t marker; /* sequence of the last marker that came */
    size_t messages, refusals;
    uint32_t drops, number;
    size_t burst_count, burst_bytes, marker_size;
} rig;

static uint64_t below(rig *r, uint32_t bound)
{
    return sample_below(&r->sampler, bound);
}

/* ---- the gateway ---- */

static void take_frame(rig *r, const pipe_frame *f)
{
    wire_message m;
    wire_refusal why;
    pipe_refusal refusal;
    uint32_t more = 0;
    wire_memory_reset(r->memory);
    switch (f->kind) {
    case PIPE_MESSAGE:
        assert_int_equal(wire_lcm_decode(f->data, f->size, r->memory, &m, &why), WIRE_OK);
        if (m.kind == WIRE_CLIENT && m.client.client == INT64_MAX) r->marker = m.client.sequence;
        r->messages++;
        break;
    case PIPE_REFUSAL:
        assert_true(pipe_get_refusal(f, &refusal));
        assert_true(refusal.text[0]);
        r->refusals++;
        break;
    case PIPE_DROPPED:
        assert_int_equal(f->size, sizeof more);
        memcpy(&more, f->data, sizeof more);
        r->drops += more;
        break;
    default:
        break;
    }
}

/* False: it has ended, or does not speak in frames. */
static bool take_frames(rig *r, int timeout_ms)
{
    struct pollfd p[] = {{.fd = r->pipe, .events = POLLIN}, {.fd = r->words, .events = POLLIN}};
    char words[512];
    pipe_frame f;
    int got;
    if (poll(p, 2, timeout_ms) <= 0) return true;
    if (p[1].revents & POLLIN) {
        ssize_t n = read(r->words, words, sizeof words);
        if (n > 0) printf("%.*s", (int)n, words);
    }
    if (!p[0].revents) return true;
    if (pipe_read(&r->from_gateway, r->pipe) < 0) return false;
    while ((got = pipe_take(&r->from_gateway, &f)) == 1) take_frame(r, &f);
    return got == 0;
}

static void assert_alive(rig *r, bool alive)
{
    char how[128];
    if (alive) return;
    gateway_end(r->gateway, 1000, how, sizeof how);
    fail_msg("collided-lcm has ended behind datagram %u: %s", r->number, how);
}

/* ---- sending ---- */

static void put32(uint8_t *at, uint32_t value)
{
    value = htonl(value);
    memcpy(at, &value, sizeof value);
}

static void put16(uint8_t *at, uint16_t value)
{
    value = htons(value);
    memcpy(at, &value, sizeof value);
}

static void send_datagram(rig *r, const uint8_t *bytes, size_t size)
{
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(PORT)};
    inet_pton(AF_INET, "239.255.76.67", &to.sin_addr);
    assert_int_equal(sendto(r->out, bytes, size, 0, (const struct sockaddr *)&to, sizeof to), size);
    r->number++;
    r->burst_count++;
    r->burst_bytes += size;
}

static size_t short_datagram(rig *r, uint8_t *out, const char *channel, const uint8_t *data, size_t size)
{
    size_t name = strlen(channel) + 1;
    put32(out, 0x4c433032);
    put32(out + 4, r->number);
    memcpy(out + SHORT_HEAD, channel, name);
    if (size) memcpy(out + SHORT_HEAD + name, data, size);
    return SHORT_HEAD + name + size;
}

static void send_marker(rig *r, int64_t sequence)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = INT64_MAX,
            .sequence = sequence,
            .lease_ns = INT64_C(1000000000),
            .name = "the marker: a message that is well-formed"}};
    uint8_t data[512], out[1024];
    size_t size = wire_lcm_encode(&m, data, sizeof data);
    assert_true(size > 0);
    r->marker_size = short_datagram(r, out, "collided.in.Client", data, size);
    send_datagram(r, out, r->marker_size);
}

/* Until a well-formed message is through that was sent behind all the others: none of them has ended the gateway. */
static void end_burst(rig *r)
{
    static int64_t sequence;
    sequence++;
    struct timespec begin, now;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (int wait_ms = 20; r->marker != sequence; wait_ms = wait_ms < 500 ? 2 * wait_ms : wait_ms) {
        send_marker(r, sequence);
        for (int waited = 0; r->marker != sequence && waited < wait_ms; waited += 5) assert_alive(r, take_frames(r, 5));
        clock_gettime(CLOCK_MONOTONIC, &now);
        if ((now.tv_sec - begin.tv_sec) * 1000 > PATIENCE_MS) fail_msg("nothing comes behind datagram %u", r->number);
    }
    r->burst_count = r->burst_bytes = 0;
}

/* ---- datagrams that are none ---- */

static const char *some_channel(rig *r, wire_kind kind)
{
    static char channel[512];
    switch (below(r, 12)) {
    case 0: /* of any length */
        strcpy(channel, "collided.in.");
        for (size_t at = strlen(channel), end = at + below(r, 120); at < end; channel[++at] = '\0')
            channel[at] = (char)(1 + below(r, 255));
        return channel;
    case 1:
        return "collided.in.";
    case 2:
        return "";
    case 3:
        return "somebody.else";
    default:
        snprintf(channel, sizeof channel, "collided.in.%s", wire_kind_name(kind));
        return channel;
    }
}

static void change_bytes(rig *r, uint8_t *bytes, size_t size)
{
    static const uint8_t edges[] = {0, 1, 0x7f, 0x80, 0xff};
    for (uint64_t n = below(r, 6); n && size; n--) {
        size_t near = below(r, 2) ? size : size < 96 ? size : 96; /* heads and counts stand in front */
        uint8_t *at = &bytes[below(r, (uint32_t)near)];
        *at = below(r, 2) ? edges[below(r, sizeof edges)] : (uint8_t)below(r, 256);
    }
}

static uint32_t some_size(rig *r, uint32_t right)
{
    static const uint32_t edges[] = {0, 1, 65487, 65535, 65536, 1 << 24, (1 << 24) + 1, 1 << 28, INT32_MAX, 0x80000000,
        UINT32_MAX - 511, UINT32_MAX};
    switch (below(r, 6)) {
    case 0:
        return edges[below(r, sizeof edges / sizeof *edges)];
    case 1:
        return right + (uint32_t)below(r, 65) - 32;
    case 2:
        return (uint32_t)sample_next(&r->sampler);
    default:
        return right;
    }
}

static void send_short(rig *r, const char *channel, const uint8_t *data, size_t size)
{
    static uint8_t bytes[DATAGRAM_MAX];
    size_t whole = short_datagram(r, bytes, channel, data, size);
    change_bytes(r, bytes + (below(r, 4) ? SHORT_HEAD : 0), whole - SHORT_HEAD);
    if (below(r, 2)) whole = below(r, 2) ? below(r, (uint32_t)whole + 1) : below(r, 64); /* within the channel, often */
    if (whole > DATAGRAM_MAX) whole = DATAGRAM_MAX;
    send_datagram(r, bytes, whole);
}

/* As liblcm cuts a message up, with what is wrong in one fragment or in none. */
static void send_fragments(rig *r, const char *channel, const uint8_t *data, size_t size)
{
    static uint8_t bytes[DATAGRAM_MAX];
    size_t name = strlen(channel) + 1, all = name + size;
    uint16_t count = (uint16_t)(1 + below(r, FRAGMENTS_MOST));
    size_t share = (all + count - 1) / count + below(r, 3);
    uint32_t message = r->number;
    for (uint16_t i = 0; i < count; i++) {
        size_t from = share * i < all ? share * i : all, to = from + share < all ? from + share : all;
        uint32_t offset = from < name ? 0 : (uint32_t)(from - name);
        put32(bytes, 0x4c433033);
        put32(bytes + 4, below(r, 20) ? message : message - 1);
        put32(bytes + 8, some_size(r, (uint32_t)size));
        put32(bytes + 12, some_size(r, offset));
        put16(bytes + 16, (uint16_t)(below(r, 12) ? i : below(r, 65536)));
        put16(bytes + 18, (uint16_t)(below(r, 12) ? count : below(r, 65536)));
        for (size_t k = from; k < to; k++)
            bytes[FRAGMENT_HEAD + k - from] = k < name ? (uint8_t)channel[k] : data[k - name];
        size_t whole = FRAGMENT_HEAD + to - from;
        if (!below(r, 4)) change_bytes(r, bytes + FRAGMENT_HEAD, to - from);
        if (!below(r, 12)) whole = below(r, (uint32_t)whole + 1);
        if (below(r, 12)) send_datagram(r, bytes, whole);
        if (!below(r, 12)) send_datagram(r, bytes, whole); /* twice */
    }
}

static void send_something(rig *r)
{
    static uint8_t data[DATAGRAM_MAX];
    wire_kind kind = (wire_kind)(1 + below(r, WIRE_KIND_COUNT - 1));
    wire_message m = sample_message(&r->sampler, kind, 1 + (uint32_t)below(r, 8));
    const char *channel = some_channel(r, kind);
    size_t size = wire_lcm_encode(&m, data, sizeof data - SHORT_HEAD - 256);
    wire_memory_reset(r->sampler.memory);
    if (below(r, 3))
        send_short(r, channel, data, size);
    else
        send_fragments(r, channel, data, size);
}

/* Bytes of earlier datagrams behind one that ends within its channel: liblcm reads on in them, and gives the message a
 * length of 4 GB. There they claim as many positions as a batch may have. All others have one size, so that those bytes
 * lie where they are read when liblcm's ring of 1 MB has been filled twice. How many were cut short; *whole of the
 * others. */
static uint32_t send_channels_cut_short(rig *r, size_t *whole)
{
    static const char channel[] = "collided.in.PoseBatch";
    uint8_t bytes[1024] = {0}, data[1024] = {0};
    wire_message m = sample_message(&r->sampler, WIRE_POSE_BATCH, 1);
    size_t rest = r->marker_size - SHORT_HEAD - sizeof channel;
    uint32_t cuts = 0;
    assert_true(wire_lcm_encode(&m, data, sizeof data) > AT_BODIES && rest > AT_BODIES + 8);
    put32(data + AT_BODIES, 0);
    put32(data + AT_BODIES + 4, 3 * WIRE_POSES_MAX);
    for (size_t size = SHORT_HEAD; size < SHORT_HEAD + sizeof channel; size += 7, cuts++) {
        for (int i = 0; i < RING_TWICE; i++, ++*whole) {
            send_datagram(r, bytes, short_datagram(r, bytes, channel, data, rest));
            if (r->burst_count == BURST_DATAGRAMS) end_burst(r);
        }
        send_datagram(r, bytes, size);
        end_burst(r);
    }
    return cuts;
}

/* The gateway tells of them once a second, when something wakes it. */
static void await_drops(rig *r, uint32_t least)
{
    for (int i = 0; i < PATIENCE_MS / 50 && r->drops < least; i++) {
        end_burst(r);
        assert_alive(r, take_frames(r, 50));
    }
}

/* ---- the tests ---- */

static void rig_open(rig *r, uint64_t seed)
{
    char why[256];
    char program[GATEWAY_PATH_MAX];
    if (!isolated) skip();
    *r = (rig){.sampler = {.random = seed, .memory = wire_memory_create()}, .memory = wire_memory_create()};
    unsigned char ttl = 0;
    r->out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_int_equal(setsockopt(r->out, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl), 0);
    if (!gateway_program(GATEWAY, program, why, sizeof why)) fail_msg("%s", why);
    r->pipe =
        gateway_start(program, "udpm://239.255.76.67:7667?recv_buf_size=4194304&ttl=0", "", &r->gateway, &r->words);
    assert_true(r->pipe >= 0);
    end_burst(r); /* it runs */
}

static void rig_close(rig *r)
{
    char how[128];
    shutdown(r->pipe, SHUT_WR);
    int status = gateway_end(r->gateway, PATIENCE_MS, how, sizeof how);
    if (status != 0) fail_msg("collided-lcm: %s", how);
    close(r->pipe);
    close(r->words);
    close(r->out);
    pipe_free(&r->from_gateway);
    wire_memory_destroy(r->memory);
    wire_memory_destroy(r->sampler.memory);
}

static uint64_t number_of(const char *variable, uint64_t otherwise)
{
    const char *text = getenv(variable);
    return text ? strtoull(text, NULL, 0) : otherwise;
}

static void mutated_datagrams_end_nothing(void **state)
{
    (void)state;
    rig r;
    uint64_t seed = number_of("COLLIDED_SEED", (uint64_t)time(NULL)),
             most = number_of("COLLIDED_DATAGRAMS", getenv("COLLIDED_NIGHTLY") ? NIGHTLY_DATAGRAMS : CI_DATAGRAMS);
    printf("COLLIDED_SEED=%llu\n", (unsigned long long)seed);
    rig_open(&r, seed);
    while (r.number < most) {
        send_something(&r);
        if (r.burst_count >= BURST_DATAGRAMS || r.burst_bytes >= BURST_BYTES) end_burst(&r);
    }
    await_drops(&r, (uint32_t)(most / 100 + 1));
    printf("%u datagrams: %zu messages, %zu refusals, %u dropped\n", r.number, r.messages, r.refusals, r.drops);
    assert_true(r.messages > most / 100 && r.refusals > most / 100 && r.drops > most / 100);
    rig_close(&r);
}

static void channels_that_are_cut_short_end_nothing(void **state)
{
    (void)state;
    rig r;
    rig_open(&r, 1);
    size_t whole = 0;
    uint32_t cuts = send_channels_cut_short(&r, &whole);
    assert_int_equal(r.refusals, whole); /* what is cut short is not looked at */
    await_drops(&r, cuts);
    assert_int_equal(r.drops, cuts);
    rig_close(&r);
}

int main(void)
{
    isolated = netns_enter() && netns_multicast_route(true);
    signal(SIGPIPE, SIG_IGN);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(channels_that_are_cut_short_end_nothing),
        cmocka_unit_test(mutated_datagrams_end_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
