/* The LCM link and its gateway, over real multicast in a network namespace of the test's own. The client's side is raw
 * UDP written here from LCM's protocol, so that nothing is tested against itself, and no liblcm runs in this process.
 */
#include "harness.h"
#include "link/link_open.h"

#include "link/link_lcm.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { PORT = 7667, DATAGRAM_MAX = 65507, HEADER = 8 };
static const char group_text[] = "239.255.76.67";
static bool isolated;

/* ---- LCM's protocol: magic "LC02", number (big-endian), channel with its NUL, data ---- */

static struct sockaddr_in group(void)
{
    struct sockaddr_in a = {.sin_family = AF_INET, .sin_port = htons(PORT)};
    inet_pton(AF_INET, group_text, &a.sin_addr);
    return a;
}

static int udp_open(bool receiving)
{
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), on = 1;
    unsigned char ttl = 0;
    struct sockaddr_in any = {.sin_family = AF_INET, .sin_port = htons(PORT)};
    struct ip_mreq join = {.imr_multiaddr = group().sin_addr};
    assert_int_equal(setsockopt(fd, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl), 0);
    if (!receiving) return fd;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    setsockopt(fd, SOL_SOCKET, SO_REUSEPORT, &on, sizeof on);
    assert_int_equal(bind(fd, (const struct sockaddr *)&any, sizeof any), 0);
    assert_int_equal(setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &join, sizeof join), 0);
    return fd;
}

static void udp_send(int fd, const void *data, size_t size)
{
    struct sockaddr_in to = group();
    assert_int_equal(sendto(fd, data, size, 0, (const struct sockaddr *)&to, sizeof to), size);
}

static void lcm_send_bytes(int fd, const char *channel, const void *data, size_t size)
{
    static uint32_t number;
    static uint8_t datagram[DATAGRAM_MAX];
    size_t name = strlen(channel) + 1;
    uint32_t head[2] = {htonl(0x4c433032), htonl(number++)};
    assert_true(HEADER + name + size <= sizeof datagram);
    memcpy(datagram, head, HEADER);
    memcpy(datagram + HEADER, channel, name);
    memcpy(datagram + HEADER + name, data, size);
    udp_send(fd, datagram, HEADER + name + size);
}

static void lcm_send(int fd, const wire_message *m)
{
    static uint8_t bytes[DATAGRAM_MAX];
    char channel[WIRE_CHANNEL_MAX];
    wire_lcm_channel(m, channel);
    lcm_send_bytes(fd, channel, bytes, wire_lcm_encode(m, bytes, sizeof bytes));
}

/* A fragment (magic "LC03") whose offset and size wrap around 32 bits: liblcm 1.3.1 writes 4 GB beyond its buffer. */
static void lcm_send_crafted(int fd)
{
    enum { FRAGMENT = 512 };
    static const char channel[] = "collided.in.PoseBatch";
    uint8_t datagram[20 + sizeof channel + FRAGMENT] = {0};
    uint32_t head[4] = {htonl(0x4c433033), htonl(1), htonl(1000), htonl(UINT32_MAX - FRAGMENT / 2 + 1)};
    uint16_t fragments[2] = {htons(0), htons(2)};
    memcpy(datagram, head, sizeof head);
    memcpy(datagram + 16, fragments, sizeof fragments);
    memcpy(datagram + 20, channel, sizeof channel);
    udp_send(fd, datagram, sizeof datagram);
}

/* The data of the next datagram on that channel; 0 when none comes within the time. */
static size_t lcm_receive(int fd, const char *channel, uint8_t *out, size_t size, int timeout_ms)
{
    static uint8_t datagram[DATAGRAM_MAX + 1];
    int64_t end = clock_monotonic_ns() + timeout_ms * INT64_C(1000000);
    for (int64_t left; (left = end - clock_monotonic_ns()) > 0;) {
        struct pollfd p = {.fd = fd, .events = POLLIN};
        if (poll(&p, 1, (int)(left / 1000000) + 1) <= 0) continue;
        ssize_t n = recv(fd, datagram, DATAGRAM_MAX, 0);
        if (n <= HEADER) continue;
        datagram[n] = '\0';
        const char *name = (const char *)datagram + HEADER;
        size_t begin = HEADER + strlen(name) + 1;
        if (strcmp(name, channel) != 0 || (size_t)n - begin > size) continue;
        memcpy(out, datagram + begin, (size_t)n - begin);
        return (size_t)n - begin;
    }
    return 0;
}

