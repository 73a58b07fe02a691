/* A pair of daemons under load: the active one is killed, stopped, and ended in order, and starts again as the standby
 * of the other. A model holds every begin and end against what was done to the bodies: each pendulum touches the table
 * or not, and is moved on only after that has been told, so that each move has exactly one event. */
#include "rig.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PENDULUMS = 20, CONTACTS_MAX = 1 << 23 };

typedef struct pendulum {
    collided_body body;
    char name[16];
    bool touches;    /* it was told so */
    bool should;     /* it was moved so */
    int64_t contact; /* the one that is open */
    int moves;
} pendulum;

typedef struct model {
    pendulum pendulums[PENDULUMS];
    uint8_t state[CONTACTS_MAX]; /* of a contact id: 1 begun, 2 ended */
    int64_t epoch, batches, lost, begins, ends, snapshots;
    int beside;               /* strikes that met the standby */
    double last_s, longest_s; /* of batches; the longest silence since it was set to 0 */
    char fault[256];
} model;

static model m;

#define FAULT(...)                                                                                                     \
    do {                                                                                                               \
        if (!*m.fault) snprintf(m.fault, sizeof m.fault, __VA_ARGS__);                                                 \
    } while (0)

static pendulum *named(const collided_event *e)
{
    const char *name = e->name_a[0] == 'p' ? e->name_a : e->name_b;
    return &m.pendulums[atoi(name + 1)];
}

static void hear_begin(const collided_event *e, bool again)
{
    pendulum *p = named(e);
    if (e->contact <= 0 || e->contact >= CONTACTS_MAX) {
        FAULT("contact %lld", (long long)e->contact);
    } else if (again && m.state[e->contact] == 1 && p->contact == e->contact) {
        return;
    } else if (m.state[e->contact]) {
        FAULT("contact %lld begins twice (%s)", (long long)e->contact, p->name);
    } else if (p->touches) {
        FAULT("%s begins although it touches", p->name);
    } else {
        m.state[e->contact] = 1;
        p->contact = e->contact;
        p->touches = true;
        m.begins++;
    }
}

static void hear_end(const collided_event *e)
{
    pendulum *p = named(e);
    if (e->contact <= 0 || e->contact >= CONTACTS_MAX || m.state[e->contact] != 1 || p->contact != e->contact) {
        FAULT("contact %lld of %s ends and was not open", (long long)e->contact, p->name);
        return;
    }
    m.state[e->contact] = 2;
    p->touches = false;
    m.ends++;
}

static void hear_batch(void *context, const collided_batch *b)
{
    (void)context;
    double now = rig_now_s();
    if (m.last_s > 0 && now - m.last_s > m.longest_s) m.longest_s = now - m.last_s;
    m.last_s = now;
    m.batches++;
    m.lost += b->lost;
    if (b->epoch < m.epoch) FAULT("epoch %lld after %lld", (long long)b->epoch, (long long)m.epoch);
    m.epoch = b->epoch;
    m.snapshots += b->snapshot;
    for (size_t i = 0; i < b->event_count; i++) {
        const collided_event *e = &b->events[i];
        if (e->kind == COLLIDED_BEGIN) hear_begin(e, b->snapshot);
        if (e->kind == COLLIDED_END) hear_end(e);
    }
}

/* ---- the load ---- */

static void place(collided *c, pendulum *p, bool touches)
{
    const double position[3] = {1.5 * (double)(p - m.pendulums), 0, touches ? 0.9 : 1.5}, orientation[4] = {1, 0, 0, 0};
    p->should = touches;
    p->moves++;
    collided_publish(c, 1, &p->body, position, orientation, NULL, NULL, 0, 0);
}

static collided *set_up(void)
{
    memset(&m, 0, sizeof m);
    collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    collided_shape table = collided_box(200, 1, 1), bob = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    def.name = "table";
    def.shapes = &table;
    def.shape_count = 1;
    assert_int_not_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    for (int i = 0; i < PENDULUMS; i++) {
        pendulum *p = &m.pendulums[i];
        snprintf(p->name, sizeof p->name, "p%d", i);
        def.name = p->name;
        def.shapes = &bob;
        def.pose.position[0] = 1.5 * i;
        def.pose.position[2] = 1.5;
        p->body = collided_create_body(c, &def);
    }
    collided_subscription_def subscription = collided_subscription_def_default();
    subscription.select_a = "table";
    subscription.callback = hear_batch;
    assert_int_not_equal(collided_subscribe(c, &subscription).id, COLLIDED_NONE);
    assert_int_equal(collided_sync(c, RIG_PATIENCE_S), COLLIDED_OK);
    return c;
}

