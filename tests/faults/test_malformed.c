/* Malformed datagrams at a running daemon: what a client really sent, over DDS (RTPS) and LCM, is caught on its way,
 * changed at random and sent again, many times. The daemon goes on, and another client, whose numbers steps as it
 * publishes them, is told of each step in time, and of nothing else.
 *
 * 15,000 datagrams a link; ten times as many with COLLIDED_NIGHTLY=1, a third with COLLIDED_BRIEF=1. The seed is random
 * and printed; COLLIDED_SEED sets it. */
#include "rig.h"

#include <arpa/inet.h>
#include <errno.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { CAUGHT_MAX = 512, DATAGRAM_MAX = 65507, BURST = 50, LCM_PORT = 7667, PORTS_MAX = 16, ENOUGH = 150 };

typedef struct datagram {
    uint8_t *bytes;
    size_t size;
    struct sockaddr_in to;
} datagram;

typedef struct trap {
    int raw, out;
    uint64_t random;
    datagram at[CAUGHT_MAX];
    size_t count;
    uint16_t ports[PORTS_MAX]; /* which a daemon listens at: others' are none of ours to disturb */
    size_t port_count;
} trap;

static uint64_t roll(trap *k, uint64_t sides)
{
    uint64_t z = k->random += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return (z ^ (z >> 31)) % sides;
}

/* ---- catching ---- */

/* What a daemon said of itself to all would, changed, harm those who listen, and not the daemon: without certificates
 * nobody can tell who speaks (tests/security). */
static bool is_daemons(const trap *k, uint16_t port)
{
    for (size_t n = 0; n < k->port_count; n++)
        if (k->ports[n] == port) return true;
    return false;
}

static bool is_wanted(const trap *k, const char *uri, uint16_t from, uint16_t port, const uint8_t *data, size_t size)
{
    static const char to_daemon[] = "collided.in.";
    if (strcmp(uri, RIG_DDS) == 0) return is_daemons(k, port) && !is_daemons(k, from);
    return port == LCM_PORT && size > 8 + sizeof to_daemon && memcmp(data + 8, to_daemon, sizeof to_daemon - 1) == 0;
}

static void find_ports(trap *k, pid_t daemon)
{
    char line[512], owner[32];
    snprintf(owner, sizeof owner, "pid=%d,", (int)daemon);
    FILE *f = popen("PATH=$PATH:/usr/bin:/bin ss -Hulnp", "r"); /* NOLINT(cert-env33-c): a fixed line */
    assert_non_null(f);
    while (fgets(line, sizeof line, f)) {
        unsigned port;
        const char *at = strstr(line, owner) ? strchr(line, ':') : NULL;
        if (at && sscanf(at + 1, "%u", &port) == 1 && k->port_count < PORTS_MAX) /* NOLINT(cert-err34-c): ss's own */
            k->ports[k->port_count++] = (uint16_t)port;
    }
    pclose(f);
    assert_true(k->port_count >= 2);
}

/* An IPv4 packet with UDP in it; later ones take the places of earlier ones. */
static void keep(trap *k, const char *uri, const uint8_t *packet, size_t size)
{
    size_t head = size < 28 ? 0 : 4 * (size_t)(packet[0] & 15);
    if (head < 20 || size < head + 8 || packet[9] != IPPROTO_UDP) return;
    uint16_t from = (uint16_t)(packet[head] << 8 | packet[head + 1]);
    uint16_t port = (uint16_t)(packet[head + 2] << 8 | packet[head + 3]);
    if (!is_wanted(k, uri, from, port, packet + head + 8, size - head - 8)) return;
    datagram *d = &k->at[k->count < CAUGHT_MAX ? k->count++ : roll(k, CAUGHT_MAX)];
    free(d->bytes);
    d->size = size - head - 8;
    d->bytes = malloc(d->size ? d->size : 1);
    memcpy(d->bytes, packet + head + 8, d->size);
    d->to = (struct sockaddr_in){.sin_family = AF_INET, .sin_port = htons(port)};
    memcpy(&d->to.sin_addr, packet + 16, 4);
}

