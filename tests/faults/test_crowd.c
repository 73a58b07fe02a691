/* Crowds over DDS on loopback: many processes that start at once all come in; they find the daemon and not each other;
 * a limit that they reach is named at both ends; and a participant of another vendor finds the daemon. On a network,
 * too, clients do not hear each other; and who gives turns to join cannot be made to give none. */
#include "crowd.h"
#include "rig.h"

#include <dds/dds.h>
#include <errno.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

enum { DOMAIN = 61 /* of RIG_DDS */, CROWD = 60, CROWD_NIGHTLY = 200, FOREIGN = 20 };

static int crowd_size(void)
{
    return getenv("COLLIDED_NIGHTLY") ? CROWD_NIGHTLY : CROWD;
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

/* Of all readers, or writers, of this process's participant that are of that topic: who they are matched with. */
static int matched(const char *topic, bool readers)
{
    enum { MOST = 256 };
    dds_entity_t own[8], parents[MOST], ends[MOST];
    dds_instance_handle_t others[MOST];
    char name[64];
    int count = 0;
    assert_int_equal(dds_lookup_participant(DOMAIN, own, 8), 1);
    int parent_count = dds_get_children(own[0], parents, MOST);
    for (int i = 0; i < parent_count; i++) {
        int end_count = dds_get_children(parents[i], ends, MOST);
        for (int k = 0; k < end_count; k++) {
            dds_entity_t t = dds_get_topic(ends[k]);
            if (t <= 0 || dds_get_name(t, name, sizeof name) <= 0 || strcmp(name, topic) != 0) continue;
            int n = readers ? dds_get_matched_publications(ends[k], others, MOST)
                            : dds_get_matched_subscriptions(ends[k], others, MOST);
            if (n > 0) count += n;
        }
    }
    return count;
}

/* Each match of a reader of a client's with one of the daemon's writers that others read, too, costs the daemon, for
 * each client that comes, a time that grows with their square. */
static void is_matched_with_few_of_the_daemons_ends(void)
{
    static const char *const readers[] = {"collided_Ack", "collided_Reject", "collided_Answer", "collided_Status"};
    static const char *const writers[] = {"collided_Client", "collided_Geometry", "collided_Body",
        "collided_Subscription", "collided_PoseBatch", "collided_Query", "collided_Receipt"};
    for (size_t i = 0; i < sizeof readers / sizeof readers[0]; i++) {
        bool answers = strcmp(readers[i], "collided_Answer") == 0; /* those of many hits have a writer of their own */
        assert_int_equal(matched(readers[i], true), answers ? 2 : 1);
    }
    for (size_t i = 0; i < sizeof writers / sizeof writers[0]; i++) assert_int_equal(matched(writers[i], false), 1);
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
    UNTIL(watcher, 4 * RIG_PATIENCE_S, crowd_counter(watcher, "bodies") == CROWD_BODIES * (int64_t)size);
    for (int i = 0; i < size; i++) assert_true(rig_alive(crowd[i]));
    assert_int_equal(participants(), 2); /* the daemon's, and our own */
    is_matched_with_few_of_the_daemons_ends();
    rig_close(watcher);
}

/* Loopback stands in for a network, by name: there it has multicast. */
static void clients_on_a_network_do_not_hear_each_other(void **state)
{
    (void)state;
    enum { SIZE = 5 };
    char number[16];
    collided_def def = collided_def_default();
    rig_daemon("--interface", "lo");
    def.interface = "lo";
    def.connect_timeout_s = RIG_PATIENCE_S;
    collided *watcher = collided_connect(RIG_DDS, &def);
    if (!watcher) fail_msg("%s", collided_connect_error());
    for (int i = 0; i < SIZE; i++) {
        snprintf(number, sizeof number, "%d", i);
        rig_self("wide", RIG_DDS, number);
    }
    UNTIL(watcher, 4 * RIG_PATIENCE_S, crowd_counter(watcher, "bodies") == CROWD_BODIES * SIZE);
    assert_int_equal(participants(), 2);
    rig_close(watcher);
}

/* ---- streams of many ---- */

/* Of that topic, all that this process's participant has heard of. */
static int writers_of(const char *topic)
{
    enum { MOST = 1024 };
    static void *samples[MOST];
    static dds_sample_info_t infos[MOST];
    dds_entity_t own[8];
    int count = 0;
    assert_true(dds_lookup_participant(DOMAIN, own, 8) > 0);
    dds_entity_t reader = dds_create_reader(own[0], DDS_BUILTIN_TOPIC_DCPSPUBLICATION, NULL, NULL);
    assert_true(reader > 0);
    int n = dds_read(reader, samples, infos, MOST, MOST);
    for (int i = 0; i < n; i++) {
        const dds_builtintopic_endpoint_t *writer = samples[i];
        count += infos[i].valid_data && infos[i].instance_state == DDS_IST_ALIVE && !strcmp(writer->topic_name, topic);
    }
    if (n > 0) dds_return_loan(reader, samples, n);
    dds_delete(reader);
    return count;
}

typedef struct tally {
    int begins, ends;
} tally;

static void count_events(void *context, const collided_batch *b)
{
    tally *t = context;
    for (size_t i = 0; i < b->event_count; i++) {
        t->begins += b->events[i].kind == COLLIDED_BEGIN;
        t->ends += b->events[i].kind == COLLIDED_END;
    }
}

static void subscribe(collided *c, const char *name, tally *t)
{
    collided_subscription_def watch = collided_subscription_def_default();
    watch.select_a = name;
    watch.callback = count_events;
    watch.context = t;
    assert_true(collided_subscribe(c, &watch).id != COLLIDED_NONE);
}

static void streams_of_many_share_writers_and_each_is_told_his(void **state)
{
    (void)state;
    enum { MANY = 60, FEW = 20 };
    tally others[MANY] = {{0}}, mine[FEW] = {{0}};
    char name[32];
    rig_daemon(NULL, NULL);
    collided *a = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE), *b = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    for (int i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "other %d", i);
        subscribe(a, name, &others[i]);
    }
    assert_int_equal(collided_sync(a, RIG_PATIENCE_S), COLLIDED_OK);
    for (int i = 0; i < FEW; i++) {
        snprintf(name, sizeof name, "mine %d", i);
        subscribe(b, name, &mine[i]);
    }
    assert_int_equal(collided_sync(b, RIG_PATIENCE_S), COLLIDED_OK);
    assert_in_range(writers_of("collided_EventBatch"), 1, MANY / 2);
    collided_body there = rig_box(b, "mine 19", 0), here = rig_box(b, "wall", 0.5);
    UNTIL(b, RIG_PATIENCE_S, mine[19].begins == 1);
    rig_move(b, there, 5, 0);
    UNTIL(b, RIG_PATIENCE_S, mine[19].ends == 1);
    for (int i = 0; i < FEW - 1; i++) assert_int_equal(mine[i].begins + mine[i].ends, 0);
    collided_remove_body(b, here);
    rig_box(a, "other 59", 5);
    UNTIL(a, RIG_PATIENCE_S, others[59].begins == 1);
    for (int i = 0; i < MANY - 1; i++) assert_int_equal(others[i].begins, 0);
    UNTIL(b, RIG_PATIENCE_S, mine[19].begins == 2); /* of both, seen from the other side */
    rig_close(a);
    rig_close(b);
}

