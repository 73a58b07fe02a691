/* Poses: held until the body is known, newest wins; nothing is sent of a call that has anything wrong in it. */
#include "cmocka_c.h"
#include "fake.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static collided_body_def ball_def(const char *name)
{
    static const collided_shape ball = {.type = COLLIDED_SPHERE, .radius = 0.1, .pose = {.orientation = {1}}};
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &ball;
    def.shape_count = 1;
    return def;
}

static collided_body make(collided *c, const char *name)
{
    collided_body_def def = ball_def(name);
    return collided_create_body(c, &def);
}

static collided_status put(collided *c, collided_body body, double x, int64_t stamp_ns)
{
    const double position[] = {x, 0, 0}, orientation[] = {1, 0, 0, 0};
    return collided_publish(c, 1, &body, position, orientation, NULL, NULL, stamp_ns, 0);
}

static void poses_wait_for_the_acknowledgement_and_the_newest_is_sent(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    collided_body body = make(c, "part");
    int64_t now = session_now_ns();
    assert_int_equal(put(c, body, 1.0, now + 1), COLLIDED_OK);
    assert_int_equal(put(c, body, 3.0, now + 3), COLLIDED_OK);
    assert_int_equal(put(c, body, 2.0, now + 2), COLLIDED_OK);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 0);
    fake_ack(fake_message(WIRE_BODY, 0));
    const wire_pose_batch *sent = &fake_message(WIRE_POSE_BATCH, 0)->pose_batch;
    assert_true(sent->positions.at[0] == 3.0 && sent->stamp_ns == now + 3);
    fake_pause(20);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 1);
    fake_set((fake_options){.repeats = true, .epoch = 1});
    collided_close(c);
}

/* Whatever comes after it before the acknowledgement: it cannot be reached from what was announced. */
static void a_teleport_before_the_acknowledgement_stays_one(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    collided_body body = make(c, "part");
    const double position[] = {5, 0, 0}, orientation[] = {1, 0, 0, 0};
    assert_int_equal(collided_teleport(c, 1, &body, position, orientation, NULL, NULL, 0, 0), COLLIDED_OK);
    assert_int_equal(put(c, body, 6.0, 0), COLLIDED_OK);
    fake_ack(fake_message(WIRE_BODY, 0));
    const wire_pose_batch *sent = &fake_message(WIRE_POSE_BATCH, 0)->pose_batch;
    assert_true(sent->positions.at[0] == 6.0 && sent->teleports.count == 1 && sent->teleports.at[0] == 1);
    assert_int_equal(put(c, body, 7.0, 0), COLLIDED_OK);
    assert_int_equal(fake_message(WIRE_POSE_BATCH, 1)->pose_batch.teleports.count, 0);
    fake_set((fake_options){.repeats = true, .epoch = 1});
    collided_close(c);
}

static void a_changed_body_is_announced_again(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_body body = make(c, "part");
    collided_body_def def = ball_def("renamed");
    assert_int_equal(collided_change_body(c, body, &def), COLLIDED_OK);
    const wire_body *again = &fake_message(WIRE_BODY, 1)->body;
    assert_string_equal(again->name, "renamed");
    assert_true(again->body == body.id && again->sequence > fake_message(WIRE_BODY, 0)->body.sequence);
    assert_int_equal(collided_change_body(c, (collided_body){99}, &def), COLLIDED_UNKNOWN_ID);
    collided_close(c);
}

static void batches_are_split_and_only_known_bodies_are_in_them(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    enum { BODIES = 10 };
    collided_body bodies[BODIES];
    double positions[3 * BODIES] = {0}, orientations[4 * BODIES] = {0};
    for (int i = 0; i < BODIES; i++) {
        char name[8];
        (void)snprintf(name, sizeof name, "b%d", i);
        bodies[i] = make(c, name);
        positions[3 * i] = i;
        orientations[4 * i] = 1;
    }
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_set((fake_options){.ignored = WIRE_BODY, .epoch = 1});
    collided_body_def def = ball_def("b5");
    assert_int_equal(collided_change_body(c, bodies[5], &def), COLLIDED_OK);
    assert_int_equal(collided_publish(c, BODIES, bodies, positions, orientations, positions, NULL, 0, 8), COLLIDED_OK);
    const uint32_t sizes[] = {4, 1, 4}; /* the fake takes four poses a message; the sixth body is not known yet */
    size_t seen = 0;
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 3);
    for (size_t i = 0; i < 3; i++) {
        const wire_pose_batch *b = &fake_message(WIRE_POSE_BATCH, i)->pose_batch;
        assert_int_equal(b->bodies.count, sizes[i]);
        assert_true(b->step == 8 && b->angular.count == 0 && b->linear.count == 3 * sizes[i]);
        for (uint32_t k = 0; k < b->bodies.count; k++) {
            seen += seen == 5;
            assert_int_equal(b->bodies.at[k], bodies[seen].id);
            assert_true(b->positions.at[3 * k] == (double)seen);
            seen++;
        }
    }
    assert_int_equal(seen, BODIES);
    fake_set((fake_options){.epoch = 1});
    fake_ack(fake_message(WIRE_BODY, BODIES));
    assert_int_equal(fake_message(WIRE_POSE_BATCH, 3)->pose_batch.bodies.at[0], bodies[5].id);
    collided_close(c);
}