/* For that time, and on until there is enough of it. */
static void catch_for(trap *k, const char *uri, double seconds)
{
    static uint8_t packet[DATAGRAM_MAX + 100];
    double begin = rig_now_s();
    while (rig_now_s() < begin + seconds || (k->count <= ENOUGH && rig_now_s() < begin + RIG_PATIENCE_S)) {
        struct sockaddr_ll from;
        socklen_t length = sizeof from;
        ssize_t n = recvfrom(k->raw, packet, sizeof packet, MSG_DONTWAIT, (struct sockaddr *)&from, &length);
        if (n > 0 && from.sll_pkttype != PACKET_OUTGOING) keep(k, uri, packet, (size_t)n);
        if (n <= 0) usleep(500);
    }
}

static void trap_close(trap *k)
{
    for (size_t i = 0; i < k->count; i++) free(k->at[i].bytes);
    if (k->raw > 0) close(k->raw);
    if (k->out > 0) close(k->out);
    *k = (trap){0};
}

static void trap_open(trap *k)
{
    trap_close(k); /* what a failed test left */
    const char *seed = getenv("COLLIDED_SEED");
    k->random = seed ? strtoull(seed, NULL, 10) : (uint64_t)time(NULL) ^ (uint64_t)getpid() << 32;
    printf("COLLIDED_SEED=%llu\n", (unsigned long long)k->random);
    struct sockaddr_ll lo = {
        .sll_family = AF_PACKET, .sll_protocol = htons(ETH_P_IP), .sll_ifindex = (int)if_nametoindex("lo")};
    k->raw = socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC, htons(ETH_P_IP));
    k->out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (k->raw < 0 || bind(k->raw, (struct sockaddr *)&lo, sizeof lo) != 0) {
        printf("skipped: no packets can be caught here: %s\n", strerror(errno));
        skip();
    }
}

/* ---- changing ---- */

static void change_number(trap *k, uint8_t *at)
{
    static const uint32_t ODD[] = {0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0xfffffff0, 0x10000, 0xffff};
    uint32_t number = ODD[roll(k, sizeof ODD / sizeof *ODD)];
    if (roll(k, 2)) number = htonl(number);
    memcpy(at, &number, sizeof number);
}

/* Behind the magic word, mostly: without it nobody reads on. The size may change, too. */
static size_t change(trap *k, const datagram *d, uint8_t *out)
{
    size_t size = d->size;
    memcpy(out, d->bytes, size);
    for (uint64_t i = 1 + roll(k, 4); size > 24 && i-- > 0;) {
        size_t at = roll(k, 16) ? 20 + roll(k, size - 20) : roll(k, size);
        switch (roll(k, 6)) {
        case 0:
            out[at] ^= (uint8_t)(1 << roll(k, 8));
            break;
        case 1:
            out[at] = (uint8_t)roll(k, 256);
            break;
        case 2:
            if (at + 4 <= size) change_number(k, out + (at & ~(size_t)3));
            break;
        case 3:
            size = at;
            break;
        case 4: /* a piece of itself, again */
            memmove(
                out + at, out + roll(k, size), (size - at) / 2 < roll(k, size) ? 0 : 1 + roll(k, (size - at + 1) / 2));
            break;
        default: /* the rest, from another place on */
            if (d->size < DATAGRAM_MAX - size) {
                memcpy(out + size, d->bytes, d->size);
                size += roll(k, d->size);
            }
            break;
        }
    }
    return size;
}

static void send_burst(trap *k)
{
    static uint8_t bytes[2 * DATAGRAM_MAX];
    for (int i = 0; i < BURST; i++) {
        const datagram *d = &k->at[roll(k, k->count)];
        size_t size = change(k, d, bytes);
        if (sendto(k->out, bytes, size, 0, (const struct sockaddr *)&d->to, sizeof d->to) < 0 && errno != EMSGSIZE)
            fail_msg("sendto: %s", strerror(errno));
    }
}

