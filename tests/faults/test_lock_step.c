/* Simulators in several processes in lock-step, by the client library, over both links: each moves a box of its own,
 * all boxes one way together, so that whoever saw a step half done would see them meet. One is killed, and one stands
 * still for a while: the others go on, and are told. Of a pair of daemons the active one is killed between two steps,
 * and in the middle of one. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SIMULATORS = 3, STEPS = 60 };
#define LEASE_S 1.0 /* of those that are struck */
#define CALM_S "20" /* lease and step timeout where nobody is to be missed, however busy the machine */
#define PAIR_LEASE_S                                                                                                   \
    1.0 /* nor one of a pair to fall behind: a standby that stood still knows nothing of the last steps */
static const double GAP_M = 0.5, STEP_M = 2; /* farther than to the next one */

typedef struct simulator {
    collided *client;
    collided_body body;
    int number;
    int64_t done; /* the step that the others are at */
    long meetings, missed, told;
} simulator;

static void on_events(void *context, const collided_batch *batch)
{
    simulator *s = context;
    for (size_t i = 0; i < batch->event_count; i++) s->meetings += batch->events[i].kind == COLLIDED_BEGIN;
    s->missed += batch->missing;
    s->done = batch->step;
}

static void on_rejected(void *context, const collided_rejection *why)
{
    simulator *s = context;
    s->told += strcmp(why->reason, "step_missed") == 0;
}

static bool begin(simulator *s, const char *uri, int number, double lease_s)
{
    char name[16];
    collided_def def = collided_def_default();
    def.lease_s = lease_s;
    def.connect_timeout_s = RIG_PATIENCE_S;
    def.lock_step = SIMULATORS;
    *s = (simulator){.client = collided_connect(uri, &def), .number = number};
    if (!s->client) return false;
    collided_on_rejected(s->client, on_rejected, s);
    snprintf(name, sizeof name, "box%d", number);
    s->body = rig_box(s->client, name, number * (1 + GAP_M));
    collided_subscription_def all = collided_subscription_def_default();
    all.callback = on_events;
    all.context = s;
    return collided_subscribe(s->client, &all).id != COLLIDED_NONE &&
           collided_sync(s->client, RIG_PATIENCE_S) == COLLIDED_OK;
}

/* Over LCM an answer may be lost: the same again. */
static collided_status step(simulator *s, int64_t number)
{
    collided_status status = COLLIDED_TIMEOUT;
    for (int tries = 0; tries < 30 && status == COLLIDED_TIMEOUT; tries++) {
        const double position[3] = {s->number * (1 + GAP_M) + STEP_M * (double)number, 0, 0}, turn[4] = {1, 0, 0, 0};
        status = collided_publish(s->client, 1, &s->body, position, turn, NULL, NULL, 0, number);
        if (status == COLLIDED_OK) status = collided_step(s->client, number, 1);
    }
    return status;
}

/* Steps until it is ended; one that was left behind goes on where the others are. */
static int simulate_for_ever(const char *uri, const char *who)
{
    simulator s;
    char *lease;
    int number = (int)strtol(who, &lease, 10);
    if (!begin(&s, uri, number, strtod(lease, NULL))) return EXIT_FAILURE;
    for (int64_t n = 1;; n++) {
        collided_status status = step(&s, n);
        if (status == COLLIDED_REJECTED)
            n = s.done;
        else if (status != COLLIDED_OK && status != COLLIDED_TIMEOUT)
            return EXIT_FAILURE;
    }
}

typedef struct yard {
    simulator mine;
    pid_t others[SIMULATORS - 1];
} yard;

static void enter_of(yard *y, const char *uri, double lease_s)
{
    char who[32];
    for (int k = 0; k < SIMULATORS - 1; k++) {
        snprintf(who, sizeof who, "%d %g", k + 1, lease_s);
        y->others[k] = rig_self("simulate", uri, who);
    }
    assert_true(begin(&y->mine, uri, 0, lease_s));
}

static void enter(yard *y, const char *uri)
{
    rig_daemon("--step_timeout", "0.3");
    enter_of(y, uri, LEASE_S);
}

/* One step of ours; on a busy machine it may be we who are late, and go on where the others are. */
static void go_on(yard *y, int64_t *n)
{
    collided_status status = step(&y->mine, (*n)++);
    if (status == COLLIDED_REJECTED)
        *n = y->mine.done + 1;
    else
        assert_int_equal(status, COLLIDED_OK);
}

