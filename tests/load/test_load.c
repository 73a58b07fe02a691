/* collided_load.h as a user has it: what is told of a robot, values, poses, bodies as they are announced, scenes, and
 * every refusal with its reason. */
#include "cmocka_c.h"
#include "fake.h"

#include <collided_load.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const char ARM[] = EXAMPLES "/arm.urdf", STATES[] = EXAMPLES "/arm.srdf";

static void error_has(const char *words)
{
    if (!strstr(collided_load_error(), words)) fail_msg("the error '%s' lacks: %s", collided_load_error(), words);
}

static collided_loaded_robot *load_arm(const char *prefix)
{
    collided_load_def def = collided_load_def_default();
    def.prefix = prefix;
    collided_loaded_robot *arm = collided_load_urdf(ARM, &def);
    if (!arm) fail_msg("%s", collided_load_error());
    if (collided_load_srdf(arm, STATES)) fail_msg("%s", collided_load_error());
    assert_string_equal(collided_load_error(), "");
    return arm;
}

/* A file of this test's own. */
static const char *write_file(const char *name, const char *text)
{
    static char path[512];
    snprintf(path, sizeof path, "%s/%s", MADE, name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    assert_int_equal(fclose(f), 0);
    return path;
}

static void a_robot_tells_what_it_has(void **state)
{
    (void)state;
    collided_loaded_robot *arm = load_arm("left_");
    size_t joints, links, states;
    const collided_loaded_joint *j = collided_loaded_joints(arm, &joints);
    const collided_loaded_link *l = collided_loaded_links(arm, &links);
    const collided_loaded_state *s = collided_loaded_states(arm, &states);
    assert_string_equal(collided_loaded_name(arm), "arm");
    assert_int_equal(joints, 7);
    assert_int_equal(links, 8);
    assert_int_equal(collided_loaded_body_count(arm), 8);
    assert_string_equal(l[0].name, "base_link");
    assert_string_equal(l[0].body, "left_base_link");
    assert_int_equal(l[0].joint, -1);
    size_t moving = 0;
    for (size_t i = 0; i < joints; i++) {
        assert_int_equal(l[j[i].child].joint, i);
        assert_int_equal(j[i].mimics, -1);
        if (j[i].type != COLLIDED_JOINT_REVOLUTE) continue;
        assert_true(j[i].limited && j[i].lower < -3 && j[i].upper > 3);
        moving++;
    }
    assert_int_equal(moving, 6);
    bool at_a = false;
    for (size_t i = 0; i < states; i++) at_a |= strcmp(s[i].name, "at_a") == 0;
    assert_true(at_a);
    collided_loaded_robot_free(arm);
    collided_loaded_robot_free(NULL);
}

static void values_are_checked(void **state)
{
    (void)state;
    collided_loaded_robot *arm = load_arm(NULL);
    double values[7];
    collided_loaded_default_values(arm, values);
    for (int i = 0; i < 7; i++) assert_true(values[i] == 0);
    assert_int_equal(collided_loaded_state_values(arm, "at_a", values), COLLIDED_OK);
    assert_true(values[1] != 0);
    assert_int_equal(collided_loaded_state_values(arm, "nowhere", values), COLLIDED_UNKNOWN_ID);
    error_has("it has: ");
    size_t joints;
    const collided_loaded_joint *j = collided_loaded_joints(arm, &joints);
    for (size_t i = 0; i < joints; i++) {
        bool fixed = j[i].type == COLLIDED_JOINT_FIXED;
        assert_int_equal(
            collided_loaded_set_value(arm, j[i].name, 0.5, values), fixed ? COLLIDED_BAD_ARGUMENT : COLLIDED_OK);
        if (!fixed) assert_true(values[i] == 0.5);
        assert_int_equal(collided_loaded_set_value(arm, j[i].name, NAN, values), COLLIDED_BAD_ARGUMENT);
    }
    error_has("not finite");
    assert_int_equal(collided_loaded_set_value(arm, "tail", 0, values), COLLIDED_UNKNOWN_ID);
    error_has("no joint 'tail'");
    collided_loaded_robot_free(arm);
}

/* Two ways to the same poses: link by link, and by the tree that checks take, multiplied here. */
static void poses_are_those_of_the_tree(void **state)
{
    (void)state;
    collided_loaded_robot *arm = load_arm(NULL);
    const collided_pose base = {{1, 2, 3}, {0.6, 0, 0.8, 0}};
    collided_pose bodies[8], links[8], tree_poses[8];
    double values[7], configuration[6], back[7] = {0};
    collided_robot tree;
    assert_int_equal(collided_loaded_state_values(arm, "at_b", values), COLLIDED_OK);
    collided_loaded_body_poses(arm, base, values, bodies);
    collided_loaded_link_poses(arm, base, values, links);
    assert_int_equal(collided_loaded_tree(arm, base, &tree), COLLIDED_OK);
    assert_int_equal(tree.joint_count, 8);
    assert_int_equal(collided_robot_coordinates(&tree), 6);
    collided_loaded_configuration(arm, values, configuration);
    collided_loaded_values(arm, configuration, back);
    int next = 0;
    for (size_t i = 0; i < tree.joint_count; i++) {
        const collided_joint *j = &tree.joints[i];
        collided_pose turned = collided_pose_identity();
        if (j->type == COLLIDED_JOINT_REVOLUTE) {
            double half = configuration[next++] / 2;
            turned.orientation[0] = cos(half);
            for (int k = 0; k < 3; k++) turned.orientation[k + 1] = sin(half) * j->axis[k];
        }
        collided_pose at = collided_pose_product(j->origin, turned);
        tree_poses[i] = collided_pose_product(j->parent < 0 ? tree.base : tree_poses[j->parent], at);
    }
    size_t count;
    const collided_loaded_link *l = collided_loaded_links(arm, &count);
    for (size_t i = 0; i < 8; i++) {
        assert_memory_equal(&bodies[i], &links[i], sizeof bodies[i]);
        for (size_t k = 0; k < tree.joint_count; k++)
            if (strcmp(tree.joints[k].body, l[i].body) == 0)
                for (int x = 0; x < 3; x++) assert_true(fabs(tree_poses[k].position[x] - links[i].position[x]) < 1e-12);
    }
    for (int i = 0; i < 7; i++) assert_true(back[i] == values[i] || back[i] == 0);
    collided_loaded_robot_free(arm);
}

static void bodies_are_announced(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_loaded_robot *arm = load_arm("left_");
    double values[7];
    collided_body bodies[8];
    collided_pose poses[8];
    assert_int_equal(collided_loaded_state_values(arm, "at_a", values), COLLIDED_OK);
    const collided_placement at = {.base = {{0, 0, 0.75}, {1, 0, 0, 0}}, .values = values, .deadline_s = 0.25};
    assert_int_equal(collided_create_loaded(c, arm, &at, bodies), COLLIDED_OK);
    collided_loaded_body_poses(arm, at.base, values, poses);
    for (size_t i = 0; i < 8; i++) {
        const wire_body *b = &fake_message(WIRE_BODY, i)->body;
        assert_int_equal(b->body, bodies[i].id);
        assert_int_equal(strncmp(b->name, "left_", 5), 0);
        assert_string_equal(b->group, "arm");
        assert_true(b->deadline_ns == 250000000);
        assert_true(b->rule_patterns.count > 0);
        assert_memory_equal(b->pose.at, &poses[i], sizeof poses[i]);
    }
    /* Again, elsewhere; an SRDF is too late now. */
    assert_int_equal(collided_load_srdf(arm, STATES), COLLIDED_BAD_ARGUMENT);
    error_has("before the robot's bodies are created");
    const collided_placement nowhere = {.base = {{NAN, 0, 0}, {1, 0, 0, 0}}, .values = values};
    assert_int_equal(
        collided_create_loaded(c, arm, &nowhere, bodies), COLLIDED_BAD_ARGUMENT); /* the client's own word */
    assert_int_equal(bodies[0].id, COLLIDED_NONE);
    error_has("pose");
    assert_int_equal(collided_create_loaded(c, arm, NULL, bodies), COLLIDED_BAD_ARGUMENT);
    collided_close(c);
    collided_loaded_robot_free(arm);
}

static void scenes_are_loaded(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_loaded_scene *scene = collided_load_scene(
        write_file("load.yaml",
            "bodies:\n  - name: table\n    motion: fixed\n    shapes: [{type: box, size: [1, 1, 0.1]}]\n"
            "robots:\n  - {urdf: " EXAMPLES "/arm.urdf, srdf: " EXAMPLES "/arm.srdf, prefix: r_, "
            "state: at_b, pose: {position: [0, 0, 1]}}\n"),
        NULL);
    if (!scene) fail_msg("%s", collided_load_error());
    assert_int_equal(collided_loaded_scene_body_count(scene), 9);
    assert_string_equal(collided_loaded_scene_body_name(scene, 0), "table");
    assert_string_equal(collided_loaded_scene_body_name(scene, 1), "r_base_link");
    assert_null(collided_loaded_scene_body_name(scene, 9));
    size_t robots;
    const collided_loaded_placed *placed = collided_loaded_scene_robots(scene, &robots);
    assert_int_equal(robots, 1);
    assert_int_equal(placed->first_body, 1);
    assert_true(placed->base.position[2] == 1 && placed->values[1] != 0);
    assert_int_equal(collided_loaded_body_count(placed->robot), 8);
    collided_body bodies[9];
    assert_int_equal(collided_create_loaded_scene(c, scene, bodies), COLLIDED_OK);
    for (size_t i = 0; i < 9; i++)
        assert_string_equal(fake_message(WIRE_BODY, i)->body.name, collided_loaded_scene_body_name(scene, i));
    collided_close(c);
    collided_loaded_scene_free(scene);
    collided_loaded_scene_free(NULL);
}

static void what_is_wrong_is_refused_by_name(void **state)
{
    (void)state;
    collided_load_def def = collided_load_def_default();
    assert_null(collided_load_urdf(NULL, NULL));
    error_has("no path");
    assert_null(collided_load_urdf("/nowhere/arm.urdf", NULL));
    error_has("/nowhere/arm.urdf: No such file");
    def.meshes = "spheres";
    assert_null(collided_load_urdf(ARM, &def));
    error_has("decompose:N");
    assert_null(collided_load_scene("x.yaml", &def));
    error_has("says itself");
    assert_null(collided_load_scene("/nowhere/x.yaml", NULL));
    error_has("No such file");
    def = collided_load_def_default();
    def.packages = &(collided_load_package){.name = "p"};
    def.package_count = 1;
    assert_null(collided_load_urdf(ARM, &def));
    error_has("no path");
    assert_null(collided_load_urdf(
        write_file(
            "x.urdf", "<robot name='r' xmlns:xacro='http://ros.org/wiki/xacro'><xacro:arm side='left'/></robot>"),
        NULL));
    error_has("x.urdf:1: this is a xacro file");
    collided_loaded_robot *arm = collided_load_urdf(ARM, NULL);
    assert_non_null(arm);
    assert_int_equal(collided_load_srdf(arm, "/nowhere"), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(collided_load_srdf(arm, ARM), COLLIDED_OK); /* no states in it: it is no SRDF, but a robot */
    assert_int_equal(collided_load_srdf(arm, STATES), COLLIDED_OK);
    double values[7];
    assert_int_equal(collided_loaded_state_values(arm, "at_a", values), COLLIDED_OK);
    collided_loaded_robot_free(arm);
}

static void a_missing_mesh_creates_nothing(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = 1});
    collided *c = fake_connect();
    collided_loaded_robot *r = collided_load_urdf(
        write_file("meshes.urdf",
            "<robot name='r'><link name='a'><collision><geometry><box size='1 1 1'/></geometry></collision></link>"
            "<link name='b'><collision><geometry><mesh filename='package://gone/b.stl'/></geometry></collision></link>"
            "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint></robot>"),
        NULL);
    assert_non_null(r);
    collided_body bodies[2];
    const collided_placement at = {.base = collided_pose_identity()};
    assert_int_equal(collided_create_loaded(c, r, &at, bodies), COLLIDED_BAD_ARGUMENT);
    error_has("ROS_PACKAGE_PATH");
    assert_int_equal(bodies[0].id, COLLIDED_NONE);
    collided_close(c);
    assert_int_equal(fake_sent(WIRE_BODY), 0);
    collided_loaded_robot_free(r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_robot_tells_what_it_has),
        cmocka_unit_test(values_are_checked),
        cmocka_unit_test(poses_are_those_of_the_tree),
        cmocka_unit_test(bodies_are_announced),
        cmocka_unit_test(scenes_are_loaded),
        cmocka_unit_test(what_is_wrong_is_refused_by_name),
        cmocka_unit_test(a_missing_mesh_creates_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