/* ---- the rig ---- */

typedef struct cell {
    rig rig;
    int out; /* a client's sockets */
    int in;
} cell;

static int gateway_pid(const cell *c)
{
    return link_lcm_gateway_pid(c->rig.link);
}

static void forget(cell *c)
{
    memset(&c->rig.heard, 0, sizeof c->rig.heard);
}

/* Repeats a message, as clients do, until one comes through: the gateway listens. */
static void until_it_listens(cell *c, double seconds)
{
    wire_message m = sample_message(WIRE_CLIENT);
    int64_t end = clock_monotonic_ns() + (int64_t)(seconds * 1e9);
    while (rig_receive(&c->rig), c->rig.heard.messages[WIRE_CLIENT] == 0) {
        lcm_send(c->out, &m);
        if (rig_wait(&c->rig, end)) fail_msg("the gateway does not listen within %g s", seconds);
    }
}

static void cell_open(cell *c)
{
    if (!isolated) skip();
    *c = (cell){.out = udp_open(false), .in = udp_open(true)};
    rig_open(&c->rig, "lcm://", GATEWAY);
    until_it_listens(c, RIG_PATIENCE_S);
    forget(c);
}

static void cell_close(cell *c)
{
    rig_close(&c->rig);
    close(c->out);
    close(c->in);
}

/* ---- the tests ---- */

static void each_kind_comes_in_unchanged(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    for (wire_kind k = WIRE_CLIENT; k <= WIRE_QUERY; k++) {
        wire_message m = sample_message(k);
        lcm_send(c.out, &m);
    }
    RIG_UNTIL(&c.rig, RIG_PATIENCE_S, c.rig.heard.messages[WIRE_QUERY] >= 1);
    for (wire_kind k = WIRE_GEOMETRY; k <= WIRE_QUERY; k++) assert_int_equal(c.rig.heard.messages[k], 1);
    assert_int_equal(c.rig.heard.differing, 0);
    assert_int_equal(c.rig.heard.refused, 0);
    cell_close(&c);
}

static void each_kind_goes_out_unchanged_on_its_channel(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    for (wire_kind k = WIRE_ANSWER; k < WIRE_KIND_COUNT; k++) {
        static uint8_t bytes[DATAGRAM_MAX], expected[DATAGRAM_MAX];
        char channel[WIRE_CHANNEL_MAX];
        wire_message m = sample_message(k);
        wire_lcm_channel(&m, channel);
        rig_publish(&c.rig, &m);
        size_t size = lcm_receive(c.in, channel, bytes, sizeof bytes, 1000 * (int)RIG_PATIENCE_S);
        assert_int_equal(size, wire_lcm_encode(&m, expected, sizeof expected));
        assert_memory_equal(bytes, expected, size);
    }
    cell_close(&c);
}

