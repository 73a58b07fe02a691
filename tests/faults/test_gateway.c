/* The LCM gateway is killed: it comes back, and nobody loses more than the moment. A crafted datagram does not reach
 * it. */
#include "rig.h"

#include <arpa/inet.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

/* A fragment (magic "LC03") whose offset and size wrap around 32 bits: liblcm 1.3.1 writes 4 GB beyond its buffer. */
static void send_crafted_datagram(void)
{
    enum { FRAGMENT = 512 };
    static const char channel[] = "collided.in.PoseBatch";
    uint8_t datagram[20 + sizeof channel + FRAGMENT] = {0};
    uint32_t head[4] = {htonl(0x4c433033), htonl(1), htonl(1000), htonl(UINT32_MAX - FRAGMENT / 2 + 1)};
    uint16_t fragments[2] = {htons(0), htons(2)};
    memcpy(datagram, head, sizeof head);
    memcpy(datagram + 16, fragments, sizeof fragments);
    memcpy(datagram + 20, channel, sizeof channel);
    struct sockaddr_in to = {.sin_family = AF_INET, .sin_port = htons(7667)};
    inet_pton(AF_INET, "239.255.76.67", &to.sin_addr);
    int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_int_equal(
        sendto(fd, datagram, sizeof datagram, 0, (const struct sockaddr *)&to, sizeof to), sizeof datagram);
    close(fd);
}

/* The other process, over LCM, since the crafted datagram would end this one too: says "part" at 0.5 once. */
static int stay(const char *uri, const char *lease)
{
    collided_def def = collided_def_default();
    def.lease_s = strtod(lease, NULL);
    def.connect_timeout_s = RIG_PATIENCE_S;
    collided *c = collided_connect(uri, &def);
    if (!c) return 1;
    rig_box(c, "part", 0.5);
    for (;;) collided_poll(c, 1);
}

typedef struct cell {
    collided *c;
    collided_body mover;
    heard parts, moves;
    pid_t daemon, owner;
} cell;

static void cell_open(cell *l, const char *lease)
{
    l->daemon = rig_daemon(NULL, NULL);
    l->c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    rig_box(l->c, "table", 0);
    rig_box(l->c, "block", 10);
    l->mover = rig_box(l->c, "mover", 10.5);
    rig_watch(l->c, &l->parts, "part");
    rig_watch(l->c, &l->moves, "mover");
    l->owner = rig_self("stay", RIG_LCM, lease);
    UNTIL(l->c, RIG_PATIENCE_S, l->parts.touching == 1 && l->moves.touching == 1);
}

/* Numbered poses over DDS, one after the other, each of which must be told of before the next goes out. */
static void publish_steps(cell *l, int64_t from, int64_t to)
{
    for (int64_t step = from; step <= to; step++) {
        rig_move(l->c, l->mover, 10.5 + 0.0001 * (double)step, step);
        UNTIL(l->c, RIG_PATIENCE_S, l->moves.step == step);
    }
}

/* At once, or after a short pause: where the network is missing it would be five seconds. */
static void assert_back_soon(cell *l, pid_t dead, double died_s)
{
    pid_t now = 0;
    UNTIL(l->c, RIG_PATIENCE_S, (now = rig_child(l->daemon)) != 0 && now != dead);
    assert_true(rig_now_s() - died_s < 4);
    assert_int_equal(kill(dead, 0), -1); /* gone, and waited for */
}

static void assert_nothing_was_lost(cell *l)
{
    assert_int_equal(l->moves.lost, 0);
    assert_int_equal(l->parts.lost, 0);
    UNTIL(l->c, RIG_PATIENCE_S, rig_counter(l->c, "lcm_gateway_restarts") == 1);
    UNTIL_IT_HOLDS(l->c, 3.5, l->parts.touching == 1); /* beyond its lease: the owner is heard again */
    assert_int_equal(rig_counter(l->c, "clients_lost"), 0);
    assert_true(rig_alive(l->owner));
    rig_close(l->c);
}

static void a_killed_gateway_costs_no_body_and_no_pose_over_dds(void **state)
{
    (void)state;
    cell l = {0};
    cell_open(&l, "3");
    publish_steps(&l, 1, 50);
    pid_t gateway = rig_child(l.daemon);
    assert_int_equal(kill(gateway, SIGKILL), 0);
    double died = rig_now_s();
    publish_steps(&l, 51, 100);
    assert_back_soon(&l, gateway, died);
    publish_steps(&l, 101, 150);
    assert_nothing_was_lost(&l);
}

static void a_crafted_datagram_does_not_end_the_gateway(void **state)
{
    (void)state;
    cell l = {0};
    cell_open(&l, "60");
    pid_t gateway = rig_child(l.daemon);
    rig_kill(l.owner, SIGKILL); /* liblcm receives there, too; a moment later its lease still holds the body */
    send_crafted_datagram();
    publish_steps(&l, 1, 100);
    UNTIL(l.c, RIG_PATIENCE_S, rig_counter(l.c, "lcm_datagrams_dropped") == 1);
    assert_int_equal(l.parts.touching, 1);
    assert_int_equal(l.moves.lost, 0);
    assert_int_equal(rig_child(l.daemon), gateway);
    assert_int_equal(rig_counter(l.c, "lcm_gateway_restarts"), 0);
    assert_true(rig_alive(l.daemon));
    rig_close(l.c);
}

int main(int argc, char **argv)
{
    if (argc == 4) return stay(argv[2], argv[3]);
    const struct CMUnitTest tests[] = {OVER(a_killed_gateway_costs_no_body_and_no_pose_over_dds, RIG_LCM),
        OVER(a_crafted_datagram_does_not_end_the_gateway, RIG_LCM)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
