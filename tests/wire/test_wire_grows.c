/* The wire grows, and nobody has to be built again: a client that was built from the definitions of v1/ is served by
 * the daemon and by a later one (later.c); today's client library hears a later daemon, today's daemon a later client;
 * and what was recorded before messages had extensions is replayed. Each test has its processes in a network of its
 * own. */
#include "../faults/raw_dds.h"
#include "../faults/rig.h"
#include "later.h"
#include "wire/one_shape.h"
#include "wire/wire_extensions.h"
#include "wire/wire_lcm.h"
#include "wire/wire_log.h"

#include <lcm/lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define DOMAIN "61" /* of RIG_DDS */

/* ---- programs ---- */

static pid_t start_daemon(const char *program, const char *option, const char *value)
{
    const char *const arguments[] = {"collided", "--links", RIG_LINKS, "--status-period", "0.1", "--workers", "1",
        "--log", "notice", "--gateway", GATEWAY, option, value, NULL};
    rig_need_network();
    return rig_start(program, arguments);
}

typedef struct said {
    int status;
    char words[8192]; /* all that it printed */
} said;

static said run(const char *command)
{
    said s = {0};
    FILE *f = popen(command, "r"); /* NOLINT(cert-env33-c): a fixed line */
    assert_non_null(f);
    size_t size = fread(s.words, 1, sizeof s.words - 1, f);
    s.words[size] = '\0';
    s.status = pclose(f);
    return s;
}

/* The number behind that name in the last line of an old client. */
static int number_of(const said *s, const char *name)
{
    const char *summary = strstr(s->words, "begins"), *at = summary ? strstr(summary, name) : NULL;
    if (!at) fail_msg("no \"%s\" in: %s", name, s->words);
    return atoi(at + strlen(name));
}

static void expect_served(const char *client, bool by_a_later_daemon)
{
    said s = run(client);
    if (s.status != 0) fail_msg("%s: status %d: %s", client, s.status, s.words);
    assert_int_equal(number_of(&s, "begins "), 1);
    assert_int_equal(number_of(&s, "ends "), 1);
    assert_true(number_of(&s, "answers ") >= 1);
    assert_true(number_of(&s, "rejects ") >= 1);
    assert_int_equal(number_of(&s, "unknown kinds ") > 0, by_a_later_daemon);
    assert_int_equal(number_of(&s, "extensions ") > 0, by_a_later_daemon);
    assert_int_equal(strstr(s.words, "unknown kind 42") != NULL, by_a_later_daemon);
}

static void old_clients_are_served(void **state)
{
    (void)state;
    pid_t daemon = start_daemon(COLLIDED, NULL, NULL);
    expect_served(OLD_DDS " " DOMAIN, false);
    expect_served(OLD_LCM, false);
    assert_true(rig_alive(daemon));
}

static void old_clients_are_served_by_a_later_daemon(void **state)
{
    (void)state;
    pid_t daemon = start_daemon(LATER, NULL, NULL);
    expect_served(OLD_DDS " " DOMAIN, true);
    expect_served(OLD_LCM, true);
    assert_true(rig_alive(daemon));
}

/* ---- today's client library, and a later daemon ---- */

typedef struct told {
    size_t begins, ends, later, achieved;
    bool has_other_cause;
} told;

static void on_batch(void *context, const collided_batch *b)
{
    told *t = context;
    for (size_t i = 0; i < b->event_count; i++) {
        const collided_event *e = &b->events[i];
        bool later = (int)e->kind == LATER_KIND;
        t->begins += e->kind == COLLIDED_BEGIN;
        t->ends += e->kind == COLLIDED_END;
        t->later += later;
        t->achieved += later && (int)e->achieved == LATER_ACHIEVED;
        t->has_other_cause |= later && strcmp(e->cause, "unknown") != 0;
    }
}

static void the_library_hears_a_later_daemon(void **state)
{
    told t = {0};
    start_daemon(LATER, NULL, NULL);
    collided *c = rig_connect(*state, 30, COLLIDED_REMOVE);
    rig_box(c, "table", 0);
    collided_body part = rig_box(c, "part", 3);
    collided_subscription_def def = collided_subscription_def_default();
    def.select_a = "part";
    def.callback = on_batch;
    def.context = &t;
    assert_int_not_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
    rig_move(c, part, 0.6, 0);
    UNTIL(c, RIG_PATIENCE_S, t.begins == 1 && t.later >= 1);
    rig_move(c, part, 3, 0);
    UNTIL(c, RIG_PATIENCE_S, t.ends == 1 && t.later >= 2);
    assert_int_equal(t.achieved, t.later);
    assert_false(t.has_other_cause);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "client_unknown_events") == (int64_t)t.later);
    assert_int_equal(rig_counter(c, "client_malformed_messages"), 0);
    assert_int_equal(rig_counter(c, "client_batches_lost"), 0);
    assert_int_equal(rig_counter(c, "extension_" LATER_POSE_TEXT), 1);
}