static void malformed_messages_are_refused_and_counted(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    uint64_t before = rig_counter(&c.rig, "lcm_refused");
    lcm_send_bytes(c.out, "collided.in.Body", "nonsense", 8);
    RIG_UNTIL(&c.rig, RIG_PATIENCE_S, c.rig.heard.refused == 1);
    assert_int_equal(c.rig.heard.refused_kind, WIRE_NOTHING);
    assert_true(c.rig.heard.why.text[0] != '\0');

    double positions[3] = {0, 0, INFINITY};
    wire_message bad = sample_poses(1, 5);
    bad.pose_batch.positions.at = positions;
    lcm_send(c.out, &bad);
    RIG_UNTIL(&c.rig, RIG_PATIENCE_S, c.rig.heard.refused == 2);
    assert_int_equal(c.rig.heard.refused_kind, WIRE_POSE_BATCH);
    assert_int_equal(c.rig.heard.why.reason, WIRE_BAD_NUMBER);
    assert_int_equal(c.rig.heard.refused_client, CLIENT_ID);
    assert_int_equal(c.rig.heard.refused_sequence, 5);

    wire_message status = sample_message(WIRE_STATUS); /* what only the daemon says */
    static uint8_t bytes[DATAGRAM_MAX];
    lcm_send_bytes(c.out, "collided.in.Body", bytes, wire_lcm_encode(&status, bytes, sizeof bytes));
    RIG_UNTIL(&c.rig, RIG_PATIENCE_S, c.rig.heard.refused == 3);
    assert_int_equal(rig_counter(&c.rig, "lcm_refused") - before, 3);
    assert_int_equal(c.rig.heard.messages[WIRE_BODY] + c.rig.heard.messages[WIRE_STATUS], 0);
    cell_close(&c);
}

/* After its death: another gateway soon (at once; where the network is missing it would be five seconds), counted once,
 * and what follows arrives. */
static void assert_recovers(cell *c, int dead)
{
    int64_t died = clock_monotonic_ns();
    RIG_UNTIL(&c->rig, RIG_PATIENCE_S, gateway_pid(c) != dead && gateway_pid(c) != 0);
    assert_true(clock_monotonic_ns() - died < INT64_C(4000000000));
    assert_int_equal(kill(dead, 0), -1); /* gone, and waited for */
    assert_int_equal(rig_counter(&c->rig, "lcm_gateway_restarts"), 1);
    forget(c);
    until_it_listens(c, RIG_PATIENCE_S);
}

static void a_killed_gateway_is_back_soon(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    int pid = gateway_pid(&c);
    wire_message m = sample_message(WIRE_STATUS);
    char channel[WIRE_CHANNEL_MAX];
    uint8_t bytes[4096];
    wire_lcm_channel(&m, channel);
    assert_int_equal(kill(pid, SIGKILL), 0);
    RIG_UNTIL(&c.rig, RIG_PATIENCE_S, gateway_pid(&c) != pid);
    rig_publish(&c.rig, &m); /* waits for the next one, or is taken by it */
    assert_recovers(&c, pid);
    assert_true(lcm_receive(c.in, channel, bytes, sizeof bytes, 1000 * (int)RIG_PATIENCE_S) > 0);
    cell_close(&c);
}

/* The message before the crafted one arrives, and that behind it, and the gateway counts what it never got. */
static void a_crafted_datagram_is_dropped_and_counted(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    int pid = gateway_pid(&c);
    lcm_send_crafted(c.out);
    wire_message m = sample_message(WIRE_CLIENT);
    RIG_UNTIL(&c.rig, RIG_PATIENCE_S,
        (lcm_send(c.out, &m), rig_counter(&c.rig, "lcm_datagrams_dropped") == 1)); /* it looks when it is woken */
    assert_int_equal(gateway_pid(&c), pid);
    assert_int_equal(rig_counter(&c.rig, "lcm_gateway_restarts"), 0);
    forget(&c);
    until_it_listens(&c, RIG_PATIENCE_S);
    cell_close(&c);
}

static void a_gateway_that_does_not_read_blocks_nobody(void **state)
{
    (void)state;
    enum { BATCHES = 4000, MOST = 100 };
    cell c;
    cell_open(&c);
    int pid = gateway_pid(&c);
    static int64_t values[WIRE_COUNTERS_MAX];
    static const char *names[WIRE_COUNTERS_MAX];
    for (int i = 0; i < WIRE_COUNTERS_MAX; i++) names[i] = "counter";
    wire_message m = sample_message(WIRE_STATUS);
    m.status.counter_names = (wire_strings){WIRE_COUNTERS_MAX, names};
    m.status.counter_values = (wire_i64s){WIRE_COUNTERS_MAX, values};

    assert_int_equal(kill(pid, SIGSTOP), 0);
    int slow = 0; /* a busy machine may let us stand still now and then */
    for (int i = 0; i < BATCHES && rig_counter(&c.rig, "lcm_out_dropped") < MOST; i++) {
        int64_t before = clock_monotonic_ns();
        rig_publish(&c.rig, &m);
        slow += clock_monotonic_ns() - before > INT64_C(500000000);
    }
    assert_true(rig_counter(&c.rig, "lcm_out_dropped") >= MOST);
    assert_true(slow < 5);
    assert_int_equal(gateway_pid(&c), pid);
    assert_int_equal(kill(pid, SIGCONT), 0);
    until_it_listens(&c, RIG_PATIENCE_S);
    cell_close(&c);
}

