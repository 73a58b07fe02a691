/* Clients that are killed, or that stand still and come back: what watchers are told, and when. */
#include "rig.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define LEASE_S 0.6 /* of the one that is struck */

/* The other process: a part at 0.5 whose poses it publishes until it is ended. */
static int publish_for_ever(const char *uri, collided_on_loss on_loss)
{
    collided_def def = collided_def_default();
    def.lease_s = LEASE_S;
    def.on_loss = on_loss;
    def.connect_timeout_s = RIG_PATIENCE_S;
    collided *c = collided_connect(uri, &def);
    if (!c) return EXIT_FAILURE;
    collided_body part = rig_box(c, "part", 0.5);
    for (int64_t step = 1;; step++) {
        rig_move(c, part, 0.5, step);
        collided_poll(c, 0.02);
    }
}

typedef struct cell {
    collided *watcher;
    pid_t owner;
    heard heard;
} cell;

static void cell_open(cell *c, const char *uri, const char *on_loss)
{
    rig_daemon(NULL, NULL);
    c->watcher = rig_connect(uri, 10, COLLIDED_REMOVE);
    rig_box(c->watcher, "table", 0);
    rig_watch(c->watcher, &c->heard, "table");
    c->owner = rig_self("publish", uri, on_loss);
    UNTIL(c->watcher, RIG_PATIENCE_S, c->heard.touching == 1 && c->heard.step > 5);
}

static bool part_is_stale(cell *c, size_t *count)
{
    collided_result r = {0};
    assert_int_equal(collided_query_bodies(c->watcher, "part", RIG_PATIENCE_S, &r), COLLIDED_OK);
    bool stale = r.count == 1 && r.hits[0].stale;
    *count = r.count;
    collided_result_free(&r);
    return stale;
}

static void bodies_to_remove_end_as_owner_lost(void **state)
{
    cell c;
    size_t count;
    cell_open(&c, *state, "remove");
    rig_kill(c.owner, SIGKILL);
    UNTIL(c.watcher, RIG_PATIENCE_S, c.heard.touching == 0);
    assert_string_equal(c.heard.cause[COLLIDED_END], "owner_lost");
    assert_false(part_is_stale(&c, &count));
    assert_int_equal(count, 0);
    UNTIL(c.watcher, RIG_PATIENCE_S, rig_counter(c.watcher, "clients_lost") == 1); /* Status comes in its own time */
    rig_close(c.watcher);
}

static void held_bodies_become_unknown_and_never_free(void **state)
{
    cell c;
    size_t count;
    cell_open(&c, *state, "hold");
    rig_kill(c.owner, SIGKILL);
    UNTIL(c.watcher, RIG_PATIENCE_S, c.heard.kinds[COLLIDED_UNKNOWN] > 0);
    THROUGHOUT(c.watcher, 1, c.heard.kinds[COLLIDED_KNOWN] + c.heard.kinds[COLLIDED_FAR] == 0);
    assert_true(part_is_stale(&c, &count));
    for (size_t i = 0; i < c.heard.kinds[COLLIDED_END]; i++) assert_string_equal(c.heard.cause[COLLIDED_END], "stale");
    rig_close(c.watcher);
}

static void kept_bodies_stay_as_they_are(void **state)
{
    cell c;
    size_t count;
    cell_open(&c, *state, "keep");
    rig_kill(c.owner, SIGKILL);
    UNTIL(c.watcher, RIG_PATIENCE_S, rig_counter(c.watcher, "clients_lost") == 1);
    THROUGHOUT(c.watcher, 0.5, c.heard.touching == 1 && c.heard.kinds[COLLIDED_UNKNOWN] == 0);
    assert_false(part_is_stale(&c, &count));
    assert_int_equal(count, 1);
    rig_close(c.watcher);
}

static void one_that_stood_still_comes_back_by_itself(void **state)
{
    cell c;
    cell_open(&c, *state, "remove");
    rig_kill(c.owner, SIGSTOP);
    UNTIL(c.watcher, RIG_PATIENCE_S, c.heard.touching == 0);
    assert_string_equal(c.heard.cause[COLLIDED_END], "owner_lost");
    int64_t step = c.heard.step;
    rig_kill(c.owner, SIGCONT);
    UNTIL(c.watcher, RIG_PATIENCE_S, c.heard.touching == 1 && c.heard.step > step + 5);
    UNTIL_IT_HOLDS(c.watcher, LEASE_S + 0.5, c.heard.touching == 1);
    rig_close(c.watcher);
}

static collided_on_loss on_loss_of(const char *name)
{
    return strcmp(name, "keep") == 0 ? COLLIDED_KEEP : strcmp(name, "hold") == 0 ? COLLIDED_HOLD : COLLIDED_REMOVE;
}

int main(int argc, char **argv)
{
    if (argc == 4) return publish_for_ever(argv[2], on_loss_of(argv[3]));
    const struct CMUnitTest tests[] = {OVER_BOTH(bodies_to_remove_end_as_owner_lost),
        OVER_BOTH(held_bodies_become_unknown_and_never_free), OVER_BOTH(kept_bodies_stay_as_they_are),
        OVER_BOTH(one_that_stood_still_comes_back_by_itself)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