typedef struct pulse {
    int heartbeats;
} pulse;

static void count_heartbeats(void *context, const collided_batch *b)
{
    ((pulse *)context)->heartbeats += b->heartbeat;
}

static bool all_beat(const pulse *pulses, int count, int each)
{
    for (int i = 0; i < count; i++)
        if (pulses[i].heartbeats < each) return false;
    return true;
}

/* So many that the daemon lets heartbeats wait for each other: each comes all the same. */
static void heartbeats_of_many_streams_come(void **state)
{
    (void)state;
    enum { MANY = 320, EACH = 3 };
    static pulse pulses[MANY];
    char name[32];
    memset(pulses, 0, sizeof pulses);
    rig_daemon(NULL, NULL);
    collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    for (int i = 0; i < MANY; i++) {
        collided_subscription_def watch = collided_subscription_def_default();
        snprintf(name, sizeof name, "body %d", i);
        watch.select_a = name;
        watch.callback = count_heartbeats;
        watch.context = &pulses[i];
        assert_true(collided_subscribe(c, &watch).id != COLLIDED_NONE);
    }
    assert_int_equal(collided_sync(c, 2 * RIG_PATIENCE_S), COLLIDED_OK);
    UNTIL(c, 2 * RIG_PATIENCE_S, all_beat(pulses, MANY, EACH));
    rig_close(c);
}

/* What a stream tells first is told before its reader has heard a heartbeat of RTPS, and lost then: the daemon sends
 * one soon after. Each of these waited for half a second. */
static void a_stream_begins_soon(void **state)
{
    (void)state;
    enum { TIMES = 15 };
    tally t = {0};
    rig_daemon(NULL, NULL);
    double began = rig_now_s();
    for (int i = 0; i < TIMES; i++) {
        collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
        subscribe(c, "any", &t);
        assert_int_equal(collided_sync(c, RIG_PATIENCE_S), COLLIDED_OK);
        rig_close(c);
    }
    double took = rig_now_s() - began;
    print_message("%d clients came, read a stream, and left, in %.2f s\n", TIMES, took);
    assert_true(took < TIMES);
}

