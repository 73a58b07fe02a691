/* Silence is noticed. In an open domain packets are forged in the name of a client's writers, and of the daemon's: what
 * they write from then on is taken for old. The daemon counts it, its health says so, the client is told, and both are
 * heard again a moment later; so is who publishes once and then no more. */
#include "rig.h"

#include "raw_rtps.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct cell {
    collided *c, *watcher;
    collided_body mover;
    heard moves;
    int told;
    pid_t daemon;
} cell;

static void on_rejected(void *context, const collided_rejection *why)
{
    cell *l = context;
    l->told += strcmp(why->reason, "unheard") == 0;
}

static void cell_open(cell *l)
{
    l->daemon = rig_daemon(NULL, NULL);
    l->c = rig_connect(RIG_DDS, 3, COLLIDED_REMOVE);
    collided_on_rejected(l->c, on_rejected, l);
    rig_box(l->c, "block", 10);
    l->mover = rig_box(l->c, "mover", 10.5);
    l->watcher = rig_connect(RIG_DDS, 3, COLLIDED_REMOVE);
    rig_watch(l->watcher, &l->moves, "mover");
    UNTIL(l->watcher, RIG_PATIENCE_S, l->moves.touching == 1);
    rig_move(l->c, l->mover, 10.51, 1);
    collided_flush(l->c);
    UNTIL(l->watcher, RIG_PATIENCE_S, l->moves.step == 1);
    /* until the daemon has heard a word of the client's: what was before that is not missed */
    UNTIL(l->watcher, RIG_PATIENCE_S, rig_counter(l->watcher, "in_Receipt") >= 4);
}

typedef void forging(const raw_guid *writer, const raw_guid *reader);

/* Of each writer of the topic to each reader of another process, or of this one. */
static size_t forge_all(const char *topic, bool own_writers, forging *forge)
{
    raw_guid writers[RAW_GUIDS_MAX], readers[RAW_GUIDS_MAX];
    size_t from = raw_writers(topic, own_writers, writers), to = raw_readers(topic, !own_writers, readers);
    for (int times = 0; times < 3; times++)
        for (size_t i = 0; i < from * to; i++) forge(&writers[i / to], &readers[i % to]);
    return from * to;
}

static bool is_degraded(collided *c)
{
    collided_daemon_status s;
    return collided_get_status(c, 1, &s) == COLLIDED_OK && strcmp(s.health, "degraded") == 0 &&
           strstr(s.limits, "is alive, and what it publishes does not come");
}

static bool is_ready(collided *c)
{
    collided_daemon_status s;
    return collided_get_status(c, 1, &s) == COLLIDED_OK && strcmp(s.health, "ready") == 0;
}

/* It publishes once more, and then nothing. */
static void poses_are_missed(forging *forge)
{
    cell l = {0};
    cell_open(&l);
    assert_true(forge_all("collided_PoseBatch", true, forge) > 0);
    rig_move(l.c, l.mover, 20, 2);
    collided_flush(l.c);
    UNTIL(l.watcher, RIG_PATIENCE_S, rig_counter(l.watcher, "unheard") >= 1);
    UNTIL(l.c, RIG_PATIENCE_S, l.told >= 1);
    UNTIL(l.watcher, RIG_PATIENCE_S, l.moves.touching == 0); /* the pose that was lost has come */
    UNTIL(l.watcher, RIG_PATIENCE_S, is_ready(l.watcher) && rig_counter(l.watcher, "clients_unheard") == 0);
    rig_move(l.c, l.mover, 10.5, 3); /* and those that follow do, too */
    collided_flush(l.c);
    UNTIL(l.watcher, RIG_PATIENCE_S, l.moves.touching == 1);
    assert_true(rig_counter(l.c, "client_renewals") >= 1);
    rig_close(l.c);
    rig_close(l.watcher);
}

static void poses_behind_a_forged_heartbeat_are_missed_and_come_again(void **state)
{
    (void)state;
    poses_are_missed(raw_forge_heartbeat);
}

