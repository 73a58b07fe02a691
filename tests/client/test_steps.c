/* Lock-step: a step's end is told by the streams that the daemon grants, and refused by what refuses that step. */
#include "cmocka_c.h"
#include "fake.h"

#include <pthread.h>
#include <string.h>

static collided *connect_in_step(void)
{
    collided_def def = collided_def_default();
    def.lease_s = 3600;
    def.connect_timeout_s = FAKE_PATIENCE_S;
    def.lock_step = 1;
    char why[256] = "";
    collided *c = fake_try(&def, why, sizeof why);
    if (!c) fail_msg("%s", why);
    return c;
}

static void ignore(void *context, const collided_batch *b)
{
    (void)context;
    (void)b;
}

static collided_subscription subscribe(collided *c)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = ignore;
    return collided_subscribe(c, &def);
}

static void answer_without(const collided *c, collided_subscription subscription, int64_t step, int32_t refused)
{
    const wire_message m = {.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = collided_client_id(c),
            .subscription = subscription.id,
            .epoch = 1,
            .batch = step + 1,
            .step = step,
            .refused = refused,
            .refusal = refused ? WIRE_OLD_POSE : WIRE_OK,
            .snapshot = true,
            .parts = 1,
            .stream = "s"}};
    fake_give(&m);
}

static void answer(const collided *c, collided_subscription subscription, int64_t step)
{
    answer_without(c, subscription, step, 0);
}

/* What happens while the client waits for the end of a step: the refusals, one after the other, then the answer. */
typedef struct meanwhile {
    collided *client;
    const wire_message *refused[2];
    wire_reason reason;
    collided_subscription told; /* COLLIDED_NONE: none is */
    int64_t step;
} meanwhile;

static void *run(void *context)
{
    const meanwhile *m = context;
    fake_pause(30);
    for (int i = 0; i < 2 && m->refused[i]; i++) fake_reject(m->refused[i], m->reason, "refused by the test");
    fake_settle(); /* what refuses a step comes before its end */
    if (m->told.id != COLLIDED_NONE) answer(m->client, m->told, m->step);
    return NULL;
}

static collided_status step_with(collided *c, int64_t step, double timeout_s, meanwhile m)
{
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, run, &m), 0);
    collided_status status = collided_step(c, step, timeout_s);
    pthread_join(thread, NULL);
    return status;
}

static void a_refused_subscription_is_not_waited_for(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1, .ignored = WIRE_SUBSCRIPTION});
    collided *c = connect_in_step();
    collided_subscription granted = subscribe(c);
    (void)subscribe(c);
    fake_ack(fake_message(WIRE_SUBSCRIPTION, 0));
    fake_reject(fake_message(WIRE_SUBSCRIPTION, 1), WIRE_LIMIT, "no more");
    fake_settle();
    meanwhile m = {.client = c, .told = granted, .step = 1};
    assert_int_equal(step_with(c, 1, FAKE_PATIENCE_S, m), COLLIDED_OK);
    fake_set((fake_options){.epoch = 1});
    collided_close(c);
}

/* Before the step, and while it is waited for. */
static void where_all_are_refused_nothing_is_waited_for(void **state)
{
    (void)state;
    for (int before = 0; before < 2; before++) {
        fake_begin((fake_options){.epoch = 1, .ignored = WIRE_SUBSCRIPTION});
        collided *c = connect_in_step();
        assert_int_equal(collided_step(c, 1, 0.5), COLLIDED_BAD_ARGUMENT);
        (void)subscribe(c);
        meanwhile m = {
            .client = c, .refused = {fake_message(WIRE_SUBSCRIPTION, 0)}, .reason = WIRE_LIMIT, .told.id = -1};
        if (before) {
            fake_reject(m.refused[0], WIRE_LIMIT, "no more");
            m.refused[0] = NULL;
            fake_settle();
        }
        assert_int_equal(step_with(c, 1, FAKE_PATIENCE_S, m), COLLIDED_REJECTED);
        assert_non_null(strstr(collided_error(c), "refused"));
        fake_set((fake_options){.epoch = 1});
        collided_close(c);
    }
}

