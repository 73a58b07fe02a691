/* A participant that goes by ever new names over DDS: it has its share, others have theirs, and the operator's tool may
 * ask when no place is left. */
#include "raw_dds.h"
#include "rig.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test_teardown(many_names_have_one_share, rig_end_all)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