static void all_step_together_and_see_no_step_half_done(void **state)
{
    yard y;
    rig_daemon("--step_timeout", CALM_S);
    enter_of(&y, *state, strtod(CALM_S, NULL));
    double began_s = rig_now_s();
    for (int64_t n = 1; n <= STEPS; n++) assert_int_equal(step(&y.mine, n), COLLIDED_OK);
    print_message("%d steps of %d processes: %.0f a second\n", STEPS, SIMULATORS, STEPS / (rig_now_s() - began_s));
    assert_int_equal(y.mine.meetings, 0);
    UNTIL(y.mine.client, RIG_PATIENCE_S,
        rig_counter(y.mine.client, "lock_step_clients") > 0); /* Status comes in its own time */
    rig_close(y.mine.client);
}

static void the_others_go_on_without_one_that_was_killed(void **state)
{
    yard y;
    enter(&y, *state);
    int64_t n = 1;
    while (n <= 10) go_on(&y, &n);
    rig_kill(y.others[1], SIGKILL);
    double killed_s = rig_now_s();
    do { /* until it is no member any more */
        if (rig_now_s() > killed_s + RIG_PATIENCE_S) fail_msg("it is missed still");
        y.mine.missed = 0;
        go_on(&y, &n);
    } while (y.mine.missed || rig_now_s() < killed_s + 0.5);
    print_message("it was no member any more after %.2f s, lease %g s\n", rig_now_s() - killed_s, LEASE_S);
    rig_close(y.mine.client);
}

static void one_that_stands_still_is_missed_and_told(void **state)
{
    yard y;
    enter(&y, *state);
    int64_t n = 1;
    while (n <= 10) go_on(&y, &n);
    rig_kill(y.others[1], SIGSTOP);
    double stopped_s = rig_now_s();
    while (!(y.mine.missed && y.mine.told)) {
        if (rig_now_s() > stopped_s + RIG_PATIENCE_S) fail_msg("it is not missed");
        go_on(&y, &n);
    }
    rig_kill(y.others[1], SIGCONT);
    double goes_s = rig_now_s();
    while (y.mine.missed) { /* it finds out how far they are, and goes on there */
        if (rig_now_s() > goes_s + RIG_PATIENCE_S) fail_msg("it is missed still");
        y.mine.missed = 0;
        go_on(&y, &n);
    }
    rig_close(y.mine.client);
}

static bool has_standby(collided *c)
{
    collided_daemon_status s;
    return collided_get_status(c, 1, &s) == COLLIDED_OK && strstr(s.links, "active, hot standby: ");
}

static void each_step_is_done_once_whichever_daemon_does_it(void **state)
{
    yard y;
    const char *name;
    collided_daemon_status s;
    int64_t n = 1;
    for (int k = 0; k < 2; k++) rig_one_of_a_pair_of(PAIR_LEASE_S, "--step_timeout=" CALM_S);
    enter_of(&y, *state, strtod(CALM_S, NULL));
    for (int k = 0; k < 2; k++) {
        UNTIL(y.mine.client, RIG_PATIENCE_S, has_standby(y.mine.client));
        for (int i = 0; i < 10; i++) assert_int_equal(step(&y.mine, n++), COLLIDED_OK);
        if (k) rig_kill(y.others[0], SIGSTOP); /* what the others publish waits for it */
        const double position[3] = {STEP_M * (double)n, 0, 0}, turn[4] = {1, 0, 0, 0};
        collided_publish(y.mine.client, 1, &y.mine.body, position, turn, NULL, NULL, 0, n);
        assert_int_equal(collided_get_status(y.mine.client, RIG_PATIENCE_S, &s), COLLIDED_OK);
        assert_non_null(name = strrchr(s.daemon, ':'));
        rig_kill((pid_t)strtol(name + 1, NULL, 10), SIGKILL);
        if (k) rig_kill(y.others[0], SIGCONT);
        for (int i = 0; i < 20; i++) assert_int_equal(step(&y.mine, n++), COLLIDED_OK);
        assert_int_equal(y.mine.done, n - 1);
        if (!k) rig_one_of_a_pair_of(PAIR_LEASE_S, "--step_timeout=" CALM_S);
    }
    assert_int_equal(y.mine.meetings, 0);
    assert_int_equal(y.mine.missed, 0);
    rig_close(y.mine.client);
}

int main(int argc, char **argv)
{
    if (argc == 4) return simulate_for_ever(argv[2], argv[3]);
    const struct CMUnitTest tests[] = {OVER_BOTH(all_step_together_and_see_no_step_half_done),
        OVER_BOTH(the_others_go_on_without_one_that_was_killed), OVER_BOTH(one_that_stands_still_is_missed_and_told),
        OVER_BOTH(each_step_is_done_once_whichever_daemon_does_it)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
