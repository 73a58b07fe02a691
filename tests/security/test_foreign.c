/* Another participant that speaks under a client's name, over DDS without certificates: refused, counted, and of no
 * effect, as long as the first one is alive. Over LCM nobody can be told apart. */
#include "raw_dds.h"
#include "rig.h"
#include "wire/one_shape.h"
#include "wire_dds/wire_dds.h"

#include <dds/dds.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double LEASE_S = 0.4; /* of those that are killed */

static collided *connect_as(int64_t id, double lease_s)
{
    collided_def def = collided_def_default();
    def.id = id;
    def.lease_s = lease_s;
    def.connect_timeout_s = RIG_PATIENCE_S;
    collided *c = collided_connect(RIG_DDS, &def);
    if (!c) fail_msg("%s", collided_connect_error());
    return c;
}

/* ---- what a stranger might send ---- */

static const one_shape far_box = {
    .pose = {100, 0, 0, 1}, .size = {0.5, 0.5, 0.5}, .in_body = {0, 0, 0, 1}, .type = {WIRE_SHAPE_BOX}};

static wire_message a_body(int32_t body, uint8_t removed)
{
    wire_message m = one_shape_body(&far_box, 0, 0, body, "part");
    m.body.removed = removed;
    return m;
}

static wire_message a_pose(const int32_t *body)
{
    return (wire_message){.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .bodies = {1, body},
            .positions = {3, far_box.pose},
            .orientations = {4, far_box.pose + 3}}};
}

static wire_message an_subscription(int32_t subscription, uint8_t removed)
{
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .subscription = subscription,
            .removed = removed,
            .facts = WIRE_FACT_TOUCH,
            .stream = "",
            .select_a = "nothing",
            .select_b = "nothing"}};
}

static wire_message a_client(uint8_t removed)
{
    return (wire_message){.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION, .removed = removed, .lease_ns = INT64_C(60000000000), .name = "thief"}};
}

static wire_message a_query(void)
{
    return (wire_message){
        .kind = WIRE_QUERY, .query = {.version = WIRE_VERSION, .kind = WIRE_QUERY_BODIES, .name_a = "*", .name_b = ""}};
}

/* dds_dispose: only the keys travel. */
static void dispose(raw_dds *raw, wire_message m)
{
    m.client.client = RAW_CLIENT;
    m.client.sequence = ++raw->sequence;
    void *sample = calloc(1, wire_dds_sample_size(m.kind));
    wire_dds_encode(&m, sample);
    assert_int_equal(dds_dispose(raw->writers[m.kind], sample), DDS_RETCODE_OK);
    free(sample);
}

/* ---- tests ---- */

static void a_foreign_participant_cannot_move_change_or_remove_anything(void **state)
{
    (void)state;
    const double lease_s = 1.5;
    heard heard;
    raw_dds raw;
    rig_daemon(NULL, NULL);
    collided *watcher = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE), *owner = connect_as(RAW_CLIENT, lease_s);
    rig_box(watcher, "table", 0);
    collided_body part = rig_box(owner, "part", 0.5);
    assert_int_equal(collided_sync(owner, RIG_PATIENCE_S), COLLIDED_OK);
    rig_watch(watcher, &heard, "part");
    UNTIL(watcher, RIG_PATIENCE_S, heard.touching == 1);
    raw_open(&raw);
    raw.sequence = INT64_MAX / 2; /* newer than all that the owner has said */
    wire_message messages[] = {a_pose(&part.id), a_body(part.id, 0), a_body(part.id, 1), a_body(part.id + 1, 0),
        an_subscription(0, 0), an_subscription(0, 1), a_client(0), a_client(1), a_query()};
    enum { MESSAGES = sizeof messages / sizeof messages[0] };
    for (int i = 0; i < MESSAGES; i++)
        assert_int_equal(raw_rejected(&raw, raw_send(&raw, &messages[i])), WIRE_NOT_YOURS);
    dispose(&raw, a_body(part.id, 0));
    dispose(&raw, a_client(0));
    UNTIL(watcher, RIG_PATIENCE_S, rig_counter(watcher, "dds_foreign") == MESSAGES + 2);
    UNTIL(watcher, RIG_PATIENCE_S, rig_counter(watcher, "reject_not_yours") == MESSAGES + 2);
    assert_int_equal(rig_counter(watcher, "bodies"), 2);
    THROUGHOUT(watcher, lease_s + 0.5, heard.touching == 1 && heard.kinds[COLLIDED_END] == 0);
    assert_int_equal(rig_move(owner, part, 5, 1), COLLIDED_OK); /* the owner moves it as ever */
    UNTIL(watcher, RIG_PATIENCE_S, heard.touching == 0);
    raw_close(&raw);
    collided_close(owner);
    rig_close(watcher);
}

