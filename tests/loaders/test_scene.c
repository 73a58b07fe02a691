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
    assert_int_equal(s.bodies.count, 3);
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

/* The page for users: its example is a scene. Its keys: test_scene_page. */
static void the_example_of_the_page_is_read(void **state)
{
    (void)state;
    fixture f;
    scene s;
    size_t size;
    fixture_begin(&f);
    const char *page = text_read_file(&f.pool, SCENES_PAGE, SCENE_SIZE_MAX, &size, &f.report);
    assert_non_null(page);
    const char *from = strstr(page, "```yaml\n"), *end = from ? strstr(from + 8, "```") : NULL;
    assert_non_null(end);
    char *example = pool_alloc(&f.pool, (size_t)(end - from), 1); /* zeros behind */
    memcpy(example, from + 8, (size_t)(end - from) - 8);
    if (!scene_parse(&s, &f.pool, example, strlen(example), "SCENES.md", &f.report)) fail_msg("%s", f.report.error);
    assert_int_equal(s.bodies.count, 2);
    assert_int_equal(s.bodies.at[1].shapes[1].child_count, 2);
    assert_int_equal(s.robot_count, 1);
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

static void compounds_are_read_with_their_children(void **state)
{
    (void)state;
    fixture f;
    scene s;
    read_cell(&f, &s);
    load_body *bracket = &s.bodies.at[2];
    load_shape *whole = &bracket->shapes[0];
    assert_int_equal(bracket->shape_count, 1);
    assert_int_equal(whole->shape.type, COLLIDED_COMPOUND);
    assert_true(whole->shape.radius == 0.002 && whole->shape.pose.position[2] == 1);
    assert_int_equal(whole->child_count, 3);
    assert_true(whole->children[0].shape.half[0] == 0.1 && whole->children[0].shape.radius == 0);
    assert_true(whole->children[1].shape.type == COLLIDED_CYLINDER);
    assert_true(whole->children[1].shape.pose.position[2] == 0.1);
    assert_true(load_body_meshes(&f.pool, bracket, &f.report));
    assert_int_equal(whole->children[2].points.count, 4);
    fixture_end(&f);
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

/* libcyaml says where the last good value began; the key that is wrong stands behind it. */
static void wrong_keys_are_told_in_their_own_line(void **state)
{
    (void)state;
#define WITH_BOX(head, tail) head "      - type: box\n        size: [1, 2, 3]\n" tail
    scene_is_refused(
        WITH_BOX("bodies:\n  - name: a\n    shapes:\n", "        wide: 3\n"), "test.yaml:6: Unexpected key: wide");
    scene_is_refused(
        WITH_BOX("bodies:\n  - name: a\n    shapes:\n", "    type: 3\n"), "test.yaml:6: Unexpected key: type");
    scene_is_refused(
        WITH_BOX("bodies:\n  - name: a\n    shapes:\n", "\n# b\n  - nome: b\n"), "test.yaml:8: Unexpected key: nome");
    scene_is_refused(
        WITH_BOX("bodies:\n  - name: a\n    shapes:\n", "\nrobot: 3\n"), "test.yaml:7: Unexpected key: robot");
    scene_is_refused(WITH_BOX("bodies:\n  - shapes:\n", ""), "test.yaml:2: Missing required mapping field: name");
    scene_is_refused("bodies:\n  - name: a\n    name: b\n", "test.yaml:3: Mapping field already seen: name");
    scene_is_refused("bodies:\r\n- name: a\r\n  shapes: [{type: halfspace}]\r\n  colour: 1\r\n",
        "test.yaml:4: Unexpected key: colour");
    scene_is_refused(
        "bodies:\n- name: a\n  shapes: [{type: halfspace}]\nrobot: 1", "test.yaml:4: Unexpected key: robot");
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
    scene_is_refused(BODY("{type: mesh, mesh: a.stl, as: soup}"), "Invalid ENUM value: soup");
    scene_is_refused(BODY("{type: mesh, mesh: a.stl, as: hull, pieces: 3}"), "'pieces' does not belong");
    scene_is_refused(BODY("{type: hull, mesh: a.stl, as: solid}"), "'as' does not belong");
    scene_is_refused(BODY("{type: mesh, mesh: a.stl, as: decompose, pieces: 0}"), "pieces must be from 1 to 128");
    scene_is_refused(BODY("{type: mesh, mesh: a.stl, as: decompose, deviation: 0}"), "deviation is 0");
    scene_is_refused("robots:\n  - {urdf: a, meshes: decompose:}\n", "test.yaml");
    scene_is_refused(
        "robots:\n  - {urdf: a, meshes: 'decompose:129'}\n", "meshes 'decompose:129': must be hull, solid");
    scene_is_refused(BODY("{type: sphere, radius: 1, deviation: -1}"), "deviation is -1");
    scene_is_refused(BODY("{type: box, size: [1, 1, 1], deviation: inf}"), "deviation is inf");
    scene_is_refused(BODY("{type: hull}"), "'points' or 'mesh'");
    scene_is_refused(BODY("{type: hull, mesh: a.stl, points: [[0, 0, 0]]}"), "'points' does not belong");
    scene_is_refused(BODY("{type: hull, points: [[0, 0, inf]]}"), "point 1 is not finite");
}

static void compounds_that_cannot_be_are_refused(void **state)
{
    (void)state;
    scene_is_refused(BODY("{type: compound}"), "needs the key 'children'");
    scene_is_refused(BODY("{type: compound, children: []}"), "shape 1");
    scene_is_refused(BODY("{type: sphere, radius: 1, children: [{type: sphere, radius: 1}]}"), "'children' does not");
    scene_is_refused(BODY("{type: compound, children: [{type: sphere, radius: 1}, {type: box}]}"),
        "body 'a', shape 1, child 2: it needs the key 'size'");
    scene_is_refused(BODY("{type: compound, children: [{type: halfspace}]}"),
        "child 1: a half-space, mesh, height field or compound");
    scene_is_refused(
        BODY("{type: compound, children: [{type: height_field, heights: a.txt, spacing: [1, 1], base: 1}]}"),
        "cannot be one");
    scene_is_refused(BODY("{type: compound, children: [{type: mesh, mesh: a.stl}]}"), "cannot be one");
    scene_is_refused(BODY("{type: compound, children: [{type: compound}]}"), "cannot be one");
    scene_is_refused(
        BODY("{type: compound, children: [{type: sphere, radius: 1, children: []}]}"), "Unexpected key: children");
    char many[16384] = "bodies:\n  - name: a\n    shapes:\n      - {type: sphere, radius: 1}\n      - type: compound\n"
                       "        children:\n";
    for (int i = 0; i < 255; i++) strcat(many, "          - {type: sphere, radius: 1}\n");
    scene_is_refused(many, "more than 256 shapes and children");
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

static char note[1024];

static void remember_note(void *context, const char *text)
{
    (void)context;
    snprintf(note, sizeof note, "%s", text);
}

/* One file in all three ways: its hull, its triangles, two boxes. */
static void a_mesh_becomes_what_the_scene_says(void **state)
{
    (void)state;
    fixture f;
    scene s;
    fixture_begin(&f);
    f.report.note = remember_note;
    note[0] = '\0';
    bool parsed = fixture_scene(&f,
        "bodies:\n  - name: a\n    shapes:\n"
        "      - {type: mesh, mesh: " LOADERS_DATA "/angle.obj, as: hull}\n"
        "      - {type: mesh, mesh: " LOADERS_DATA "/angle.obj}\n"
        "      - {type: mesh, mesh: " LOADERS_DATA "/angle.obj, as: decompose, pieces: 2}\n"
        "      - {type: sphere, radius: 1}\n",
        &s);
    load_body *b = s.bodies.at;
    if (!parsed || !load_body_meshes(&f.pool, b, &f.report)) fail_msg("%s", f.report.error);
    assert_int_equal(b->shape_count, 5);
    assert_true(b->shapes[0].shape.type == COLLIDED_HULL && b->shapes[0].shape.deviation == 0);
    assert_true(b->shapes[1].shape.type == COLLIDED_MESH && b->shapes[1].triangles.count == 20);
    for (int i = 2; i < 4; i++) {
        const collided_shape *hull = &b->shapes[i].shape;
        assert_true(hull->type == COLLIDED_HULL && hull->deviation > 0 && hull->deviation < 0.01);
        assert_true(hull->radius > 0 && hull->radius < 1e-11);
        assert_true(b->shapes[i].points.count >= 8);
    }
    assert_int_equal(b->shapes[4].shape.type, COLLIDED_SPHERE);
    assert_non_null(strstr(note, "angle.obj: 20 triangles became 2 hulls, at most "));
    fixture_end(&f);
}

static void the_words_of_meshes(void **state)
{
    (void)state;
    load_meshes m;
    assert_true(load_meshes_parse("hull", &m) && m.as == LOAD_MESH_HULL);
    assert_true(load_meshes_parse("solid", &m) && m.as == LOAD_MESH_SOLID);
    assert_true(load_meshes_parse("decompose", &m) && m.as == LOAD_MESH_DECOMPOSE && m.pieces == 0);
    assert_true(load_meshes_parse("decompose:128", &m) && m.pieces == 128);
    static const char *const wrong[] = {"", "Hull", "decompose:", "decompose:0", "decompose:129", "decompose:1x",
        "decompose:-1", "decompose:1000", "decomposed"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) assert_false(load_meshes_parse(wrong[i], &m));
}

/* ---- links and apart of robots ---- */

#define ARM                                                                                                            \
    "<robot name='r'><link name='a'><collision><geometry><box size='1 1 1'/></geometry></collision></link>"            \
    "<link name='b'><collision><geometry><sphere radius='1'/></geometry></collision></link><link name='bare'/>"        \
    "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>"                                         \
    "<joint name='k' type='fixed'><parent link='b'/><child link='bare'/></joint></robot>"

static bool bodies_of(fixture *f, const char *rest, load_bodies *out)
{
    scene s;
    robot r = {0};
    char text[1024];
    fixture_begin(f);
    snprintf(text, sizeof text, "robots:\n  - urdf: a.urdf\n    prefix: x_\n%s", rest);
    if (!fixture_scene(f, text, &s)) fail_msg("%s", f->report.error);
    r.source = s.robots[0].source;
    assert_true(fixture_urdf(f, ARM, &r.model));
    double values[2] = {0, 0};
    return robot_bodies(&r, collided_pose_identity(), values, COLLIDED_MOVING, &f->pool, out, &f->report);
}

static void links_may_have_other_shapes(void **state)
{
    (void)state;
    fixture f;
    load_bodies bodies;
    if (!bodies_of(&f,
            "    links:\n      - {name: b, shapes: [{type: capsule, radius: 0.2, length: 1, deviation: 0.003}, {type: "
            "mesh, mesh: " LOADERS_DATA "/tetrahedron.stl}]}\n"
            "    apart: [{link1: b, link2: a, reason: because}]\n",
            &bodies))
        fail_msg("%s", f.report.error);
    assert_int_equal(bodies.count, 2);
    const load_body *a = &bodies.at[0], *b = &bodies.at[1];
    assert_true(a->shape_count == 1 && a->shapes[0].shape.type == COLLIDED_BOX);
    assert_true(b->shape_count == 2 && b->shapes[0].shape.type == COLLIDED_CAPSULE);
    assert_true(b->shapes[0].shape.deviation == 0.003 && b->shapes[0].shape.half[2] == 0.5);
    assert_true(b->shapes[1].shape.type == COLLIDED_MESH && b->shapes[1].triangles.count == 4);
    assert_true(a->rule_count == 2 && a->rules[0].allow); /* before that of the joint */
    assert_string_equal(a->rules[0].pattern, "x_b");
    assert_string_equal(a->rules[0].reason, "because");
    assert_string_equal(b->rules[0].pattern, "x_a");
    fixture_end(&f);
}

static void links_that_are_not_there_are_refused(void **state)
{
    (void)state;
    static const char *const cases[][2] = {
        {"    links: [{name: c, shapes: [{type: sphere, radius: 1}]}]\n", "the link 'c' is not in"},
        {"    links: [{name: bare, shapes: [{type: sphere, radius: 1}]}]\n", "'bare' has no collision geometry"},
        {"    links: [{name: a, shapes: [{type: sphere, radius: 1}]}, {name: a, shapes: [{type: sphere, radius: "
         "1}]}]\n",
            "'a' are given twice"},
        {"    apart: [{link1: a, link2: c}]\n", "the link 'c' is not in"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fixture f;
        load_bodies bodies;
        assert_false(bodies_of(&f, cases[i][0], &bodies));
        if (!strstr(f.report.error, cases[i][1])) fail_msg("'%s' lacks: %s", f.report.error, cases[i][1]);
        fixture_end(&f);
    }
    scene_is_refused("robots:\n  - {urdf: a, links: [{name: b, shapes: [{type: sphere, radius: -1}]}]}\n",
        "link 'b', shape 1: radius is -1");
    scene_is_refused("robots:\n  - {urdf: a, links: [{name: b, shapes: []}]}\n", "test.yaml");
    scene_is_refused("robots:\n  - {urdf: a, apart: [{link1: b}]}\n", "test.yaml");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bodies_are_read_as_they_are_written),
        cmocka_unit_test(the_example_of_the_page_is_read),
        cmocka_unit_test(every_shape_is_read),
        cmocka_unit_test(a_height_field_is_read_from_its_file),
        cmocka_unit_test(height_fields_that_cannot_be_are_refused),
        cmocka_unit_test(compounds_are_read_with_their_children),
        cmocka_unit_test(compounds_that_cannot_be_are_refused),
        cmocka_unit_test(robots_are_read_with_paths_beside_the_scene),
        cmocka_unit_test(links_may_have_other_shapes),
        cmocka_unit_test(links_that_are_not_there_are_refused),
        cmocka_unit_test(what_does_not_follow_the_schema_is_refused_with_its_line),
        cmocka_unit_test(wrong_keys_are_told_in_their_own_line),
        cmocka_unit_test(motions_that_cannot_be_are_refused),
        cmocka_unit_test(shapes_that_cannot_be_are_refused),
        cmocka_unit_test(poses_names_and_joints_that_cannot_be_are_refused),
        cmocka_unit_test(a_mesh_becomes_what_the_scene_says),
        cmocka_unit_test(the_words_of_meshes),
        cmocka_unit_test(damaged_files_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
