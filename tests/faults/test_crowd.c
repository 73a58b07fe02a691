/* Crowds over DDS on loopback: many processes that start at once all come in; they find the daemon and not each other;
 * a limit that they reach is named at both ends; and a participant of another vendor finds the daemon. */
#include "rig.h"

#include <dds/dds.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { DOMAIN = 61 /* of RIG_DDS */, CROWD = 60, CROWD_NIGHTLY = 200, FOREIGN = 20 };

static int crowd_size(void)
{
    return getenv("COLLIDED_NIGHTLY") ? CROWD_NIGHTLY : CROWD;
}

/* ---- one of a crowd ---- */

static void on_batch(void *context, const collided_batch *b)
{
    (void)context;
    (void)b;
}

static bool create_cube(collided *c, const char *name)
{
    collided_shape cube = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &cube;
    def.shape_count = 1;
    return collided_create_body(c, &def).id != COLLIDED_NONE;
}

/* A second body says that the first is acknowledged and that the stream has begun. */
static int be_one(const char *uri, const char *number)
{
    char name[64];
    collided_def def = collided_def_default();
    collided_interest_def watch = collided_interest_def_default();
    def.connect_timeout_s = 4 * RIG_PATIENCE_S;
    collided *c = collided_connect(uri, &def);
    if (!c) return fprintf(stderr, "%s: %s\n", number, collided_connect_error()), 1;
    snprintf(name, sizeof name, "first of %s", number);
    watch.select_a = name;
    watch.callback = on_batch;
    if (!create_cube(c, name) || collided_subscribe(c, &watch).id == COLLIDED_NONE ||
        collided_sync(c, 4 * RIG_PATIENCE_S) != COLLIDED_OK)
        return fprintf(stderr, "%s: %s\n", number, collided_error(c)), 1;
    snprintf(name, sizeof name, "second of %s", number);
    if (!create_cube(c, name)) return 1;
    for (;;) collided_poll(c, 1); /* until it is ended */
}

/* ---- tests ---- */

/* Of all that this process's participant knows, itself included. */
static size_t participants(void)
{
    enum { MOST = 512 };
    static void *samples[MOST];
    static dds_sample_info_t infos[MOST];
    dds_entity_t own[8];
    assert_int_equal(dds_lookup_participant(DOMAIN, own, 8), 1);
    dds_entity_t reader = dds_create_reader(own[0], DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL);
    assert_true(reader > 0);
    int n = dds_read(reader, samples, infos, MOST, MOST);
    size_t alive = 0;
    for (int i = 0; i < n; i++) alive += infos[i].valid_data && infos[i].instance_state == DDS_IST_ALIVE;
    if (n > 0) dds_return_loan(reader, samples, n);
    dds_delete(reader);
    return alive;
}

static void a_crowd_comes_in_and_knows_nobody_but_the_daemon(void **state)
{
    (void)state;
    enum { MOST = CROWD_NIGHTLY };
    static pid_t crowd[MOST];
    int size = crowd_size();
    char number[16];
    rig_daemon("--max_clients", "1000");
    collided *watcher = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    for (int i = 0; i < size; i++) {
        snprintf(number, sizeof number, "%d", i);
        crowd[i] = rig_self("one", RIG_DDS, number);
    }
    UNTIL(watcher, 4 * RIG_PATIENCE_S, rig_counter(watcher, "bodies") == 2 * (int64_t)size);
    for (int i = 0; i < size; i++) assert_true(rig_alive(crowd[i]));
    assert_int_equal(participants(), 2); /* the daemon's, and our own */
    rig_close(watcher);
}

static void a_limit_is_named_at_both_ends(void **state)
{
    (void)state;
    enum { MOST = 3 };
    collided *clients[MOST];
    collided_def def = collided_def_default();
    collided_daemon_status s;
    rig_daemon("--max_clients", "3");
    for (int i = 0; i < MOST; i++) clients[i] = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    def.connect_timeout_s = RIG_PATIENCE_S;
    assert_null(collided_connect(RIG_DDS, &def));
    if (!strstr(collided_connect_error(), "max_clients = 3")) fail_msg("%s", collided_connect_error());
    UNTIL(clients[0], RIG_PATIENCE_S,
        collided_get_status(clients[0], RIG_PATIENCE_S, &s) == COLLIDED_OK && strstr(s.limits, "max_clients"));
    for (int i = 0; i < MOST; i++) rig_close(clients[i]);
}

/* A client has no port that a new daemon would know of: it has to say that it is here. */
static void a_daemon_that_comes_later_is_found(void **state)
{
    (void)state;
    pid_t daemon = rig_daemon(NULL, NULL);
    collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    rig_box(c, "stays", 0);
    for (int i = 0; i < 3; i++) {
        UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "bodies") == 1);
        rig_kill(daemon, SIGKILL);
        UNTIL(c, RIG_PATIENCE_S, collided_poll(c, 0) == COLLIDED_NO_DAEMON);
        daemon = rig_daemon(NULL, NULL);
        double began = rig_now_s();
        UNTIL(c, RIG_PATIENCE_S, collided_poll(c, 0) == COLLIDED_OK);
        print_message("a daemon that began again was heard after %.2f s\n", rig_now_s() - began);
        UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "bodies") == 1);
    }
    rig_close(c);
}

#ifdef FAST_DDS
static void another_vendor_finds_the_daemon(void **state)
{
    (void)state;
    const char *const arguments[] = {"fast_dds", "61", "30", NULL};
    double longest = 0;
    rig_daemon(NULL, NULL);
    rig_close(rig_connect(RIG_DDS, 10, COLLIDED_REMOVE));
    for (int i = 0; i < FOREIGN; i++) {
        double began = rig_now_s();
        assert_int_equal(rig_wait(rig_start(FAST_DDS, arguments), 2 * RIG_PATIENCE_S), 0);
        if (rig_now_s() - began > longest) longest = rig_now_s() - began;
    }
    print_message(
        "Fast DDS found the daemon %d times, in %.2f s at most, with its start and its end\n", FOREIGN, longest);
    assert_true(longest < 5); /* it was up to 8 s; what it is, the line above says */
}
#endif

int main(int argc, char **argv)
{
    if (argc == 4) return be_one(argv[2], argv[3]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_crowd_comes_in_and_knows_nobody_but_the_daemon, rig_end_all),
        cmocka_unit_test_teardown(a_limit_is_named_at_both_ends, rig_end_all),
        cmocka_unit_test_teardown(a_daemon_that_comes_later_is_found, rig_end_all),
#ifdef FAST_DDS
        cmocka_unit_test_teardown(another_vendor_finds_the_daemon, rig_end_all),
#endif
    };
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
