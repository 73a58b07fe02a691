/* YAML scenes: what is read, and what is refused with which words. */
#include "fixture.h"

#include "loaders/text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define BODY(shape) "bodies:\n  - name: a\n    shapes:\n      - " shape "\n"

static void read_cell(fixture *f, scene *s)
{
    size_t size;
    fixture_begin(f);
    const char *path = LOADERS_DATA "/cell.yaml";
    const char *data = text_read_file(&f->pool, path, SCENE_SIZE_MAX, &size, &f->report);
    if (!data || !scene_parse(s, &f->pool, data, size, path, &f->report)) fail_msg("%s", f->report.error);
}

static void bodies_are_read_as_they_are_written(void **state)
{
    (void)state;
    fixture f;
    scene s;
    read_cell(&f, &s);
    assert_int_equal(s.bodies.count, 2);
    const load_body *table = &s.bodies.at[0], *part = &s.bodies.at[1];
    assert_string_equal(table->name, "table");
    assert_string_equal(table->group, "furniture");
    assert_int_equal(table->motion, COLLIDED_FIXED);
    assert_true(table->pose.position[0] == 0.5 && fabs(table->pose.orientation[3] - sqrt(0.5)) < 1e-15);
    assert_true(table->shapes[0].shape.half[0] == 0.4);
    assert_int_equal(table->rule_count, 2);
    assert_true(table->rules[0].allow && !table->rules[1].allow);
    assert_string_equal(table->rules[0].reason, "parts lie on the table");
    assert_string_equal(table->rules[1].reason, "");
    assert_true(table->rules[1].padding_m == 0.05 && table->rules[1].margin_m == 0.5);
    assert_true(table->rules[0].padding_m == 0 && table->rules[0].margin_m == 0);
    assert_true(table->category == 4 && table->mask == UINT64_MAX - 1 && table->one_way);
    assert_true(table->ccd == COLLIDED_CCD_FULL && part->ccd == COLLIDED_CCD_OFF);
    assert_true(table->acceleration_m_s2 == 3 && table->angular_acceleration_rad_s2 == 0.5);
    assert_true(part->acceleration_m_s2 == 0 && part->angular_acceleration_rad_s2 == 0);
    assert_true(part->category == 1 && part->mask == UINT64_MAX && !part->one_way);
    assert_int_equal(part->motion, COLLIDED_MOVING);
    assert_string_equal(part->group, "");
    fixture_end(&f);
}

static void every_shape_is_read(void **state)
{
    (void)state;
    fixture f;
    scene s;
    read_cell(&f, &s);
    load_body *part = &s.bodies.at[1];
    static const collided_shape_type types[] = {COLLIDED_SPHERE, COLLIDED_CAPSULE, COLLIDED_CYLINDER, COLLIDED_CONE,
        COLLIDED_ELLIPSOID, COLLIDED_HALFSPACE, COLLIDED_HULL, COLLIDED_HULL};
    assert_int_equal(part->shape_count, 8);
    for (int i = 0; i < 8; i++) assert_int_equal(part->shapes[i].shape.type, types[i]);
    assert_true(part->shapes[0].shape.radius == 0.1);
    assert_true(part->shapes[1].shape.half[2] == 0.2 && part->shapes[1].shape.pose.orientation[1] == 1);
    assert_true(part->shapes[2].shape.radius == 0.01 && part->shapes[2].shape.half[1] == 0.1);
    assert_true(part->shapes[4].shape.half[2] == 3);
    assert_int_equal(part->shapes[6].points.count, 4);
    assert_int_equal(part->shapes[7].points.count, 0);
    assert_true(load_body_meshes(&f.pool, part, &f.report));
    assert_int_equal(part->shapes[7].points.count, 4);
    assert_true(part->shapes[7].points.at[11] == 0 && part->shapes[7].points.at[9] == 0.001);
    fixture_end(&f);
}

