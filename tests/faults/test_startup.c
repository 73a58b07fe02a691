/* Everybody starts at the same moment, on a machine that has other work: the daemon, its clients, and a daemon that
 * takes the place of another. Discovery then tells each side of the other in any order, one endpoint at a time. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>

enum { BURNERS = 2, STARTERS = 13, ROUNDS = 3, REMAINING = 12 };
enum { CONNECTED, NOT_CONNECTED, NOT_SETTLED };

/* ---- further processes ---- */

static _Noreturn void burn_for_ever(void)
{
    for (volatile unsigned spin = 0;;) spin++;
}

/* One whole visit: what it announces at once must be acknowledged, too. */
static int visit(const char *uri, const char *name)
{
    collided_def def = collided_def_default();
    def.connect_timeout_s = 3 * RIG_PATIENCE_S;
    collided *c = collided_connect(uri, &def);
    if (!c) {
        fprintf(stderr, "%s: %s\n", name, collided_connect_error());
        return NOT_CONNECTED;
    }
    rig_box(c, name, 0);
    collided_status status = collided_sync(c, RIG_PATIENCE_S);
    if (status) fprintf(stderr, "%s: %s\n", name, collided_error(c));
    collided_close(c);
    return status ? NOT_SETTLED : CONNECTED;
}

/* ---- tests ---- */

static void clients_that_start_with_the_daemon_all_connect(void **state)
{
    const char *uri = *state;
    rig_need_network();
    for (int i = 0; i < BURNERS; i++) rig_self("burn", uri, "");
    for (int round = 0; round < ROUNDS; round++) {
        char name[STARTERS][16];
        pid_t starters[STARTERS], daemon = rig_daemon(NULL, NULL);
        for (int i = 0; i < STARTERS; i++) {
            snprintf(name[i], sizeof name[i], "starter %d", i);
            starters[i] = rig_self("visit", uri, name[i]);
        }
        for (int i = 0; i < STARTERS; i++) assert_int_equal(rig_wait(starters[i], 4 * RIG_PATIENCE_S), CONNECTED);
        rig_kill(daemon, SIGKILL);
    }
}

static size_t bodies_known(collided *c)
{
    collided_result bodies = {0};
    size_t count = collided_query_bodies(c, "*", 5, &bodies) == COLLIDED_OK ? bodies.count : 0;
    collided_result_free(&bodies);
    return count;
}

static void a_daemon_that_takes_over_is_told_of_all_and_answers_all(void **state)
{
    const char *uri = *state;
    pid_t first = rig_daemon(NULL, NULL);
    for (int i = 0; i < BURNERS; i++) rig_self("burn", uri, "");
    collided *clients[REMAINING];
    for (int i = 0; i < REMAINING; i++) {
        char name[16];
        snprintf(name, sizeof name, "part %d", i);
        clients[i] = rig_connect(uri, 10, COLLIDED_REMOVE);
        rig_box(clients[i], name, 3 * i);
        assert_int_equal(collided_sync(clients[i], RIG_PATIENCE_S), COLLIDED_OK);
    }
    rig_kill(first, SIGKILL);
    rig_daemon(NULL, NULL);
    UNTIL(clients[0], RIG_PATIENCE_S, bodies_known(clients[0]) == REMAINING);
    for (int i = 0; i < REMAINING; i++) assert_int_equal(collided_sync(clients[i], RIG_PATIENCE_S), COLLIDED_OK);
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "burn") == 0) burn_for_ever();
    if (argc == 4) return visit(argv[2], argv[3]);
    const struct CMUnitTest tests[] = {OVER_BOTH(clients_that_start_with_the_daemon_all_connect),
        OVER_BOTH(a_daemon_that_takes_over_is_told_of_all_and_answers_all)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