/* Moves on each pendulum whose event has come; the others wait. */
static void swing(collided *c, double seconds)
{
    for (double end = rig_now_s() + seconds; rig_now_s() < end;) {
        for (int i = 0; i < PENDULUMS; i++) {
            pendulum *p = &m.pendulums[i];
            if (p->touches == p->should) place(c, p, !p->should);
        }
        collided_flush(c);
        collided_poll(c, 0.0005);
        if (*m.fault) fail_msg("%s", m.fault);
    }
}

static bool all_told(void)
{
    for (int i = 0; i < PENDULUMS; i++)
        if (m.pendulums[i].touches != m.pendulums[i].should) return false;
    return true;
}

/* Nothing is under way any more, and everything has been told exactly once. */
static void judge(collided *c)
{
    int64_t moves = 0;
    UNTIL(c, RIG_PATIENCE_S, all_told() || *m.fault);
    THROUGHOUT(c, 0.2, !*m.fault && all_told());
    for (int i = 0; i < PENDULUMS; i++) moves += m.pendulums[i].moves;
    assert_int_equal(moves, m.begins + m.ends);
    assert_int_equal(m.lost, 0);
}

static bool has_standby(collided *c)
{
    collided_daemon_status s;
    return collided_get_status(c, 1, &s) == COLLIDED_OK && strstr(s.links, "active, hot standby: ");
}

/* A busy machine may have let them change places meanwhile: whose word the client follows. */
static pid_t active_one(collided *c)
{
    collided_daemon_status s;
    assert_int_equal(collided_get_status(c, RIG_PATIENCE_S, &s), COLLIDED_OK);
    const char *colon = strrchr(s.daemon, ':');
    assert_non_null(colon);
    return (pid_t)atoi(colon + 1);
}

static pid_t start_one(void)
{
    return rig_one_of_a_pair(NULL);
}

/* The load goes on while the other one takes over the state. */
static void await_standby(collided *c)
{
    for (double end = rig_now_s() + RIG_PATIENCE_S; !has_standby(c);) {
        if (rig_now_s() > end) fail_msg("no standby is in step in time");
        swing(c, 0.02);
    }
}

/* The load goes on until the standby tells of it. False if it does not: a busy machine had let them change places
 * between the question and the strike, and it was the standby that was struck. No more than three times. */
static bool followed(collided *c, int64_t epoch)
{
    for (double end = rig_now_s() + RIG_PATIENCE_S / 10; m.epoch == epoch && rig_now_s() < end;) swing(c, 0.01);
    if (m.epoch == epoch && ++m.beside > 3) fail_msg("nothing is told by the standby");
    return m.epoch != epoch;
}

/* ---- tests ---- */

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void a_killed_daemon_is_followed_without_a_lost_or_doubled_event(void **state)
{
    (void)state;
    enum { KILLS_MAX = 50 };
    double gaps[KILLS_MAX];
    int kills = getenv("COLLIDED_NIGHTLY") ? KILLS_MAX : getenv("COLLIDED_BRIEF") ? 2 : 5;
    pid_t one = start_one();
    collided *c = set_up();
    pid_t two = start_one();
    int64_t snapshots = m.snapshots;
    int within = 0;
    srand(8);
    for (int k = 0; k < kills; k++) {
        await_standby(c);
        swing(c, 0.05 + 0.3 * rand() / RAND_MAX);
        int64_t epoch = m.epoch;
        m.longest_s = 0;
        pid_t active = active_one(c);
        rig_kill(active, SIGKILL);
        bool was_standby = !followed(c, epoch);
        swing(c, 0.05);
        gaps[k] = m.longest_s;
        within += !was_standby && gaps[k] <= rig_pair_lease_s() + 0.02;
        k -= was_standby;
        one = active == one ? two : one;
        two = start_one();
    }
    judge(c);
    qsort(gaps, (size_t)kills, sizeof *gaps, compare);
    printf(
        "%d kills: silence %.0f ms at least, %.0f at the median, %.0f at most, %d within 20 ms of the lease, %.0f ms; "
        "%lld begins, %lld ends, %lld snapshots\n",
        kills, 1e3 * gaps[0], 1e3 * gaps[kills / 2], 1e3 * gaps[kills - 1], within, 1e3 * rig_pair_lease_s(),
        (long long)m.begins, (long long)m.ends, (long long)(m.snapshots - snapshots));
    assert_true(
        gaps[0] <= rig_pair_lease_s() + (getenv("COLLIDED_BRIEF") ? 2 : 0.2)); /* the median is a busy machine's */
    assert_true(rig_alive(one));
    rig_close(c);
}