static void a_height_field_is_read_from_its_file(void **state)
{
    (void)state;
    static const char text[] = "bodies:\n  - name: ground\n    motion: fixed\n    shapes:\n"
                               "      - {type: height_field, heights: ground.txt, spacing: [0.5, 0.25], base: 2}\n"
                               "      - {type: height_field, heights: ground8.png, spacing: [1, 1], base: 1, range: "
                               "[0, 255], rounding: 0.125}\n";
    fixture f;
    scene s;
    fixture_begin(&f);
    if (!scene_parse(&s, &f.pool, text, sizeof text - 1, LOADERS_DATA "/test.yaml", &f.report))
        fail_msg("%s", f.report.error);
    load_body *ground = &s.bodies.at[0];
    if (!load_body_meshes(&f.pool, ground, &f.report)) fail_msg("%s", f.report.error);
    const load_heights *h = &ground->shapes[0].heights, *picture = &ground->shapes[1].heights;
    assert_int_equal(ground->shapes[0].shape.type, COLLIDED_HEIGHT_FIELD);
    assert_true(h->spacing[0] == 0.5 && h->spacing[1] == 0.25 && h->base == 2);
    assert_true(h->grid.rows == 3 && h->grid.columns == 3 && h->grid.at[1] == 0.5);
    assert_true(picture->grid.at[3] == 255 && ground->shapes[1].shape.radius == 0.125);
    fixture_end(&f);
}

static void height_fields_that_cannot_be_are_refused(void **state)
{
    (void)state;
#define FIELD(rest) BODY("{type: height_field, heights: a.txt" rest "}")
    scene_is_refused(FIELD(", base: 1"), "needs the key 'spacing'");
    scene_is_refused(FIELD(", spacing: [1, 1]"), "needs the key 'base'");
    scene_is_refused(BODY("{type: height_field, spacing: [1, 1], base: 1}"), "needs the key 'heights'");
    scene_is_refused(BODY("{type: box, size: [1, 1, 1], base: 1}"), "'base' does not belong");
    scene_is_refused(BODY("{type: box, size: [1, 1, 1], range: [0, 1]}"), "'range' does not belong");
    scene_is_refused(FIELD(", spacing: [1, 1], base: 1, mesh: a.stl"), "'mesh' does not belong");
    scene_is_refused(FIELD(", spacing: [1, 0], base: 1"), "spacing is 0: must be finite and above 0");
    scene_is_refused(FIELD(", spacing: [inf, 1], base: 1"), "spacing is inf");
    scene_is_refused(FIELD(", spacing: [1, 1], base: -1"), "base is -1");
    scene_is_refused(FIELD(", spacing: [1, 1], base: nan"), "base is nan");
    scene_is_refused(FIELD(", spacing: [1, 1], base: 1, range: [0, inf]"), "range is not finite");
    scene_is_refused(FIELD(", spacing: [1], base: 1"), "Insufficient entries");
}

static void robots_are_read_with_paths_beside_the_scene(void **state)
{
    (void)state;
    fixture f;
    scene s;
    read_cell(&f, &s);
    assert_int_equal(s.robot_count, 1);
    const scene_robot *r = &s.robots[0];
    assert_string_equal(r->source.urdf, LOADERS_DATA "/arm.urdf");
    assert_string_equal(r->source.srdf, LOADERS_DATA "/arm.srdf");
    assert_string_equal(r->source.packages[0].path, LOADERS_DATA "/meshes");
    assert_string_equal(r->source.prefix, "left_");
    assert_string_equal(r->state, "ready");
    assert_string_equal(r->joints[0], "j1");
    assert_true(r->ccd == COLLIDED_CCD_LINEAR && r->acceleration_m_s2 == 2 && r->angular_acceleration_rad_s2 == 0);
    assert_true(r->values[0] == 0.3 && r->pose.position[0] == 1 && r->motion == COLLIDED_FIXED);
    fixture_end(&f);
}

static void what_does_not_follow_the_schema_is_refused_with_its_line(void **state)
{
    (void)state;
    scene_is_refused(BODY("{type: box, size: [1, 1, 1], colour: red}"), "test.yaml:4: Unexpected key: colour");
    scene_is_refused("doors: []\n", "Unexpected key: doors");
    scene_is_refused("bodies:\n  - name: a\n", "test.yaml:2: Missing required mapping field: shapes");
    scene_is_refused("bodies:\n  - name: a\n    shapes: []\n", "Insufficient entries");
    scene_is_refused(BODY("{type: pyramid}"), "test.yaml:4: Invalid ENUM value: pyramid");
    scene_is_refused(BODY("{type: box, size: [1, 1]}"), "test.yaml:4: Insufficient entries");
    scene_is_refused(BODY("{type: sphere, radius: big}"), "test.yaml:4: Invalid FLOAT value: big");
    scene_is_refused("", "test.yaml: the file is empty");
    scene_is_refused("bodies: [\n", "libyaml");
    scene_is_refused("bodies:\n  - name: &x a\n    group: *x\n    shapes: [{type: halfspace}]\n", "test.yaml:3:");
    scene_is_refused("a: &a [x,x,x]\nb: &b [*a,*a,*a]\nc: [*b,*b,*b]\n", "Unexpected key: a");
}