static void collidectl_says_that_a_kind_is_unknown(void **state)
{
    (void)state;
    start_daemon(LATER, NULL, NULL);
    collided *c = rig_connect(RIG_DDS, 30, COLLIDED_REMOVE);
    rig_box(c, "table", 0);
    rig_box(c, "part", 0.6);
    said s = run("env HOME=/nonexistent " COLLIDECTL " watch --connect dds://" DOMAIN " --seconds 3 --timeout 30");
    if (!strstr(s.words, "unknown kind 42") || !strstr(s.words, "part")) fail_msg("status %d: %s", s.status, s.words);
}

/* ---- today's daemon, and a later client ---- */

static uint32_t put_record(uint8_t *at, uint32_t id, uint32_t length)
{
    for (int k = 0; k < 4; k++) at[k] = (uint8_t)(id >> 8 * k);
    for (int k = 0; k < 4; k++) at[4 + k] = (uint8_t)(length >> 8 * k);
    memset(at + WIRE_EXTENSION_HEAD, 0x5a, length);
    return WIRE_EXTENSION_HEAD + length;
}

static wire_message ball(int32_t body, const char *name, wire_u8s extensions)
{
    static const one_shape sphere = {
        .pose = {9, 9, 9, 1}, .radius = {0.5}, .in_body = {0, 0, 0, 1}, .type = {WIRE_SHAPE_SPHERE}};
    wire_message m = one_shape_body(&sphere, 0, 0, body, name);
    m.body.extensions = extensions;
    return m;
}

static wire_message pose(double x, wire_u8s extensions)
{
    static const int32_t body[1] = {1};
    static double at[3], turn[4] = {1, 0, 0, 0};
    at[0] = x;
    return (wire_message){.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .bodies = {1, body},
            .positions = {3, at},
            .orientations = {4, turn},
            .extensions = extensions}};
}

static bool is_at(collided *c, const char *name, double x)
{
    collided_result r = {0};
    bool found = collided_query_bodies(c, name, 5, &r) == COLLIDED_OK && r.count == 1 && r.hits[0].point_a[0] == x;
    collided_result_free(&r);
    return found;
}

static bool is_there(collided *c, const char *name)
{
    collided_result r = {0};
    bool found = collided_query_bodies(c, name, 5, &r) == COLLIDED_OK && r.count == 1;
    collided_result_free(&r);
    return found;
}

/* Two records that it may pass over, in a pose; one that it must not, in a body. The number passed over. */
static void send_as_a_later_client(collided *c, bool to_a_later_daemon)
{
    uint8_t records[64], required[64];
    uint32_t size = put_record(records, LATER_POSE, 6);
    size += put_record(records + size, LATER_NOBODYS, 11);
    uint32_t required_size = put_record(required, LATER_REQUIRED | WIRE_EXTENSION_REQUIRED, 3);
    raw_dds later;
    raw_open(&later);
    wire_message hello = {
        .kind = WIRE_CLIENT, .client = {.version = WIRE_VERSION, .lease_ns = 1000000000000, .name = "later"}};
    wire_message plain = ball(1, "later_ball", (wire_u8s){0}),
                 strict = ball(2, "strict", (wire_u8s){required_size, required});
    wire_message moved = pose(4.5, (wire_u8s){size, records});
    raw_send(&later, &hello);
    raw_send(&later, &plain);
    UNTIL(c, RIG_PATIENCE_S, is_there(c, "later_ball"));
    raw_send(&later, &moved);
    UNTIL(c, RIG_PATIENCE_S, is_at(c, "later_ball", 4.5));
    int64_t number = raw_send(&later, &strict);
    if (!to_a_later_daemon) assert_int_equal(raw_rejected(&later, number), WIRE_UNSUPPORTED);
    if (to_a_later_daemon) UNTIL(c, RIG_PATIENCE_S, is_there(c, "strict"));
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "unknown_extensions") == (to_a_later_daemon ? 1 : 2));
    assert_int_equal(is_there(c, "strict"), to_a_later_daemon);
    raw_close(&later);
}

/* Bytes of extensions in the recorded poses. What must not be passed over ends the reading of a recording, too. */
static uint32_t recorded_extensions(const char *path, bool by_a_later_daemon)
{
    int got;
    char why[256];
    wire_log_entry e;
    uint32_t bytes = 0, poses = 0;
    wire_log_reader *r = wire_log_open(path, why, sizeof why);
    assert_non_null(r);
    while ((got = wire_log_next(r, &e, NULL, why, sizeof why)) == 1) {
        if (e.kind != WIRE_LOG_MESSAGE) continue;
        poses += e.message.kind == WIRE_POSE_BATCH;
        if (e.message.kind == WIRE_POSE_BATCH) bytes += wire_extensions_of(&e.message).count;
    }
    wire_log_end(r);
    assert_true(poses > 0);
    assert_int_equal(got, by_a_later_daemon ? -1 : 0);
    if (got < 0 && !strstr(why, "must not be passed over")) fail_msg("%s", why);
    return bytes;
}

