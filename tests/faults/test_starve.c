/* As many contacts at once as max_pairs allows, one subscriber that reads, and one that does not read for long: the
 * first one has everything in order and without a loss. The other one learns that it is behind, the daemon's health
 * says so to everybody else, and when it reads again it comes to know what the first one knows. For nobody a contact
 * begins twice, or ends twice. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BALLS_MOST = 700, MOVED = 10, STEPS = 60, IDS_MOST = 1 << 20 };

typedef enum fate { NEVER, BEGUN, ENDED } fate;

typedef struct reader {
    const char *name;
    unsigned char fates[IDS_MOST];               /* by contact id; of each subscription its own */
    unsigned char touch[BALLS_MOST][BALLS_MOST]; /* who with whom, now */
    size_t touching, notices;
    int64_t lost, step, behind, batch;
    bool snapshot;
} reader;

static reader quick, slow;

static int balls;

static size_t pairs(void)
{
    return (size_t)balls * (size_t)(balls - 1) / 2;
}

/* How many contacts a pair has. Where one of its contacts ends and the next one begins in a batch, either may come
 * first. */
static void note(reader *r, const collided_event *e, bool touches)
{
    int a = atoi(e->name_a + strlen("ball ")), b = atoi(e->name_b + strlen("ball "));
    unsigned char *count = &r->touch[a < b ? a : b][a < b ? b : a];
    *count = (unsigned char)(*count + (touches ? 1 : -1));
}

/* What is not among a snapshot's ended before, and cannot begin again. */
static void forget_all_but(reader *r, const collided_batch *b)
{
    static unsigned char now[IDS_MOST];
    memset(now, 0, sizeof now);
    memset(r->touch, 0, sizeof r->touch);
    for (size_t i = 0; i < b->event_count; i++) {
        int64_t id = b->events[i].contact;
        if (now[id]++) fail_msg("%s: %lld is twice in a snapshot", r->name, (long long)id);
        note(r, &b->events[i], true);
        if (r->fates[id] == ENDED) fail_msg("%s: %lld had ended", r->name, (long long)id);
    }
    for (int64_t id = 0; id < IDS_MOST; id++)
        r->fates[id] = now[id] ? BEGUN : r->fates[id] == BEGUN ? ENDED : r->fates[id];
    r->touching = b->event_count;
    r->snapshot = true;
}

static void follow(reader *r, const collided_event *e)
{
    unsigned char *at = &r->fates[e->contact];
    unsigned char before = e->kind == COLLIDED_BEGIN ? NEVER : BEGUN;
    if (*at != before) fail_msg("%s: kind %d of contact %lld", r->name, (int)e->kind, (long long)e->contact);
    *at = e->kind == COLLIDED_END ? ENDED : BEGUN;
    if (e->kind == COLLIDED_BEGIN || e->kind == COLLIDED_END) note(r, e, e->kind == COLLIDED_BEGIN);
    r->touching += e->kind == COLLIDED_BEGIN;
    r->touching -= e->kind == COLLIDED_END;
}

static void hear(void *context, const collided_batch *b)
{
    reader *r = context;
    r->lost += b->lost;
    r->notices += b->starved;
    if (b->behind > r->behind) r->behind = b->behind;
    if (b->starved) return;
    if (b->step > r->step && !(b->heartbeat && b->behind)) r->step = b->step; /* a step may bring nothing about */
    if (b->heartbeat) return;
    if (r->batch && !b->snapshot && !b->lost && b->batch <= r->batch) fail_msg("%s: out of order", r->name);
    r->batch = b->batch;
    if (b->snapshot)
        forget_all_but(r, b);
    else
        for (size_t i = 0; i < b->event_count; i++) follow(r, &b->events[i]);
}

static void watch(collided *c, reader *r, const char *name)
{
    memset(r, 0, sizeof *r);
    r->name = name;
    collided_subscription_def def = collided_subscription_def_default();
    def.stream = name;
    def.accuracy = COLLIDED_BY_VERDICT;
    def.callback = hear;
    def.context = r;
    assert_int_not_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
}