static void a_tick_that_does_not_come_drops_poses_first_and_counts(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    wire_message poses = sample_poses(1000, 1);
    int64_t end = clock_monotonic_ns() + INT64_C(60000000000);
    while (rig_counter(&c.rig, "lcm_queue_full_poses") == 0 && clock_monotonic_ns() < end) {
        for (int i = 0; i < 4; i++) lcm_send(c.out, &poses);
        usleep(1000); /* the kernel's own buffer is small */
    }
    assert_true(rig_counter(&c.rig, "lcm_queue_full_poses") > 0);
    for (uint64_t before = 0; before != rig_counter(&c.rig, "lcm_queue_full_poses"); usleep(200000))
        before = rig_counter(&c.rig, "lcm_queue_full_poses"); /* until the gateway has handed over all it had */
    assert_int_equal(rig_counter(&c.rig, "lcm_queue_full"), 0);
    forget(&c);
    wire_message body = sample_message(WIRE_BODY);
    for (int i = 0; i < 20; i++) { /* repeated as clients do: the kernel may drop some */
        lcm_send(c.out, &body);
        usleep(5000);
    }
    int tries = 0;
    while (rig_receive(&c.rig), c.rig.heard.messages[WIRE_BODY] == 0) { /* or all of them */
        if (++tries > 600) fail_msg("no body comes through");
        lcm_send(c.out, &body);
        usleep(50000);
    }
    assert_int_equal(rig_counter(&c.rig, "lcm_queue_full"), 0);
    cell_close(&c);
}

/* What waits is more than a round takes: that takes some of it, and of that something of everybody's. */
static void a_flood_of_poses_does_not_stand_before_what_others_say(void **state)
{
    (void)state;
    cell c;
    cell_open(&c);
    wire_message poses = sample_poses(1000, 1), body = sample_message(WIRE_BODY);
    poses.pose_batch.client = CLIENT_ID + 1;
    int64_t end = clock_monotonic_ns() + INT64_C(60000000000);
    while (rig_counter(&c.rig, "lcm_queue_full_poses") == 0 && clock_monotonic_ns() < end) {
        for (int i = 0; i < 4; i++) lcm_send(c.out, &poses);
        usleep(1000);
    }
    assert_true(rig_counter(&c.rig, "lcm_queue_full_poses") > 0);
    for (int tries = 0; c.rig.heard.messages[WIRE_BODY] == 0; tries++) {
        if (tries > 600) fail_msg("no body comes through");
        for (int i = 0; i < 20; i++, usleep(5000)) lcm_send(c.out, &body); /* repeated as clients do */
        size_t before = c.rig.heard.messages[WIRE_POSE_BATCH];
        rig_receive(&c.rig);
        assert_true(c.rig.heard.messages[WIRE_POSE_BATCH] - before < 150); /* of 400 */
    }
    size_t before = c.rig.heard.messages[WIRE_POSE_BATCH];
    /* And the rest comes, if any waits. */
    for (int tries = 0; c.rig.heard.messages[WIRE_POSE_BATCH] == before; tries++) {
        if (tries > 600) fail_msg("no poses come through any more");
        lcm_send(c.out, &poses);
        usleep(50000);
        rig_receive(&c.rig);
    }
    assert_int_equal(rig_counter(&c.rig, "lcm_queue_full"), 0);
    cell_close(&c);
}