/* What is not carried out is not recorded, so that a later daemon replays what was done; what is carried out is. */
static void expect_recorded(const char *program, bool later)
{
    char folder[] = "/tmp/collided-grows-XXXXXX", path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/session.lcmlog", folder);
    pid_t daemon = start_daemon(program, "--record", path);
    collided *c = rig_connect(RIG_DDS, 30, COLLIDED_REMOVE);
    send_as_a_later_client(c, later);
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
    assert_int_equal(recorded_extensions(path, later), later ? WIRE_EXTENSION_HEAD + 6 : 0);
    unlink(path);
    rmdir(folder);
}

static void a_later_client_is_served(void **state)
{
    (void)state;
    expect_recorded(COLLIDED, false);
}

static void a_later_client_is_served_by_a_later_daemon(void **state)
{
    (void)state;
    expect_recorded(LATER, true);
}

/* Of a kind that only a later release has: refused by name, and nothing else suffers. Over DDS nobody reads it. */
static void a_message_of_a_new_kind_is_refused(void **state)
{
    (void)state;
    static const uint8_t fingerprint_and_more[40] = {0x1a, 0x7e, 0x12};
    start_daemon(COLLIDED, NULL, NULL);
    collided *c = rig_connect(RIG_LCM, 30, COLLIDED_REMOVE);
    rig_box(c, "part", 0);
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    UNTIL(c, RIG_PATIENCE_S,
        (lcm_publish(lcm, "collided.in.Later", fingerprint_and_more, sizeof fingerprint_and_more),
            rig_counter(c, "reject_wrong_version") > 0));
    assert_true(is_there(c, "part"));
    lcm_destroy(lcm);
}

/* ---- a peer of another vendor ---- */

/* It takes a Status of that many bytes of extensions, and its poses come, extension and all. */
static void expect_fast_dds(const char *program, const char *extensions)
{
#ifdef FAST_PEER
    char line[64] = "";
    pid_t daemon = start_daemon(program, NULL, NULL);
    collided *c = rig_connect(RIG_DDS, 30, COLLIDED_REMOVE);
    FILE *f =
        popen("exec timeout 120 " FAST_PEER " " DOMAIN " " PROFILES, "r"); /* NOLINT(cert-env33-c): a fixed line */
    assert_non_null(f);
    assert_non_null(fgets(line, sizeof line, f));
    assert_string_equal(line, extensions);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "in_PoseBatch") > 0 && rig_counter(c, "unknown_extensions") > 0);
    assert_true(rig_alive(daemon));
    while (fgets(line, sizeof line, f) && strcmp(line, extensions) == 0 && rig_alive(daemon)) rig_kill(daemon, SIGTERM);
    pclose(f);
#else
    (void)program, (void)extensions;
    printf("skipped: no Fast DDS here\n");
    skip();
#endif
}

static void fast_dds_reads_and_writes_extensions(void **state)
{
    (void)state;
    expect_fast_dds(COLLIDED, "extensions 0\n");
    rig_end_all(state);
    expect_fast_dds(LATER, "extensions 13\n");
}

/* ---- recordings ---- */

static void recordings_without_extensions_are_replayed(void **state)
{
    (void)state;
    said whole = run(COLLIDED " --replay " BEFORE "/session.lcmlog 2>&1");
    /* Whether the bits of its distances are today's, too, is not this test's business: they are better now. */
    if (!strstr(whole.words, "replayed 22 ticks, 24 events, hash "))
        fail_msg("status %d: %s", whole.status, whole.words);
    said middle = run(COLLIDED " --replay " BEFORE "/middle.lcmlog 2>&1");
    if (middle.status != 0 || !strstr(middle.words, "The state that it begins with was left out"))
        fail_msg("status %d: %s", middle.status, middle.words);
}

#define HERE(test) cmocka_unit_test_teardown(test, rig_end_all)

int main(int argc, char **argv)
{
    (void)argv;
    if (argc != 1) return 2;
    const struct CMUnitTest tests[] = {
        HERE(old_clients_are_served),
        HERE(old_clients_are_served_by_a_later_daemon),
        OVER_BOTH(the_library_hears_a_later_daemon),
        HERE(collidectl_says_that_a_kind_is_unknown),
        HERE(a_later_client_is_served),
        HERE(a_later_client_is_served_by_a_later_daemon),
        HERE(a_message_of_a_new_kind_is_refused),
        HERE(fast_dds_reads_and_writes_extensions),
        HERE(recordings_without_extensions_are_replayed),
    };
    setenv("LATER_DOMAIN", DOMAIN, 1);
    (void)rig_isolate();
    return cmocka_run_group_tests_name("wire_grows", tests, NULL, NULL);
}
