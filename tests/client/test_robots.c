/* Robots: their joints go out as joints once the daemon knows all their bodies, and as poses before; where the links
 * are is remembered for announcements to come; parts that are attached ride along. */
#include "cmocka_c.h"
#include "fake.h"

#include "wire/wire_model.h"

#include <math.h>
#include <string.h>

enum { TURNS, SLIDES, PART, BODIES };

typedef struct robot {
    collided *c;
    collided_body bodies[BODIES];
    collided_joint joints[2];
    collided_robot tree;
} robot;

static collided_body make(collided *c, const char *name)
{
    static const collided_shape ball = {.type = COLLIDED_SPHERE, .radius = 0.1, .pose = {.orientation = {1}}};
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &ball;
    def.shape_count = 1;
    return collided_create_body(c, &def);
}

static void begin(robot *r, fake_options options)
{
    fake_begin(options);
    r->c = fake_connect();
    r->bodies[TURNS] = make(r->c, "turns");
    r->bodies[SLIDES] = make(r->c, "slides");
    r->bodies[PART] = make(r->c, "part");
    for (int i = 0; i < 2; i++)
        r->joints[i] = (collided_joint){.parent = i - 1,
            .type = i ? COLLIDED_JOINT_PRISMATIC : COLLIDED_JOINT_REVOLUTE,
            .origin = {{i, 0, 0}, {1, 0, 0, 0}},
            .axis = {i, 0, !i},
            .lower = -3,
            .upper = 3,
            .body = i ? "slides" : "turns"};
    r->tree = (collided_robot){r->joints, 2, {{0, 0, 5}, {1, 0, 0, 0}}};
}

static collided_status move(robot *r, double turn, double slide)
{
    const double positions[2] = {turn, slide};
    const collided_joint_state at = {.positions = positions};
    return collided_publish_joints(r->c, r->bodies[TURNS], &at, 2, 0, 0);
}

static void end(robot *r)
{
    fake_set((fake_options){.repeats = true, .epoch = 1});
    collided_close(r->c);
}

static void joints_go_out_as_joints(void **state)
{
    (void)state;
    robot r;
    begin(&r, (fake_options){.repeats = true, .epoch = 1});
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_OK);
    const wire_body *carrier = &fake_message(WIRE_BODY, BODIES)->body;
    wire_u8s record;
    wire_model model;
    wire_refusal why;
    assert_true(wire_model_find(carrier->extensions, &record));
    assert_int_equal(wire_model_read(record, &model, &why), WIRE_OK);
    assert_int_equal(model.count, 2);
    assert_int_equal(model.links[SLIDES].body, r.bodies[SLIDES].id);
    assert_true(model.links[SLIDES].origin[0] == 1 && model.base[2] == 5);
    assert_int_equal(collided_sync(r.c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(move(&r, 0.5, 0.25), COLLIDED_OK);
    const wire_pose_batch *sent = &fake_message(WIRE_POSE_BATCH, 0)->pose_batch;
    wire_joints j;
    assert_int_equal(sent->bodies.count, 0);
    assert_true(wire_joints_find(sent->extensions, &record) && wire_joints_next(&record, &j));
    assert_true(j.body == r.bodies[TURNS].id && j.count == 2 && j.values[0] == 0.5 && j.values[1] == 0.25);
    end(&r);
}

static void is_at(const wire_pose_batch *b, uint32_t i, double x, double y, double z)
{
    const double *p = b->positions.at + 3 * i;
    if (fabs(p[0] - x) + fabs(p[1] - y) + fabs(p[2] - z) > 1e-12) fail_msg("%u: %g %g %g", i, p[0], p[1], p[2]);
}

static void they_go_out_as_poses_while_a_body_is_not_known(void **state)
{
    (void)state;
    robot r;
    begin(&r, (fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1});
    fake_ack(fake_message(WIRE_BODY, SLIDES));
    fake_settle();
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_OK);
    assert_int_equal(move(&r, M_PI / 2, 0.25), COLLIDED_OK);
    const wire_pose_batch *sent = &fake_message(WIRE_POSE_BATCH, 0)->pose_batch;
    assert_int_equal(sent->bodies.count, 1);
    assert_int_equal(sent->bodies.at[0], r.bodies[SLIDES].id);
    is_at(sent, 0, 0, 1.25, 5);
    fake_ack(fake_message(WIRE_BODY, BODIES)); /* the other one was kept until now */
    sent = &fake_message(WIRE_POSE_BATCH, 1)->pose_batch;
    assert_int_equal(sent->bodies.at[0], r.bodies[TURNS].id);
    is_at(sent, 0, 0, 0, 5);
    end(&r);
}