/* The refusal of the step before comes while the next one is waited for; then that of this one's poses. */
static void a_step_is_refused_by_what_belongs_to_it(void **state)
{
    (void)state;
    for (int own = 0; own < 2; own++) {
        fake_begin((fake_options){.epoch = 1});
        collided *c = connect_in_step();
        collided_subscription told = subscribe(c);
        static const collided_shape ball = {.type = COLLIDED_SPHERE, .radius = 0.1, .pose = {.orientation = {1}}};
        collided_body_def def = collided_body_def_default();
        def.name = "ball", def.shapes = &ball, def.shape_count = 1;
        collided_body body = collided_create_body(c, &def);
        const double position[] = {0, 0, 0}, orientation[] = {1, 0, 0, 0};
        answer(c, told, 0);
        assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
        for (int step = 1; step <= 2; step++) {
            assert_int_equal(collided_publish(c, 1, &body, position, orientation, NULL, NULL, 0, step), COLLIDED_OK);
            if (step == 1) assert_int_equal(collided_step(c, step, 0), COLLIDED_TIMEOUT);
        }
        meanwhile m = {.client = c,
            .refused = {fake_message(WIRE_POSE_BATCH, 1), own ? fake_message(WIRE_POSE_BATCH, 2) : NULL},
            .reason = WIRE_BAD_STEP,
            .told = told,
            .step = 2};
        assert_int_equal(fake_message(WIRE_POSE_BATCH, 1)->pose_batch.bodies.count, 0);
        assert_int_equal(step_with(c, 2, FAKE_PATIENCE_S, m), own ? COLLIDED_REJECTED : COLLIDED_OK);
        collided_close(c);
    }
}

/* Its end goes out under one sequence, however often it is asked for; the answer says what was refused of it. */
static void a_step_is_ended_once_and_says_what_was_refused_of_it(void **state)
{
    (void)state;
    for (int32_t refused = 0; refused < 2; refused++) {
        fake_begin((fake_options){.epoch = 1});
        collided *c = connect_in_step();
        assert_int_equal(collided_step(c, 1, 0), COLLIDED_TIMEOUT); /* nobody can tell */
        collided_subscription told = subscribe(c);
        fake_settle();
        for (int i = 0; i < 3; i++) assert_int_equal(collided_step(c, 2, 0), COLLIDED_TIMEOUT);
        assert_int_equal(collided_step(c, 2, 0.25), COLLIDED_TIMEOUT);
        assert_int_equal(collided_step(c, 2, 0.01), COLLIDED_TIMEOUT);
        answer_without(c, told, 2, 3 * refused);
        for (int i = 0; i < 3; i++) {
            collided_status status = collided_step(c, 2, i ? FAKE_PATIENCE_S : 0);
            assert_int_equal(status, refused ? COLLIDED_REJECTED : COLLIDED_OK);
            const char *why = "step 2 is done, but 3 of this client's poses were refused: old_pose";
            if (refused) assert_string_equal(collided_error(c), why);
        }
        const wire_message *end = fake_message(WIRE_POSE_BATCH, 1);
        for (size_t n = 2; n < fake_sent(WIRE_POSE_BATCH); n++)
            assert_int_equal(fake_message(WIRE_POSE_BATCH, n)->pose_batch.sequence, end->pose_batch.sequence);
        assert_true(fake_sent(WIRE_POSE_BATCH) >= 3); /* of step 1; of step 2, and once more, but not each time */
        assert_int_equal(collided_step(c, 3, 0), COLLIDED_TIMEOUT);
        assert_true(fake_message(WIRE_POSE_BATCH, fake_sent(WIRE_POSE_BATCH) - 1)->pose_batch.step == 3);
        collided_close(c);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_refused_subscription_is_not_waited_for),
        cmocka_unit_test(where_all_are_refused_nothing_is_waited_for),
        cmocka_unit_test(a_step_is_ended_once_and_says_what_was_refused_of_it),
        cmocka_unit_test(a_step_is_refused_by_what_belongs_to_it),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fake_begin((fake_options){0});
    return failed;
}