/* The one that was stopped comes back, and finds that another one has taken over. */
static void a_stopped_daemon_that_comes_back_steps_down(void **state)
{
    (void)state;
    pid_t one = start_one();
    collided *c = set_up();
    pid_t two = start_one();
    for (int k = 0; k < 3; k++) {
        await_standby(c);
        swing(c, 0.1);
        int64_t epoch = m.epoch;
        pid_t active = active_one(c);
        rig_kill(active, SIGSTOP);
        k -= !followed(c, epoch);
        swing(c, 0.3);
        rig_kill(active, SIGCONT);
        await_standby(c); /* the one that was stopped */
    }
    judge(c);
    assert_true(rig_alive(one) && rig_alive(two));
    rig_close(c);
}

static void a_daemon_that_ends_in_order_hands_over_at_once(void **state)
{
    (void)state;
    pid_t one = start_one();
    collided *c = set_up();
    pid_t two = start_one(), active;
    for (bool is_followed = false; !is_followed;) {
        await_standby(c);
        swing(c, 0.1);
        int64_t epoch = m.epoch;
        m.longest_s = 0;
        active = active_one(c);
        rig_kill(active, SIGTERM);
        is_followed = followed(c, epoch);
        assert_int_equal(rig_wait(active, RIG_PATIENCE_S), 0);
        one = active == one ? two : one;
        if (!is_followed) two = start_one();
    }
    swing(c, 0.1);
    judge(c);
    printf("handed over: silence %.0f ms at most\n", 1e3 * m.longest_s);
    assert_true(rig_alive(one));
    rig_close(c);
}

/* A client that sleeps while one daemon is killed and the other takes over keeps what is its own, over either link. */
static void a_sleeping_client_keeps_what_is_its_own(void **state)
{
    const char *uri = *state;
    pid_t active = start_one();
    collided *c = rig_connect(uri, 2, COLLIDED_REMOVE), *sleeper = rig_connect(uri, 10, COLLIDED_REMOVE);
    heard h;
    collided_body part = rig_box(c, "part", 0.75);
    rig_box(sleeper, "table", 0);
    assert_int_equal(collided_sync(sleeper, RIG_PATIENCE_S), COLLIDED_OK);
    rig_watch(c, &h, "part");
    assert_int_equal(collided_sync(c, RIG_PATIENCE_S), COLLIDED_OK);
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    start_one();
    UNTIL(c, RIG_PATIENCE_S, has_standby(c));
    rig_kill(active, SIGKILL);
    UNTIL(c, RIG_PATIENCE_S, rig_move(c, part, 3, 0) == COLLIDED_OK && h.touching == 0);
    assert_string_equal(h.cause[COLLIDED_END], "motion");
    UNTIL(c, RIG_PATIENCE_S, rig_move(c, part, 0.75, 0) == COLLIDED_OK && h.touching == 1);
    assert_int_equal(h.kinds[COLLIDED_END], 1);
    THROUGHOUT(c, 2.5, h.touching == 1); /* longer than c's lease */
    rig_close(sleeper);
    UNTIL(c, RIG_PATIENCE_S, h.touching == 0);
    assert_string_equal(h.cause[COLLIDED_END], "removed");
    rig_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_killed_daemon_is_followed_without_a_lost_or_doubled_event, rig_end_all),
        cmocka_unit_test_teardown(a_stopped_daemon_that_comes_back_steps_down, rig_end_all),
        cmocka_unit_test_teardown(a_daemon_that_ends_in_order_hands_over_at_once, rig_end_all),
        OVER_BOTH(a_sleeping_client_keeps_what_is_its_own),
    };
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