/* ---- turns ---- */

static int ask_for_a_turn(void)
{
    const char name[] = "\0collided/turns/61"; /* DOMAIN; of the abstract namespace */
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    socklen_t length = offsetof(struct sockaddr_un, sun_path) + sizeof name - 1;
    memcpy(address.sun_path, name, sizeof name - 1);
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (connect(fd, (struct sockaddr *)&address, length) != 0) fail_msg("%s", strerror(errno));
    return fd;
}

/* The next word: wire_dds_turn.h. */
static char hear(int fd)
{
    char word = 0;
    return read(fd, &word, 1) == 1 ? word : 0;
}

typedef struct greeting {
    char word, crowd, room;
} greeting;

static greeting greeted(int fd)
{
    greeting g = {0};
    assert_int_equal(recv(fd, &g, sizeof g, MSG_WAITALL), sizeof g);
    return g;
}

/* What two ask for at the same time Cyclone sends to everybody who is there: so one has it to himself. */
static void turns_are_given_one_by_one(void **state)
{
    (void)state;
    enum { MANY = 12 /* that are in no room */ };
    const double patience_s = 0.08; /* below that of the daemon, who gives the next turn when one takes very long */
    int asks[MANY], checked = 0;
    rig_daemon(NULL, NULL);
    rig_close(rig_connect(RIG_DDS, 10, COLLIDED_REMOVE)); /* it is ready */
    for (int i = 0; i < MANY; i++) {
        asks[i] = ask_for_a_turn();
        greeting g = greeted(asks[i]);
        assert_int_equal(g.word, 'w');
        assert_int_equal(g.room, 0);
    }
    for (int i = 0; i < MANY; i++) {
        char early;
        double began = rig_now_s();
        assert_int_equal(hear(asks[i]), 'c');
        bool none = i + 1 == MANY || recv(asks[i + 1], &early, 1, MSG_DONTWAIT | MSG_PEEK) < 0;
        bool soon = i > 0 && rig_now_s() - began < patience_s; /* the first one's turn began before we looked */
        if (soon) assert_true(none);
        checked += soon;
        close(asks[i]);
    }
    assert_true(checked > 0);
}

/* Who asks for turns and never comes holds up the others for as long as a turn may take, and no longer. */
static void turns_go_on_though_some_never_come(void **state)
{
    (void)state;
    enum { IDLE = 5 };
    int idle[IDLE];
    rig_daemon(NULL, NULL);
    rig_close(rig_connect(RIG_DDS, 10, COLLIDED_REMOVE)); /* it is ready */
    for (int i = 0; i < IDLE; i++) idle[i] = ask_for_a_turn();
    collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "dds_turns_overdue") >= IDLE);
    assert_true(rig_counter(c, "dds_turns") > IDLE);
    for (int i = 0; i < IDLE; i++) close(idle[i]);
    rig_close(c);
}

/* Whoever joins a crowd is told so before it joins, and is patient then. */
static void who_is_one_of_a_crowd_is_told(void **state)
{
    (void)state;
    enum { FEW = 30, CROWD_FROM = 64, MANY = 80 };
    int asks[MANY];
    rig_daemon(NULL, NULL);
    rig_close(rig_connect(RIG_DDS, 10, COLLIDED_REMOVE));      /* it is ready */
    for (int i = 0; i < MANY; i++) asks[i] = ask_for_a_turn(); /* at once: a turn is over after 2 s */
    for (int i = 0; i < MANY; i++) {
        greeting g = greeted(asks[i]);
        if (i < FEW) assert_false(g.crowd);
        if (i > CROWD_FROM) assert_true(g.crowd);
    }
    for (int i = 0; i < MANY; i++) close(asks[i]);
}

/* Where more come at once than come in within their time, both ends say so. */
static void who_leaves_before_his_turn_is_counted(void **state)
{
    (void)state;
    enum { IDLE = 60, GIVE_UP = 5 };
    int idle[IDLE];
    rig_daemon(NULL, NULL);
    collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    for (int i = 0; i < IDLE; i++) {
        idle[i] = ask_for_a_turn();
        assert_int_equal(greeted(idle[i]).word, 'w');
    }
    collided_def def = collided_def_default();
    def.connect_timeout_s = 0.2; /* 24 at a time, of 2 s each, are before it */
    assert_null(collided_connect(RIG_DDS, &def));
    if (!strstr(collided_connect_error(), "connect_timeout_s")) fail_msg("%s", collided_connect_error());
    for (int i = IDLE - GIVE_UP; i < IDLE; i++) close(idle[i]);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "dds_turns_given_up") >= 1 + GIVE_UP);
    for (int i = 0; i < IDLE - GIVE_UP; i++) close(idle[i]);
    rig_close(c);
}