/* In a process of its own, to be killed. */
static int own_a_part(const char *uri)
{
    collided_def def = collided_def_default();
    def.id = RAW_CLIENT;
    def.lease_s = LEASE_S;
    def.connect_timeout_s = RIG_PATIENCE_S;
    collided *c = collided_connect(uri, &def);
    if (!c) return 1;
    rig_box(c, "part", 0.5);
    collided_sync(c, RIG_PATIENCE_S);
    for (;;) pause();
}

static void a_stranger_under_its_name_hides_no_clients_death_and_comes_after_it(void **state)
{
    (void)state;
    heard heard;
    raw_dds raw;
    rig_daemon(NULL, NULL);
    collided *watcher = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    rig_box(watcher, "table", 0);
    rig_watch(watcher, &heard, "part");
    pid_t owner = rig_self("own", RIG_DDS, NULL);
    UNTIL(watcher, RIG_PATIENCE_S, heard.touching == 1);
    raw_open(&raw);
    raw.sequence = INT64_MAX / 2;
    wire_message m = a_client(0);
    assert_int_equal(raw_rejected(&raw, raw_send(&raw, &m)), WIRE_NOT_YOURS); /* it keeps the instance alive */
    rig_kill(owner, SIGKILL);
    UNTIL(watcher, RIG_PATIENCE_S, heard.touching == 0);
    assert_string_equal(heard.cause[COLLIDED_END], "owner_lost");
    UNTIL(watcher, RIG_PATIENCE_S, rig_counter(watcher, "bodies") == 1);
    int32_t body = 1;
    m = a_body(body, 0);
    raw_send(&raw, &m);
    UNTIL(watcher, RIG_PATIENCE_S, rig_counter(watcher, "bodies") == 2); /* now it is whoever comes first */
    raw_close(&raw);
    rig_close(watcher);
}

static void a_client_that_was_killed_comes_back_under_its_name_when_its_lease_is_over(void **state)
{
    (void)state;
    heard heard;
    rig_daemon(NULL, NULL);
    collided *watcher = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    rig_box(watcher, "table", 0);
    rig_watch(watcher, &heard, "part");
    pid_t owner = rig_self("own", RIG_DDS, NULL);
    UNTIL(watcher, RIG_PATIENCE_S, heard.touching == 1);
    rig_kill(owner, SIGKILL);
    collided *again = connect_as(RAW_CLIENT, 10); /* waits for it */
    rig_box(again, "part", 0.4);
    assert_int_equal(collided_sync(again, RIG_PATIENCE_S), COLLIDED_OK);
    UNTIL(watcher, RIG_PATIENCE_S, heard.touching == 1 && heard.kinds[COLLIDED_BEGIN] == 2);
    collided_close(again);
    rig_close(watcher);
}

static void a_client_of_dds_cannot_be_spoken_for_over_lcm(void **state)
{
    (void)state;
    rig_daemon(NULL, NULL);
    collided *owner = connect_as(RAW_CLIENT, 10);
    collided_body part = rig_box(owner, "part", 0.5);
    assert_int_equal(collided_sync(owner, RIG_PATIENCE_S), COLLIDED_OK);
    collided_def def = collided_def_default();
    def.id = RAW_CLIENT;
    double end = rig_now_s() + RIG_PATIENCE_S;
    do { /* without an answer it says that, too: on a busy machine it may not have come in time */
        def.connect_timeout_s = 1;
        assert_null(collided_connect(RIG_LCM, &def));
    } while (!strstr(collided_connect_error(), "not_yours") && rig_now_s() < end);
    if (!strstr(collided_connect_error(), "not_yours")) fail_msg("%s", collided_connect_error());
    UNTIL(owner, RIG_PATIENCE_S, rig_counter(owner, "bodies") == 1);
    rig_move(owner, part, 1, 1);
    collided_close(owner);
}

#define OVER_DDS(test)                                                                                                 \
    {                                                                                                                  \
#test, test, NULL, rig_end_all, NULL                                                                           \
    }

int main(int argc, char **argv)
{
    if (argc > 2 && strcmp(argv[1], "own") == 0) return own_a_part(argv[2]);
    const struct CMUnitTest tests[] = {OVER_DDS(a_foreign_participant_cannot_move_change_or_remove_anything),
        OVER_DDS(a_stranger_under_its_name_hides_no_clients_death_and_comes_after_it),
        OVER_DDS(a_client_that_was_killed_comes_back_under_its_name_when_its_lease_is_over),
        OVER_DDS(a_client_of_dds_cannot_be_spoken_for_over_lcm)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
