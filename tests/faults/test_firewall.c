/* A firewall that drops what a host sends to itself: Cyclone DDS then cannot end its own threads, and whoever waited
 * for it would wait for ever. Daemon and client end in bounded time all the same, and say why. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void loopback_drops(bool drops)
{
    const char *command = drops ? "PATH=$PATH:/usr/sbin:/sbin; iptables -A OUTPUT -o lo -p udp -j DROP 2>/dev/null"
                                : "PATH=$PATH:/usr/sbin:/sbin; iptables -F";
    rig_need_network();
    if (system(command) == 0) return; /* NOLINT(cert-env33-c): a fixed line */
    printf("skipped: no rule can be set by iptables here (package iptables, or the kernel's module)\n");
    skip();
}

static void a_daemon_ends_in_order_within_seconds(void **state)
{
    pid_t daemon = rig_daemon(NULL, NULL);
    collided *c = rig_connect(*state, 2, COLLIDED_REMOVE);
    rig_close(c);
    loopback_drops(true);
    rig_kill(daemon, SIGTERM);
    int status = rig_wait(daemon, RIG_PATIENCE_S);
    loopback_drops(false);
    assert_int_equal(status, 0);
}

/* The last test: this process keeps what was left behind. */
static void a_client_closes_within_seconds_and_does_not_open_that_domain_again(void **state)
{
    collided_def def = collided_def_default();
    rig_daemon(NULL, NULL);
    collided *c = rig_connect(*state, 2, COLLIDED_REMOVE);
    loopback_drops(true);
    double began = rig_now_s();
    rig_close(c);
    assert_true(rig_now_s() - began < RIG_PATIENCE_S);
    loopback_drops(false);
    began = rig_now_s();
    def.connect_timeout_s = 10 * RIG_PATIENCE_S;
    assert_null(collided_connect(*state, &def)); /* at once: it does not wait for a daemon */
    assert_true(rig_now_s() - began < RIG_PATIENCE_S);
    assert_non_null(strstr(collided_connect_error(), "firewall"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER(a_daemon_ends_in_order_within_seconds, RIG_DDS),
        OVER(a_client_closes_within_seconds_and_does_not_open_that_domain_again, RIG_DDS)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