/* Who is in a room is in none of those that are filled after it: a crowd costs what its number does. */
static void rooms_are_filled_one_after_the_other(void **state)
{
    (void)state;
    enum { OUTSIDE = 16, ROOM = 32, TOGETHER = 4, MANY = 200, ROOMS = 48 };
    int asks[MANY], in[ROOMS + 1] = {0};
    rig_daemon(NULL, NULL);
    collided *c = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    for (int i = 0; i < MANY; i++) asks[i] = ask_for_a_turn(); /* at once: a turn is over after 2 s */
    for (int i = 0; i < MANY; i++) in[(int)greeted(asks[i]).room]++;
    assert_in_range(in[0], OUTSIDE - 2, OUTSIDE);
    for (int i = 1; i <= TOGETHER; i++) assert_int_equal(in[i], ROOM);
    assert_int_equal(in[TOGETHER + 1], (MANY - in[0] - TOGETHER * ROOM + TOGETHER - 1) / TOGETHER);
    for (int i = 2 * TOGETHER + 1; i <= ROOMS; i++) assert_int_equal(in[i], 0);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "dds_rooms") == 2 * TOGETHER);
    for (int i = 0; i < MANY; i++) close(asks[i]);
    rig_close(c);
}

/* The rooms of a daemon are its own; they are there again when those who are in them look for it. */
static void who_is_in_a_room_finds_a_daemon_that_comes_later(void **state)
{
    (void)state;
    enum { OUTSIDE = 16, SIZE = 30 };
    char number[16];
    pid_t daemon = rig_daemon(NULL, NULL);
    collided *watcher = rig_connect(RIG_DDS, 10, COLLIDED_REMOVE);
    int fill[OUTSIDE];
    for (int i = 0; i < OUTSIDE; i++) fill[i] = ask_for_a_turn(); /* all who come behind them are in rooms */
    for (int i = 0; i < OUTSIDE; i++) greeted(fill[i]);
    for (int i = 0; i < SIZE; i++) {
        snprintf(number, sizeof number, "%d", i);
        rig_self("one", RIG_DDS, number);
    }
    UNTIL(watcher, 4 * RIG_PATIENCE_S, crowd_counter(watcher, "bodies") == CROWD_BODIES * SIZE);
    UNTIL(watcher, RIG_PATIENCE_S, crowd_counter(watcher, "dds_rooms") > 0);
    assert_int_equal(participants(), 2); /* the daemon's, and our own: the others are in rooms */
    for (int i = 0; i < OUTSIDE; i++) close(fill[i]);
    rig_kill(daemon, SIGKILL);
    UNTIL(watcher, RIG_PATIENCE_S, collided_poll(watcher, 0) == COLLIDED_NO_DAEMON);
    rig_daemon(NULL, NULL);
    UNTIL(watcher, RIG_PATIENCE_S, collided_poll(watcher, 0) == COLLIDED_OK);
    UNTIL(watcher, 4 * RIG_PATIENCE_S,
        crowd_counter(watcher, "bodies") == CROWD_BODIES * SIZE && crowd_counter(watcher, "dds_rooms") > 0);
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
    if (argc == 4) return crowd_be_one(argv[2], argv[3], strcmp(argv[1], "wide") == 0 ? "lo" : NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_crowd_comes_in_and_knows_nobody_but_the_daemon, rig_end_all),
        cmocka_unit_test_teardown(clients_on_a_network_do_not_hear_each_other, rig_end_all),
        cmocka_unit_test_teardown(streams_of_many_share_writers_and_each_is_told_his, rig_end_all),
        cmocka_unit_test_teardown(heartbeats_of_many_streams_come, rig_end_all),
        cmocka_unit_test_teardown(a_stream_begins_soon, rig_end_all),
        cmocka_unit_test_teardown(turns_are_given_one_by_one, rig_end_all),
        cmocka_unit_test_teardown(turns_go_on_though_some_never_come, rig_end_all),
        cmocka_unit_test_teardown(who_is_one_of_a_crowd_is_told, rig_end_all),
        cmocka_unit_test_teardown(who_leaves_before_his_turn_is_counted, rig_end_all),
        cmocka_unit_test_teardown(rooms_are_filled_one_after_the_other, rig_end_all),
        cmocka_unit_test_teardown(who_is_in_a_room_finds_a_daemon_that_comes_later, rig_end_all),
        cmocka_unit_test_teardown(a_limit_is_named_at_both_ends, rig_end_all),
        cmocka_unit_test_teardown(a_daemon_that_comes_later_is_found, rig_end_all),
#ifdef FAST_DDS
        cmocka_unit_test_teardown(another_vendor_finds_the_daemon, rig_end_all),
#endif
    };
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