static void the_gateway_inherits_nothing_and_may_do_little(void **state)
{
    (void)state;
    if (!isolated) skip();
    int secret = fcntl(0, F_DUPFD, 40); /* not close-on-exec */
    cell c;
    cell_open(&c);
    char path[64], status[4096];
    snprintf(path, sizeof path, "/proc/%d/fd/%d", gateway_pid(&c), secret);
    char target[64];
    assert_int_equal(readlink(path, target, sizeof target), -1);
    assert_int_equal(errno, ENOENT);
    snprintf(path, sizeof path, "/proc/%d/status", gateway_pid(&c));
    FILE *f = fopen(path, "r");
    status[fread(status, 1, sizeof status - 1, f)] = '\0';
    fclose(f);
    assert_non_null(strstr(status, "NoNewPrivs:\t1"));
    close(secret);
    cell_close(&c);
}

static void closing_publishes_the_last_words_and_ends_the_gateway(void **state)
{
    (void)state;
    wire_message m = sample_events("last", 9);
    char channel[WIRE_CHANNEL_MAX];
    uint8_t bytes[4096];
    wire_lcm_channel(&m, channel);
    size_t heard = 0;
    for (int tries = 0; tries < 5 && !heard; tries++) { /* it waits half a second for a gateway that gets no time */
        cell c;
        cell_open(&c);
        int pid = gateway_pid(&c);
        c.rig.link->ops->publish(c.rig.link, &m);
        rig_close(&c.rig);
        heard = lcm_receive(c.in, channel, bytes, sizeof bytes, 1000);
        assert_int_equal(kill(pid, 0), -1);
        close(c.in);
        close(c.out);
    }
    assert_true(heard > 0);
}

static void without_a_route_the_daemon_keeps_running_and_says_so(void **state)
{
    (void)state;
    if (!isolated) skip();
    assert_true(netns_multicast_route(false));
    rig r;
    char text[512] = "";
    rig_open(&r, "lcm://", GATEWAY);
    wire_message m = sample_message(WIRE_STATUS);
    rig_publish(&r, &m);
    RIG_UNTIL(&r, RIG_PATIENCE_S,
        rig_counter(&r, "lcm_out_dropped") == 1); /* the gateway has said that there is no network */
    r.link->ops->describe(r.link, text, sizeof text);
    assert_non_null(strstr(text, "not running"));
    rig_close(&r);
    assert_true(netns_multicast_route(true));
}

static void an_address_that_cannot_be_is_refused_with_the_reason(void **state)
{
    (void)state;
    static const struct {
        const char *uri, *program, *why;
    } cases[] = {
        {"lcm://udpm://239.255.76.67:7667?ttl=1", GATEWAY, "set the interface"},
        {"lcm://memq://", GATEWAY, "expected lcm://udpm://"},
        {"lcm://", "/nowhere/collided-lcm", "not there"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char why[512] = "";
        link_options options = {.counters = NULL, .interface = "", .program = cases[i].program};
        assert_null(link_open(cases[i].uri, &options, why, sizeof why));
        assert_non_null(strstr(why, cases[i].why));
    }
}

int main(void)
{
    isolated = netns_enter() && netns_multicast_route(true);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_kind_comes_in_unchanged),
        cmocka_unit_test(each_kind_goes_out_unchanged_on_its_channel),
        cmocka_unit_test(malformed_messages_are_refused_and_counted),
        cmocka_unit_test(a_killed_gateway_is_back_soon),
        cmocka_unit_test(a_crafted_datagram_is_dropped_and_counted),
        cmocka_unit_test(a_gateway_that_does_not_read_blocks_nobody),
        cmocka_unit_test(a_tick_that_does_not_come_drops_poses_first_and_counts),
        cmocka_unit_test(a_flood_of_poses_does_not_stand_before_what_others_say),
        cmocka_unit_test(the_gateway_inherits_nothing_and_may_do_little),
        cmocka_unit_test(closing_publishes_the_last_words_and_ends_the_gateway),
        cmocka_unit_test(without_a_route_the_daemon_keeps_running_and_says_so),
        cmocka_unit_test(an_address_that_cannot_be_is_refused_with_the_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
