/* Crowds over DDS on loopback of which some are killed, and the daemon with them, while the others join: a discovery
 * that is cut off at any packet is repaired, so that everybody who lives is in afterwards, with all that it announced.
 * Who is killed, and when, is drawn; the seed is printed, and COLLIDED_SEED repeats it but for the machine's pace. */
#include "crowd.h"
#include "rig.h"

#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { CROWD = 40, CROWD_NIGHTLY = 150, KILLS = 40, DAEMON_EACH = 13 /* of so many kills one is the daemon's */ };

static const double IN_S = 60; /* from the last kill until the last one is in: what waited for 60 s was the fault */

static int crowd_size(void)
{
    return getenv("COLLIDED_NIGHTLY") ? CROWD_NIGHTLY : CROWD;
}

/* ---- the test ---- */

static unsigned seed;

static int draw(int most)
{
    return (int)((unsigned)rand_r(&seed) % (unsigned)most);
}

/* A name is taken until the lease of whom it belonged to is over: so each process has names of its own. */
static pid_t start_one(void)
{
    static int number;
    char text[16];
    snprintf(text, sizeof text, "%d", number++);
    return rig_self("one", RIG_DDS, text);
}

/* Over DDS alone, and nobody waits until it is ready: the crowd does not, either. */
static pid_t start_daemon(void)
{
    const char *const arguments[] = {"collided", "--links", RIG_DDS, "--log", "error", NULL};
    return rig_start(COLLIDED, arguments);
}

static void kill_some(pid_t *crowd, int size, pid_t *daemon)
{
    for (int i = 1; i <= KILLS; i++) {
        (void)poll(NULL, 0, draw(100)); /* not to wait for something: when the next one is killed is drawn, too */
        if (i % DAEMON_EACH == 0) {
            rig_kill(*daemon, SIGKILL);
            *daemon = start_daemon();
            continue;
        }
        pid_t *one = &crowd[draw(size)];
        rig_kill(*one, SIGKILL);
        *one = start_one();
    }
}

static void wait_until_all_are_in(collided *watcher, int size)
{
    int64_t bodies = -1, clients = -1;
    double began = rig_now_s();
    while (bodies != CROWD_BODIES * (int64_t)size || clients != size + 1) {
        if (rig_now_s() - began > IN_S)
            fail_msg("after %g s %lld of %d bodies and %lld of %d clients are in, %lld wait for their turn", IN_S,
                (long long)bodies, CROWD_BODIES * size, (long long)clients, size + 1,
                (long long)crowd_counter(watcher, "dds_turns_waiting"));
        collided_poll(watcher, 0.05);
        bodies = crowd_counter(watcher, "bodies");
        clients = crowd_counter(watcher, "clients");
    }
    print_message("%d clients are in %.1f s after the last kill\n", size, rig_now_s() - began);
}

static void who_lives_is_in_when_others_were_killed(void **state)
{
    (void)state;
    static pid_t crowd[CROWD_NIGHTLY];
    int size = crowd_size();
    rig_need_network();
    pid_t daemon = start_daemon();
    for (int i = 0; i < size; i++) crowd[i] = start_one();
    kill_some(crowd, size, &daemon);
    collided_def def = collided_def_default();
    def.connect_timeout_s = IN_S;
    collided *watcher = collided_connect(RIG_DDS, &def);
    if (!watcher) fail_msg("%s", collided_connect_error());
    wait_until_all_are_in(watcher, size);
    for (int i = 0; i < size; i++) assert_true(rig_alive(crowd[i]));
    collided_close(watcher);
}

int main(int argc, char **argv)
{
    if (argc == 4) return crowd_be_one(argv[2], argv[3], NULL);
    const char *given = getenv("COLLIDED_SEED");
    seed = given ? (unsigned)strtoul(given, NULL, 10) : (unsigned)time(NULL) ^ (unsigned)getpid();
    print_message("COLLIDED_SEED=%u\n", seed);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(who_lives_is_in_when_others_were_killed, rig_end_all),
    };
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