/* A daemon that was started anew is told where they are, and of the robot. */
static void a_new_daemon_hears_of_robot_and_places(void **state)
{
    (void)state;
    robot r;
    begin(&r, (fake_options){.repeats = true, .epoch = 1});
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_OK);
    assert_int_equal(collided_sync(r.c, FAKE_PATIENCE_S), COLLIDED_OK);
    assert_int_equal(move(&r, M_PI / 2, 0.25), COLLIDED_OK);
    size_t before = fake_sent(WIRE_BODY);
    fake_set((fake_options){.repeats = true, .epoch = A_LATER_EPOCH});
    fake_status(A_LATER_EPOCH);
    bool slid = false, carries = false;
    for (size_t i = 0; i < BODIES; i++) {
        const wire_body *b = &fake_message(WIRE_BODY, before + i)->body;
        wire_u8s record;
        slid |= b->body == r.bodies[SLIDES].id && fabs(b->pose.at[1] - 1.25) < 1e-12;
        carries |= b->body == r.bodies[TURNS].id && wire_model_find(b->extensions, &record);
    }
    assert_true(slid);
    assert_true(carries);
    fake_set((fake_options){.repeats = true, .epoch = A_LATER_EPOCH});
    collided_close(r.c);
}

static void a_part_rides_along_until_it_is_let_go(void **state)
{
    (void)state;
    robot r;
    wire_u8s record;
    wire_model model;
    wire_refusal why;
    const collided_pose in_link = {{0, 0, 1}, {1, 0, 0, 0}};
    begin(&r, (fake_options){.repeats = true, .epoch = 1});
    assert_int_equal(
        collided_attach(r.c, r.bodies[TURNS], r.bodies[PART], r.bodies[SLIDES], &in_link), COLLIDED_UNKNOWN_ID);
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_OK);
    assert_int_equal(collided_sync(r.c, FAKE_PATIENCE_S), COLLIDED_OK);
    fake_set((fake_options){.repeats = true, .ignored = WIRE_BODY, .epoch = 1}); /* until then as poses */
    assert_int_equal(collided_attach(r.c, r.bodies[TURNS], r.bodies[PART], r.bodies[SLIDES], &in_link), COLLIDED_OK);
    assert_int_equal(move(&r, M_PI / 2, 0), COLLIDED_OK);
    const wire_pose_batch *sent = &fake_message(WIRE_POSE_BATCH, 0)->pose_batch;
    assert_int_equal(sent->bodies.count, 2); /* but for the carrier, which waits */
    is_at(sent, 0, 0, 1, 5);
    is_at(sent, 1, 0, 1, 6);
    assert_int_equal(sent->bodies.at[1], r.bodies[PART].id);
    assert_int_equal(
        collided_attach(r.c, r.bodies[TURNS], r.bodies[PART], r.bodies[SLIDES], &in_link), COLLIDED_BAD_ARGUMENT);
    const wire_body *carrier = &fake_message(WIRE_BODY, BODIES + 1)->body;
    assert_true(wire_model_find(carrier->extensions, &record));
    assert_int_equal(wire_model_read(record, &model, &why), WIRE_OK);
    assert_true(model.count == 3 && model.links[2].body == r.bodies[PART].id && model.links[2].parent == SLIDES);
    assert_int_equal(collided_detach(r.c, r.bodies[TURNS], r.bodies[SLIDES]), COLLIDED_UNKNOWN_ID); /* it moves */
    assert_int_equal(collided_detach(r.c, r.bodies[TURNS], r.bodies[PART]), COLLIDED_OK);
    assert_int_equal(collided_detach(r.c, r.bodies[TURNS], r.bodies[PART]), COLLIDED_UNKNOWN_ID);
    end(&r);
}

static void what_is_no_robot_is_refused_here(void **state)
{
    (void)state;
    robot r;
    begin(&r, (fake_options){.repeats = true, .epoch = 1});
    const collided_body nobody = {77};
    assert_int_equal(move(&r, 0, 0), COLLIDED_UNKNOWN_ID);
    assert_int_equal(collided_set_robot(r.c, nobody, &r.tree), COLLIDED_UNKNOWN_ID);
    r.joints[1].body = "somebody else's";
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_UNKNOWN_ID);
    r.joints[1].body = "turns"; /* twice */
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_BAD_ARGUMENT);
    r.joints[1].body = "slides";
    r.joints[1].parent = 1;
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_BAD_ARGUMENT);
    r.joints[1].parent = 0;
    r.joints[1].mimics = true, r.joints[1].mimic = 1;
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_BAD_ARGUMENT);
    r.joints[1].mimics = false;
    r.tree.joint_count = 0;
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_BAD_ARGUMENT);
    r.tree.joint_count = 2;
    assert_int_equal(collided_set_robot(r.c, r.bodies[TURNS], &r.tree), COLLIDED_OK);
    assert_int_equal(move(&r, NAN, 0), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(move(&r, 0, INFINITY), COLLIDED_BAD_ARGUMENT);
    const collided_joint_state none = {0};
    assert_int_equal(collided_publish_joints(r.c, r.bodies[TURNS], &none, 2, 0, 0), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_publish_joints(r.c, r.bodies[TURNS], &none, 0, 0, 0), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(fake_sent(WIRE_POSE_BATCH), 0);
    assert_int_equal(collided_remove_body(r.c, r.bodies[TURNS]), COLLIDED_OK);
    assert_int_equal(move(&r, 0, 0), COLLIDED_UNKNOWN_ID);
    end(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(joints_go_out_as_joints),
        cmocka_unit_test(they_go_out_as_poses_while_a_body_is_not_known),
        cmocka_unit_test(a_new_daemon_hears_of_robot_and_places),
        cmocka_unit_test(a_part_rides_along_until_it_is_let_go),
        cmocka_unit_test(what_is_no_robot_is_refused_here),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