static collided_body bodies[BALLS_MOST];

/* All at one place, to come apart in no way that matters: each touches each. */
static void make_balls(collided *c)
{
    collided_shape ball = collided_sphere(1);
    collided_body_def def = collided_body_def_default();
    def.shapes = &ball;
    def.shape_count = 1;
    for (int i = 0; i < balls; i++) {
        char name[16];
        snprintf(name, sizeof name, "ball %d", i);
        def.name = name;
        def.pose.position[0] = 1e-3 * i;
        bodies[i] = collided_create_body(c, &def);
        assert_int_not_equal(bodies[i].id, COLLIDED_NONE);
    }
}

static void begin(bool all)
{
    char most[32];
    balls = getenv("COLLIDED_NIGHTLY") || (all && !getenv("COLLIDED_BRIEF")) ? BALLS_MOST : 300;
    snprintf(most, sizeof most, "%zu", pairs() + pairs() / 3 + 2); /* a quarter is kept for other owners */
    rig_daemon("--max-pairs", most);
}

static void all_at_once_arrive(void **state)
{
    begin(true);
    collided *c = rig_connect(*state, 60, COLLIDED_REMOVE);
    collided *late = rig_connect(*state, 60, COLLIDED_REMOVE);
    watch(c, &quick, "quick");
    UNTIL(c, RIG_PATIENCE_S, quick.snapshot);
    double began = rig_now_s();
    make_balls(c);
    UNTIL(c, 2 * RIG_PATIENCE_S, quick.touching == pairs());
    double events_s = rig_now_s() - began;
    watch(late, &slow, "late");
    began = rig_now_s();
    UNTIL(late, 2 * RIG_PATIENCE_S, slow.touching == pairs());
    printf("%zu contacts at once: as events after %.2f s (with their bodies), as a snapshot after %.2f s\n", pairs(),
        events_s, rig_now_s() - began);
    if (strncmp(*state, "dds", 3) == 0) assert_int_equal(quick.lost + slow.lost, 0); /* LCM may lose, and told of it */
    assert_memory_equal(quick.touch, slow.touch, sizeof quick.touch);
    rig_close(c);
    rig_close(late);
}

/* Some leave all others, or come back to them. */
static void move(collided *c, int64_t step)
{
    double positions[3 * MOVED] = {0}, orientations[4 * MOVED] = {0};
    for (int i = 0; i < MOVED; i++) {
        positions[3 * i] = step % 2 ? 1e4 * (i + 1) : 1e-3 * i;
        orientations[4 * i] = 1;
    }
    assert_int_equal(collided_publish(c, MOVED, bodies, positions, orientations, NULL, NULL, 0, step), COLLIDED_OK);
}

static bool health_is(collided *c, const char *health, const char *limit)
{
    collided_daemon_status s;
    if (collided_get_status(c, RIG_PATIENCE_S, &s) != COLLIDED_OK) return false;
    return strcmp(s.health, health) == 0 && (!*limit ? !*s.limits : strstr(s.limits, limit) != NULL);
}