static void poses_carry_the_time_of_the_simulation(void **state)
{
    (void)state;
    fake_begin((fake_options){.ignored = WIRE_BODY, .epoch = 1});
    collided *c = fake_connect();
    collided_body known, late = make(c, "late");
    const double p[3] = {0}, o[4] = {1, 0, 0, 0};
    assert_int_equal(collided_set_simulation_time(c, -1), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_set_simulation_time(c, 5000), COLLIDED_OK);
    assert_int_equal(collided_publish(c, 1, &late, p, o, NULL, NULL, 0, 1), COLLIDED_OK);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 0);
    assert_int_equal(collided_set_simulation_time(c, 6000), COLLIDED_OK);
    fake_set((fake_options){.epoch = 1});
    fake_ack(fake_message(WIRE_BODY, 0));
    assert_int_equal(fake_message(WIRE_POSE_BATCH, 0)->pose_batch.simulation_ns, 5000); /* as it was published */
    known = make(c, "known");
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(collided_teleport(c, 1, &known, p, o, NULL, NULL, 0, 2), COLLIDED_OK);
    assert_int_equal(fake_message(WIRE_POSE_BATCH, 1)->pose_batch.simulation_ns, 6000);
    assert_int_equal(collided_set_simulation_time(c, 0), COLLIDED_OK);
    assert_int_equal(collided_publish(c, 1, &known, p, o, NULL, NULL, 0, 3), COLLIDED_OK);
    assert_int_equal(fake_message(WIRE_POSE_BATCH, 2)->pose_batch.simulation_ns, 0);
    collided_close(c);
}

static void nothing_is_sent_of_a_call_with_anything_wrong(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_body bodies[] = {make(c, "a"), make(c, "b")};
    collided_remove_body(c, make(c, "gone"));
    assert_int_equal(collided_sync(c, FAKE_PATIENCE_S), COLLIDED_OK);
    const double good_p[6] = {0}, good_o[8] = {1, 0, 0, 0, 1, 0, 0, 0};
    const double nan_p[6] = {0, 0, 0, 0, NAN, 0}, zero_o[8] = {1, 0, 0, 0, 0, 0, 0, 0}, inf_v[6] = {0, INFINITY};
    collided_body unknown[] = {bodies[0], {77}}, gone[] = {bodies[0], {2}};
    assert_int_equal(collided_publish(c, 2, bodies, nan_p, good_o, NULL, NULL, 0, 0), COLLIDED_BAD_ARGUMENT);
    assert_true(collided_error(c)[0] != '\0');
    assert_int_equal(collided_publish(c, 2, bodies, good_p, zero_o, NULL, NULL, 0, 0), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_publish(c, 2, bodies, good_p, good_o, inf_v, NULL, 0, 0), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_publish(c, 2, bodies, NULL, good_o, NULL, NULL, 0, 0), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_publish(c, 2, unknown, good_p, good_o, NULL, NULL, 0, 0), COLLIDED_UNKNOWN_ID);
    assert_non_null(strstr(collided_error(c), "77"));
    assert_int_equal(collided_publish(c, 2, gone, good_p, good_o, NULL, NULL, 0, 0), COLLIDED_UNKNOWN_ID);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 0);
    assert_int_equal(collided_publish(c, 2, bodies, good_p, good_o, NULL, NULL, 0, 0), COLLIDED_OK);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 1);
    collided_close(c);
}

static void bad_bodies_are_refused_before_anything_is_sent(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_shape shape = collided_sphere(-1.0);
    collided_body_def def = ball_def("part");
    def.shapes = &shape;
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    shape = collided_box(1, NAN, 1);
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    shape = collided_sphere(1.0);
    shape.type = (collided_shape_type)300; /* would be a capsule's number after truncation */
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    shape = collided_sphere(1.0);
    def.name = "";
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    def.name = "part";
    def.deadline_s = -1.0;
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    def.deadline_s = 0.0;
    def.pose.orientation[0] = 0.0;
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE);
    def.pose.orientation[0] = 1.0;
    assert_int_equal(fake_sent(WIRE_BODY), 0);
    def.id = 5;
    assert_int_equal(collided_create_body(c, &def).id, 5);
    assert_int_equal(collided_create_body(c, &def).id, COLLIDED_NONE); /* taken */
    def.id = COLLIDED_NONE;
    assert_int_equal(collided_create_body(c, &def).id, 6);
    collided_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(poses_wait_for_the_acknowledgement_and_the_newest_is_sent),
        cmocka_unit_test(a_teleport_before_the_acknowledgement_stays_one),
        cmocka_unit_test(a_changed_body_is_announced_again),
        cmocka_unit_test(batches_are_split_and_only_known_bodies_are_in_them),
        cmocka_unit_test(poses_carry_the_time_of_the_simulation),
        cmocka_unit_test(nothing_is_sent_of_a_call_with_anything_wrong),
        cmocka_unit_test(bad_bodies_are_refused_before_anything_is_sent),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fake_begin((fake_options){0});
    return failed;
}