static void poses_behind_a_forged_gap_are_missed_and_come_again(void **state)
{
    (void)state;
    poses_are_missed(raw_forge_gap);
}

/* Whoever forges on keeps it silent, but not in silence. */
static void a_client_that_is_kept_silent_is_named_in_the_health(void **state)
{
    (void)state;
    cell l = {0};
    cell_open(&l);
    double end = rig_now_s() + RIG_PATIENCE_S;
    int degraded = 0;
    for (int64_t step = 2; degraded < 3 && rig_now_s() < end; step++) {
        forge_all("collided_PoseBatch", true, raw_forge_heartbeat);
        rig_move(l.c, l.mover, 10.5 + 0.001 * (double)step, step);
        collided_flush(l.c);
        collided_poll(l.c, 0.05);
        collided_poll(l.watcher, 0.05);
        degraded += is_degraded(l.watcher);
    }
    assert_int_equal(degraded, 3);
    assert_true(l.told >= 1);
    rig_close(l.c);
    rig_close(l.watcher);
}

/* No word comes, no announcement and no pose: liveliness is all that is left of the client. */
static void a_client_of_which_nothing_comes_is_missed(void **state)
{
    (void)state;
    static const char *const topics[] = {"collided_PoseBatch", "collided_Receipt", "collided_Body"};
    cell l = {0};
    cell_open(&l);
    for (size_t i = 0; i < sizeof topics / sizeof *topics; i++)
        assert_true(forge_all(topics[i], true, raw_forge_heartbeat) > 0);
    rig_move(l.c, l.mover, 20, 2);
    rig_box(l.c, "second", 0);
    collided_flush(l.c);
    UNTIL(l.watcher, RIG_PATIENCE_S, rig_counter(l.watcher, "unheard") >= 1);
    UNTIL(l.watcher, RIG_PATIENCE_S, l.moves.touching == 0 && rig_counter(l.watcher, "bodies") == 3);
    UNTIL(l.c, RIG_PATIENCE_S, l.told >= 1);
    rig_close(l.c);
    rig_close(l.watcher);
}

typedef struct reader {
    int starved;
    size_t events;
} reader;

static void on_events(void *context, const collided_batch *b)
{
    reader *r = context;
    r->starved += b->starved;
    r->events += b->event_count;
}

/* The daemon's own writer of a stream: its reader notices, says so, and hears again. */
static void a_stream_that_is_silenced_is_read_anew(void **state)
{
    (void)state;
    cell l = {0};
    reader r = {0};
    cell_open(&l);
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = on_events;
    def.context = &r;
    def.select_a = "mover";
    collided_subscribe(l.watcher, &def);
    UNTIL(l.watcher, RIG_PATIENCE_S, r.events == 1);
    assert_true(forge_all("collided_EventBatch", false, raw_forge_heartbeat) >= 2);
    rig_move(l.c, l.mover, 20, 2);
    collided_flush(l.c);
    UNTIL(l.watcher, RIG_PATIENCE_S, r.starved >= 1 && l.moves.touching == 0);
    assert_true(rig_counter(l.watcher, "client_silent_streams") >= 1);
    size_t before = r.events;
    rig_move(l.c, l.mover, 10.5, 3);
    collided_flush(l.c);
    UNTIL(l.watcher, RIG_PATIENCE_S, l.moves.touching == 1 && r.events > before);
    rig_close(l.c);
    rig_close(l.watcher);
}

#define TEST(test) cmocka_unit_test_teardown(test, rig_end_all)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(poses_behind_a_forged_heartbeat_are_missed_and_come_again),
        TEST(poses_behind_a_forged_gap_are_missed_and_come_again),
        TEST(a_client_that_is_kept_silent_is_named_in_the_health),
        TEST(a_client_of_which_nothing_comes_is_missed),
        TEST(a_stream_that_is_silenced_is_read_anew),
    };
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
