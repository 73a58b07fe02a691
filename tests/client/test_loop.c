/* The descriptor for event loops: readable when, and only as long as, collided_poll has something to do. */
#include "cmocka_c.h"
#include "fake.h"

#include <poll.h>
#include <stdio.h>
#include <string.h>

static bool readable(const collided *c, int timeout_ms)
{
    struct pollfd p = {.fd = c->loop, .events = POLLIN};
    return poll(&p, 1, timeout_ms) == 1;
}

/* What was left over from joining is taken: then the descriptor rests. */
static void rest(collided *c)
{
    fake_settle();
    for (int i = 0; i < 50 && readable(c, 20); i++) (void)collided_poll(c, 0);
    assert_false(readable(c, 20));
}

static size_t batches;

static void count_batch(void *context, const collided_batch *batch)
{
    (void)context;
    batches += !batch->heartbeat;
}

static void give_batch(const collided *c, int64_t number, bool snapshot)
{
    const wire_subscription *s = &fake_message(WIRE_SUBSCRIPTION, 0)->subscription;
    const wire_message m = {.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = c->id,
            .subscription = s->subscription,
            .stream = s->stream,
            .epoch = 1,
            .batch = number,
            .tick = number,
            .snapshot = snapshot,
            .parts = 1}};
    fake_give(&m);
}

static void an_event_makes_it_readable_until_it_is_taken(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    int fd = collided_fd(c);
    assert_true(fd >= 0);
    assert_int_equal(collided_fd(c), fd);
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = count_batch;
    assert_int_not_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
    rest(c);
    batches = 0;
    for (int64_t n = 1; n <= 3; n++) {
        give_batch(c, n, n == 1);
        assert_true(readable(c, 1000));
        assert_true(readable(c, 0)); /* it was not taken by looking */
        assert_int_equal(collided_poll(c, 0), COLLIDED_OK);
        assert_int_equal(batches, n);
        rest(c);
    }
    collided_close(c);
}

static char refused[32];

static void keep_reason(void *context, const collided_rejection *why)
{
    (void)context;
    (void)snprintf(refused, sizeof refused, "%s", why->reason);
}

static void a_refusal_makes_it_readable(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1, .ignored = WIRE_BODY});
    collided *c = fake_connect();
    collided_on_rejected(c, keep_reason, NULL);
    assert_true(collided_fd(c) >= 0);
    rest(c);
    collided_shape ball = collided_sphere(1);
    collided_body_def def = collided_body_def_default();
    def.name = "ball", def.shapes = &ball, def.shape_count = 1;
    assert_int_not_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    fake_reject(fake_message(WIRE_BODY, 0), WIRE_NAME_TAKEN, "there is one");
    assert_true(readable(c, 1000));
    assert_int_equal(collided_poll(c, 0), COLLIDED_OK);
    assert_string_equal(refused, "name_taken");
    rest(c);
    collided_close(c);
}

/* Nothing comes: the timer calls for whom an event loop alone would never look. No busy loop meanwhile. */
static void a_silent_daemon_is_told(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    assert_true(collided_fd(c) >= 0);
    collided_status status = COLLIDED_OK;
    int turns = 0;
    for (; status == COLLIDED_OK && turns < 100 && readable(c, 10000); turns++) status = collided_poll(c, 0);
    assert_int_equal(status, COLLIDED_NO_DAEMON);
    assert_true(turns < 20);
    assert_false(readable(c, 100)); /* and then once a second */
    assert_true(readable(c, 10000));
    fake_status(1);
    fake_settle();
    assert_int_equal(collided_poll(c, 0), COLLIDED_OK);
    collided_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_event_makes_it_readable_until_it_is_taken),
        cmocka_unit_test(a_refusal_makes_it_readable),
        cmocka_unit_test(a_silent_daemon_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
