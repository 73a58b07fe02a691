/* A participant that goes by ever new names over DDS: it has its share, others have theirs, and the operator's tool may
 * ask when no place is left. */
#include "raw_dds.h"
#include "rig.h"
#include "wire/wire_lcm.h"

#include <lcm/lcm.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { PLACES = 12, SHARE = 9, NAMES = 40, FIRST_NAME = 1000 };

static void announce(raw_dds *r, int64_t first)
{
    for (int i = 0; i < NAMES; i++) {
        wire_message m = {.kind = WIRE_CLIENT,
            .client = {.version = WIRE_VERSION, .lease_ns = INT64_C(600000000000), .name = "one of many"}};
        raw_send_as(r, first + i, &m);
    }
}

static collided *connect_as(const char *name)
{
    collided_def def = collided_def_default();
    def.name = name;
    def.lease_s = 30;
    def.connect_timeout_s = RIG_PATIENCE_S;
    return collided_connect(RIG_DDS, &def);
}

static void many_names_have_one_share(void **state)
{
    (void)state;
    char places[8];
    raw_dds first, second;
    snprintf(places, sizeof places, "%d", PLACES);
    pid_t daemon = rig_daemon("--max-clients", places);
    collided *c = rig_connect(RIG_DDS, 30, COLLIDED_REMOVE);
    raw_open(&first);
    announce(&first, FIRST_NAME);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "clients") == SHARE + 1);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "reject_limit") >= NAMES - SHARE);
    assert_int_equal(rig_counter(c, "clients"), SHARE + 1);
    rig_box(c, "box", 0);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "bodies") == 1);
    raw_open(&second); /* another one takes what is left */
    announce(&second, 2 * FIRST_NAME);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "clients") == PLACES);
    assert_null(connect_as("somebody"));
    assert_non_null(strstr(collided_connect_error(), "max_clients"));
    collided *operator= connect_as("collidectl");
    if (!operator) fail_msg("%s", collided_connect_error());
    collided_close(operator);
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "operators_greeted") >= 1);
    assert_int_equal(rig_counter(c, "clients"), PLACES);
    assert_true(rig_alive(daemon));
    raw_close(&first);
    raw_close(&second);
    rig_close(c);
}

static void say_over_lcm(lcm_t *lcm, int64_t client, const char *name)
{
    uint8_t bytes[256];
    char channel[WIRE_CHANNEL_MAX];
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {
            .version = WIRE_VERSION, .client = client, .sequence = 1, .lease_ns = INT64_C(600000000000), .name = name}};
    wire_lcm_channel(&m, channel);
    size_t size = wire_lcm_encode(&m, bytes, sizeof bytes);
    assert_int_equal(lcm_publish(lcm, channel, bytes, (unsigned)size), 0);
}

/* Over LCM, where each name may be somebody: those who are refused leave nothing behind, though nothing else comes that
 * would make a tick. */
static void refused_names_leave_nothing(void **state)
{
    (void)state;
    enum { REFUSED = 80000, AT_ONCE = 100, MOST_KB = 12000 };
    pid_t daemon = rig_daemon("--max-clients", "4");
    collided *c = rig_connect(RIG_DDS, 60, COLLIDED_REMOVE);
    lcm_t *lcm = lcm_create("udpm://239.255.76.67:7667?ttl=0");
    assert_non_null(lcm);
    for (int i = 0; i < 10; i++) say_over_lcm(lcm, FIRST_NAME + i, "one of many");
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "reject_limit") > 0);
    long before_kb = rig_resident_kb(daemon);
    int64_t refused = rig_counter(c, "reject_limit");
    for (int i = 0; i < REFUSED; i++) {
        say_over_lcm(lcm, 2 * FIRST_NAME + i, "one of many");
        if (i % AT_ONCE == 0) collided_poll(c, 0.002);
    }
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "reject_limit") >= refused + REFUSED / 2); /* some datagrams may be lost */
    printf("%ld kB more\n", rig_resident_kb(daemon) - before_kb);
    assert_true(rig_resident_kb(daemon) - before_kb < MOST_KB);
    lcm_destroy(lcm);
    rig_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(many_names_have_one_share, rig_end_all),
        cmocka_unit_test_teardown(refused_names_leave_nothing, rig_end_all)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
