/* A subscriber that stands still, and one that lives but never polls, beside one that reads: it gets every batch, and
 * the daemon does not grow. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <unistd.h>

enum { PAIRS = 64, TICKS = 1500, GROWTH_KB = 32 * 1024 };

/* The other process: subscribes, says so by a body, and never polls again. Its lease is kept by the library's thread.
 */
static int never_poll(const char *uri)
{
    static heard h;
    collided_def def = collided_def_default();
    def.lease_s = 60; /* also when it stands still: it stays subscribed */
    collided *c = collided_connect(uri, &def);
    if (!c) return 1;
    rig_watch(c, &h, "part*");
    rig_box(c, "deaf", -50);
    collided_sync(c, RIG_PATIENCE_S);
    for (;;) pause();
}

typedef struct cell {
    pid_t daemon, deaf;
    collided *c;
    collided_body parts[PAIRS];
    heard heard;
} cell;

static void cell_open(cell *l, const char *uri)
{
    char name[32];
    l->daemon = rig_daemon(NULL, NULL);
    l->c = rig_connect(uri, 60, COLLIDED_REMOVE);
    for (int i = 0; i < PAIRS; i++) {
        snprintf(name, sizeof name, "part %d", i);
        l->parts[i] = rig_box(l->c, name, 3 * i);
        snprintf(name, sizeof name, "table %d", i);
        rig_box(l->c, name, 3 * i + 0.5);
    }
    rig_watch(l->c, &l->heard, "part*");
    l->deaf = rig_self("deaf", uri, "");
    UNTIL(l->c, RIG_PATIENCE_S, l->heard.touching == PAIRS);
    UNTIL(
        l->c, RIG_PATIENCE_S, rig_counter(l->c, "subscriptions") == 2 && rig_counter(l->c, "bodies") == 2 * PAIRS + 1);
}

/* Every pair moves in every tick, and each tick must be told of before the next. */
static void run(cell *l, int64_t from, int64_t to)
{
    double positions[3 * PAIRS] = {0}, orientations[4 * PAIRS] = {0};
    for (int64_t step = from; step <= to; step++) {
        for (int i = 0; i < PAIRS; i++) {
            positions[3 * i] = 3 * i + 1e-4 * (double)(step % 1000);
            orientations[4 * i] = 1;
        }
        collided_publish(l->c, PAIRS, l->parts, positions, orientations, NULL, NULL, 0, step);
        UNTIL(l->c, RIG_PATIENCE_S, l->heard.step == step);
    }
}

static void nobody_else_waits(void **state, int number)
{
    cell l = {0};
    cell_open(&l, *state);
    run(&l, 1, TICKS / 3); /* everything has its size */
    if (number) rig_kill(l.deaf, number);
    long before = rig_resident_kb(l.daemon);
    run(&l, TICKS / 3 + 1, TICKS);
    long growth = rig_resident_kb(l.daemon) - before;
    printf("the daemon has %ld KiB, and grew by %ld\n", before + growth, growth);
    assert_true(growth < GROWTH_KB);
    assert_int_equal(l.heard.lost, 0);
    assert_int_equal(l.heard.touching, PAIRS);
    assert_int_equal(rig_counter(l.c, "subscriptions"), 2); /* the other one was subscribed all the time */
    rig_close(l.c);
}

static void a_subscriber_that_never_polls_slows_nobody_down(void **state)
{
    nobody_else_waits(state, 0);
}
static void a_subscriber_that_stands_still_slows_nobody_down(void **state)
{
    nobody_else_waits(state, SIGSTOP);
}

int main(int argc, char **argv)
{
    if (argc == 4) return never_poll(argv[2]);
    const struct CMUnitTest tests[] = {OVER_BOTH(a_subscriber_that_never_polls_slows_nobody_down),
        OVER(a_subscriber_that_stands_still_slows_nobody_down, RIG_DDS)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