static void motions_that_cannot_be_are_refused(void **state)
{
    (void)state;
#define MOTION(key) "bodies:\n  - name: a\n    " key "\n    shapes: [{type: halfspace}]\n"
    scene_is_refused(MOTION("ccd: sometimes"), "test.yaml:3: Invalid ENUM value: sometimes");
    scene_is_refused(MOTION("acceleration: -1"), "body 'a': acceleration is -1: must be finite and not negative");
    scene_is_refused(MOTION("angular_acceleration: inf"), "body 'a': angular_acceleration is inf");
    scene_is_refused("robots:\n  - {urdf: a.urdf, acceleration: nan}\n", "a.urdf': acceleration is nan");
}

static void shapes_that_cannot_be_are_refused(void **state)
{
    (void)state;
    scene_is_refused(BODY("{type: box, size: [1, -1, 1]}"), "body 'a', shape 1: size is -1");
    scene_is_refused(BODY("{type: box, size: [1, .nan, 1]}"), "test.yaml");
    scene_is_refused(BODY("{type: box, size: [1, nan, 1]}"), "must be finite");
    scene_is_refused(BODY("{type: sphere, radius: inf}"), "must be finite");
    scene_is_refused(BODY("{type: sphere, radius: 1, rounding: -1}"), "rounding is -1");
    scene_is_refused(BODY("{type: box, radius: 1}"), "needs the key 'size'");
    scene_is_refused(BODY("{type: sphere, radius: 1, height: 2}"), "'height' does not belong");
    scene_is_refused(BODY("{type: hull}"), "'points' or 'mesh'");
    scene_is_refused(BODY("{type: hull, mesh: a.stl, points: [[0, 0, 0]]}"), "'points' does not belong");
    scene_is_refused(BODY("{type: hull, points: [[0, 0, inf]]}"), "point 1 is not finite");
}

static void poses_names_and_joints_that_cannot_be_are_refused(void **state)
{
    (void)state;
    scene_is_refused(BODY("{type: halfspace, pose: {orientation: [0, 0, 0, 0]}}"), "norm 0, not 1");
    scene_is_refused(BODY("{type: halfspace, pose: {orientation: [nan, 0, 0, 1]}}"), "norm");
    scene_is_refused(BODY("{type: halfspace, pose: {position: [inf, 0, 0]}}"), "not finite");
    scene_is_refused(BODY("{type: halfspace, pose: {rpy: [0, 0, 0], orientation: [1, 0, 0, 0]}}"), "give one of them");
    scene_is_refused("bodies:\n  - name: 'a*'\n    shapes: [{type: halfspace}]\n", "patterns");
    scene_is_refused(
        BODY("{type: halfspace}") "  - name: a\n    shapes: [{type: halfspace}]\n", "two bodies named 'a'");
    scene_is_refused("robots:\n  - urdf: a\n    joints: [{name: j, value: nan}]\n", "joint 'j' is not finite");
}

/* As for URDF: each prefix and each changed byte is read or refused. */
static void damaged_files_do_no_harm(void **state)
{
    (void)state;
    static const char good[] = BODY(
        "{type: hull, points: [[0, 0, 0], [1, 0, 0]], pose: {position: [1, 2, 3]}}") "    rules: [{pattern: b, allow: "
                                                                                     "true}]\nrobots:\n  - urdf: x\n   "
                                                                                     " joints: [{name: j, value: 1}]\n";
    size_t size = sizeof good - 1;
    for (size_t i = 0; i < 2 * size; i++) {
        char text[sizeof good];
        memcpy(text, good, sizeof good);
        if (i >= size) text[i - size] = (char)(i * 37 + 1);
        fixture f;
        scene s;
        fixture_begin(&f);
        bool ok = scene_parse(&s, &f.pool, text, i < size ? i : size, "test.yaml", &f.report);
        assert_int_equal(ok, f.report.error[0] == '\0');
        fixture_end(&f);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_are_read_as_they_are_written),
        cmocka_unit_test(every_shape_is_read),
        cmocka_unit_test(a_height_field_is_read_from_its_file),
        cmocka_unit_test(height_fields_that_cannot_be_are_refused),
        cmocka_unit_test(robots_are_read_with_paths_beside_the_scene),
        cmocka_unit_test(what_does_not_follow_the_schema_is_refused_with_its_line),
        cmocka_unit_test(motions_that_cannot_be_are_refused),
        cmocka_unit_test(shapes_that_cannot_be_are_refused),
        cmocka_unit_test(poses_names_and_joints_that_cannot_be_are_refused),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