static void who_reads_late_comes_to_know_it_and_says_so(void **state)
{
    begin(false);
    collided *c = rig_connect(*state, 60, COLLIDED_REMOVE), *late = rig_connect(*state, 60, COLLIDED_REMOVE);
    watch(c, &quick, "quick");
    watch(late, &slow, "slow");
    UNTIL(c, RIG_PATIENCE_S, quick.snapshot);
    UNTIL(late, RIG_PATIENCE_S, slow.snapshot);
    UNTIL(c, RIG_PATIENCE_S, health_is(c, "ready", ""));
    make_balls(c); /* from here on, the other one does not read */
    UNTIL(c, 2 * RIG_PATIENCE_S, quick.touching == pairs());
    for (int64_t step = 1; step <= STEPS; step++) {
        move(c, step);
        UNTIL(c, RIG_PATIENCE_S, quick.step == step);
    }
    assert_int_equal(quick.lost, 0);
    UNTIL(c, RIG_PATIENCE_S, health_is(c, "degraded", "stream slow"));
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "streams_starving") == 1 && rig_counter(c, "streams_behind") == 1);
    double began = rig_now_s();
    UNTIL(late, 2 * RIG_PATIENCE_S, slow.step == STEPS && slow.touching == pairs());
    printf("read again: up to date after %.2f s; %lld batches were skipped, up to %lld waited\n", rig_now_s() - began,
        (long long)slow.lost, (long long)slow.behind);
    assert_true(slow.behind > 0); /* whether some were skipped, too, is a matter of time */
    if (slow.lost) assert_non_null(strstr(collided_error(late), "stream 'slow'"));
    assert_memory_equal(quick.touch, slow.touch, sizeof quick.touch);
    UNTIL(late, RIG_PATIENCE_S, health_is(late, "ready", ""));
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "streams_behind") == 0);
    assert_int_equal(quick.lost, 0);
    int64_t lost = slow.lost;
    for (int64_t step = STEPS + 1; step <= STEPS + 10; step++) { /* and keeps up */
        move(c, step);
        UNTIL(c, RIG_PATIENCE_S, quick.step == step);
        UNTIL(late, RIG_PATIENCE_S, slow.step == step);
    }
    assert_int_equal(slow.lost, lost);
    assert_memory_equal(quick.touch, slow.touch, sizeof quick.touch);
    rig_close(c);
    rig_close(late);
}

static bool has_standby(collided *c)
{
    collided_daemon_status s;
    return collided_get_status(c, 1, &s) == COLLIDED_OK && strstr(s.links, "active, hot standby: ");
}

static pid_t active_one(collided *c)
{
    collided_daemon_status s;
    assert_int_equal(collided_get_status(c, RIG_PATIENCE_S, &s), COLLIDED_OK);
    const char *colon = strrchr(s.daemon, ':');
    assert_non_null(colon);
    return (pid_t)atoi(colon + 1);
}

/* The active daemon is gone while one reads a snapshot in part, and has not read for long before. */
static void a_standby_sends_what_is_missing(void **state)
{
    balls = 300;
    rig_one_of_a_pair(NULL);
    collided *c = rig_connect(*state, 60, COLLIDED_REMOVE), *late = rig_connect(*state, 60, COLLIDED_REMOVE);
    watch(c, &quick, "quick");
    watch(late, &slow, "slow");
    UNTIL(c, RIG_PATIENCE_S, quick.snapshot);
    UNTIL(late, RIG_PATIENCE_S, slow.snapshot);
    make_balls(c);
    UNTIL(c, 2 * RIG_PATIENCE_S, quick.touching == pairs());
    rig_one_of_a_pair(NULL);
    UNTIL(c, 2 * RIG_PATIENCE_S, has_standby(c));
    for (int64_t step = 1; step <= STEPS / 2; step++) {
        move(c, step);
        UNTIL(c, RIG_PATIENCE_S, quick.step == step);
    }
    collided_poll(late, 0.01);
    rig_kill(active_one(c), SIGKILL);
    for (int64_t step = STEPS / 2 + 1; step <= STEPS; step++) {
        move(c, step);
        collided_poll(c, 0.02);
    }
    UNTIL(c, 2 * RIG_PATIENCE_S, quick.step == STEPS && quick.touching == pairs());
    UNTIL(late, 2 * RIG_PATIENCE_S, slow.step == STEPS && slow.touching == pairs());
    assert_memory_equal(quick.touch, slow.touch, sizeof quick.touch);
    rig_close(c);
    rig_close(late);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER_BOTH(all_at_once_arrive),
        OVER_BOTH(who_reads_late_comes_to_know_it_and_says_so), OVER(a_standby_sends_what_is_missing, RIG_DDS)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