/* ---- those who are there ---- */

/* The other process: it publishes, listens, creates and removes, so that there is something of each kind to trap. */
static int talk(const char *uri)
{
    static heard h;
    collided_def def = collided_def_default();
    def.lease_s = 1;
    collided *c = collided_connect(uri, &def);
    if (!c) return 1;
    collided_body part = rig_box(c, "talker", 50);
    rig_watch(c, &h, "talker");
    for (int64_t step = 1;; step++) {
        rig_move(c, part, 50 + 0.01 * (double)(step % 10), 0);
        collided_body other = step % 10 == 0 ? rig_box(c, "talker too", 50.5) : (collided_body){COLLIDED_NONE};
        collided_result r = {0};
        if (step % 10 == 5) collided_query_bodies(c, "talk*", 0.2, &r);
        collided_result_free(&r);
        collided_poll(c, 0.01);
        if (step % 10 == 0) collided_remove_body(c, other);
    }
}

static void changed_datagrams_disturb_nobody_else(void **state)
{
    const char *uri = *state;
    int bursts = getenv("COLLIDED_NIGHTLY") ? 3000 : getenv("COLLIDED_BRIEF") ? 100 : 300;
    static trap k; /* a test that fails leaves it to be freed by the next */
    heard h;
    pid_t daemon = rig_daemon(NULL, NULL);
    rig_close(rig_connect(RIG_DDS, 2, COLLIDED_REMOVE)); /* it is there, with the ports that it will have */
    trap_open(&k);
    find_ports(&k, daemon);
    pid_t talker = rig_self("talk", uri, "");
    catch_for(&k, uri, 1.5);
    printf("%zu datagrams caught\n", k.count);

    assert_true(k.count > ENOUGH);
    collided *c = rig_connect(RIG_DDS, 30, COLLIDED_REMOVE);
    rig_box(c, "table", 0);
    collided_body part = rig_box(c, "part", 0.5);
    rig_watch(c, &h, "part");
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    long before = rig_resident_kb(daemon);
    for (int64_t step = 1; step <= bursts; step++) {
        send_burst(&k);
        rig_move(c, part, step % 2 ? 0.5 : 0.6, step);
        UNTIL(c, RIG_PATIENCE_S, h.step >= step);
        if (!rig_alive(daemon)) fail_msg("the daemon has ended after %lld bursts", (long long)step);
    }
    assert_int_equal(h.touching, 1);
    assert_int_equal(h.kinds[COLLIDED_END], 0);
    assert_int_equal(h.lost, 0);
    if (strcmp(uri, RIG_LCM) == 0)
        UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "lcm_refused") > 0); /* Status tells it later */
    printf("the daemon has %ld KiB, and grew by %ld; refused: %lld over LCM, %lld over DDS; %lld gateways\n",
        rig_resident_kb(daemon), rig_resident_kb(daemon) - before, (long long)rig_counter(c, "lcm_refused"),
        (long long)rig_counter(c, "dds_refused"), (long long)rig_counter(c, "lcm_gateway_restarts"));
    assert_true(rig_resident_kb(daemon) - before < 64 * 1024);
    if (rig_alive(talker)) rig_kill(talker, SIGKILL); /* it may have been ended by the answers to what it never said */
    rig_close(c);
    c = rig_connect(uri, 2, COLLIDED_REMOVE); /* whoever comes now is served */
    rig_box(c, "table", 0);
    rig_box(c, "part", 0.5);
    rig_watch(c, &h, "part");
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    rig_close(c);
    trap_close(&k);
}

int main(int argc, char **argv)
{
    if (argc == 4) return talk(argv[2]);
    const struct CMUnitTest tests[] = {OVER_BOTH(changed_datagrams_disturb_nobody_else)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
