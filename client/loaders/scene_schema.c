/* scene_schema: the keys of a scene as a table for libcyaml. Its log is where it says what is wrong and in which line:
 * both are taken from there. Aliases are refused: they would let a small file stand for an endless one. */
#include "scene_schema.h"

#include "body.h"

#include <cyaml/cyaml.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    BODIES_MAX = 16384,
    POINTS_MAX = 65535,
    SHAPES_MAX = 256,
    RULES_MAX = 1024,
    SMALL_MAX = 4096,
    APART_MAX = 65536
};

#define OPTIONAL (CYAML_FLAG_POINTER | CYAML_FLAG_OPTIONAL)
#define TEXT(key, type, member) CYAML_FIELD_STRING_PTR(key, CYAML_FLAG_POINTER, type, member, 0, SMALL_MAX)
#define OPTIONAL_TEXT(key, type, member) CYAML_FIELD_STRING_PTR(key, OPTIONAL, type, member, 0, SMALL_MAX)
#define NUMBERS(key, type, member, count) CYAML_FIELD_SEQUENCE_FIXED(key, OPTIONAL, type, member, &number, count)
#define LIST(key, type, member, entry, most) CYAML_FIELD_SEQUENCE(key, OPTIONAL, type, member, entry, 0, most)

static const cyaml_schema_value_t number = {CYAML_VALUE_FLOAT(CYAML_FLAG_DEFAULT, double)};

static const cyaml_strval_t types[] = {
    {"sphere", COLLIDED_SPHERE},
    {"capsule", COLLIDED_CAPSULE},
    {"box", COLLIDED_BOX},
    {"cylinder", COLLIDED_CYLINDER},
    {"cone", COLLIDED_CONE},
    {"ellipsoid", COLLIDED_ELLIPSOID},
    {"halfspace", COLLIDED_HALFSPACE},
    {"hull", COLLIDED_HULL},
    {"mesh", COLLIDED_MESH},
    {"height_field", COLLIDED_HEIGHT_FIELD},
    {"compound", COLLIDED_COMPOUND},
};
static const cyaml_strval_t becomings[] = {
    {"hull", LOAD_MESH_HULL}, {"solid", LOAD_MESH_SOLID}, {"decompose", LOAD_MESH_DECOMPOSE}};
static const cyaml_strval_t motions[] = {{"moving", COLLIDED_MOVING}, {"fixed", COLLIDED_FIXED}};

static const cyaml_strval_t ccds[] = {
    {"off", COLLIDED_CCD_OFF}, {"linear", COLLIDED_CCD_LINEAR}, {"full", COLLIDED_CCD_FULL}};

/* What bodies and robots say of their motion. */
#define MOTION_FIELDS(type)                                                                                            \
    CYAML_FIELD_ENUM("motion", CYAML_FLAG_OPTIONAL | CYAML_FLAG_STRICT, type, motion, motions, 2),                     \
        CYAML_FIELD_ENUM("ccd", CYAML_FLAG_OPTIONAL | CYAML_FLAG_STRICT, type, ccd, ccds, CYAML_ARRAY_LEN(ccds)),      \
        CYAML_FIELD_FLOAT_PTR("acceleration", OPTIONAL, type, acceleration),                                           \
        CYAML_FIELD_FLOAT_PTR("angular_acceleration", OPTIONAL, type, angular_acceleration)

static const cyaml_schema_field_t pose_fields[] = {
    NUMBERS("position", yaml_pose, position, 3),
    NUMBERS("rpy", yaml_pose, rpy, 3),
    NUMBERS("orientation", yaml_pose, orientation, 4),
    CYAML_FIELD_END,
};

static const cyaml_schema_value_t point = {CYAML_VALUE_SEQUENCE_FIXED(CYAML_FLAG_DEFAULT, double, &number, 3)};
/* clang-format off */
#define SHAPE_FIELDS \
    CYAML_FIELD_ENUM("type", CYAML_FLAG_STRICT, yaml_shape, type, types, CYAML_ARRAY_LEN(types)), \
    NUMBERS("size", yaml_shape, size, 3), \
    NUMBERS("semi_axes", yaml_shape, semi_axes, 3), \
    CYAML_FIELD_FLOAT_PTR("radius", OPTIONAL, yaml_shape, radius), \
    CYAML_FIELD_FLOAT_PTR("length", OPTIONAL, yaml_shape, length), \
    CYAML_FIELD_FLOAT_PTR("height", OPTIONAL, yaml_shape, height), \
    CYAML_FIELD_FLOAT_PTR("rounding", OPTIONAL, yaml_shape, rounding), \
    NUMBERS("scale", yaml_shape, scale, 3), \
    LIST("points", yaml_shape, points, &point, POINTS_MAX), \
    OPTIONAL_TEXT("mesh", yaml_shape, mesh), \
    OPTIONAL_TEXT("heights", yaml_shape, heights), \
    NUMBERS("spacing", yaml_shape, spacing, 2), \
    CYAML_FIELD_FLOAT_PTR("base", OPTIONAL, yaml_shape, base), \
    NUMBERS("range", yaml_shape, range, 2), \
    CYAML_FIELD_ENUM_PTR("as", OPTIONAL | CYAML_FLAG_STRICT, yaml_shape, as, becomings, CYAML_ARRAY_LEN(becomings)), \
    CYAML_FIELD_UINT_PTR("pieces", OPTIONAL, yaml_shape, pieces), \
    CYAML_FIELD_FLOAT_PTR("deviation", OPTIONAL, yaml_shape, deviation), \
    CYAML_FIELD_MAPPING_PTR("pose", OPTIONAL, yaml_shape, pose, pose_fields)
/* clang-format on */
/* A child has none of its own. */
static const cyaml_schema_field_t child_fields[] = {SHAPE_FIELDS, CYAML_FIELD_END};
static const cyaml_schema_value_t child = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_shape, child_fields)};
static const cyaml_schema_field_t shape_fields[] = {
    SHAPE_FIELDS, LIST("children", yaml_shape, children, &child, SHAPES_MAX - 1), CYAML_FIELD_END};
static const cyaml_schema_value_t shape = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_shape, shape_fields)};

static const cyaml_schema_field_t rule_fields[] = {
    TEXT("pattern", yaml_rule, pattern),
    CYAML_FIELD_BOOL("allow", CYAML_FLAG_STRICT, yaml_rule, allow),
    OPTIONAL_TEXT("reason", yaml_rule, reason),
    CYAML_FIELD_FLOAT_PTR("padding", OPTIONAL, yaml_rule, padding),
    CYAML_FIELD_FLOAT_PTR("margin", OPTIONAL, yaml_rule, margin),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t rule = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_rule, rule_fields)};

static const cyaml_schema_field_t body_fields[] = {
    TEXT("name", yaml_body, name),
    OPTIONAL_TEXT("group", yaml_body, group),
    MOTION_FIELDS(yaml_body),
    CYAML_FIELD_UINT_PTR("category", OPTIONAL, yaml_body, category),
    CYAML_FIELD_UINT_PTR("mask", OPTIONAL, yaml_body, mask),
    CYAML_FIELD_BOOL("one_way", CYAML_FLAG_OPTIONAL | CYAML_FLAG_STRICT, yaml_body, one_way),
    CYAML_FIELD_MAPPING_PTR("pose", OPTIONAL, yaml_body, pose, pose_fields),
    CYAML_FIELD_SEQUENCE("shapes", CYAML_FLAG_POINTER, yaml_body, shapes, &shape, 1, SHAPES_MAX),
    LIST("rules", yaml_body, rules, &rule, RULES_MAX),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t body = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_body, body_fields)};

static const cyaml_schema_field_t package_fields[] = {
    TEXT("name", yaml_package, name),
    TEXT("path", yaml_package, path),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t package = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_package, package_fields)};

static const cyaml_schema_field_t joint_fields[] = {
    TEXT("name", yaml_joint, name),
    CYAML_FIELD_FLOAT("value", CYAML_FLAG_DEFAULT, yaml_joint, value),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t joint = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_joint, joint_fields)};

static const cyaml_schema_field_t link_fields[] = {
    TEXT("name", yaml_link, name),
    CYAML_FIELD_SEQUENCE("shapes", CYAML_FLAG_POINTER, yaml_link, shapes, &shape, 1, SHAPES_MAX),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t robot_link = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_link, link_fields)};

static const cyaml_schema_field_t apart_fields[] = {
    TEXT("link1", yaml_apart, link1),
    TEXT("link2", yaml_apart, link2),
    OPTIONAL_TEXT("reason", yaml_apart, reason),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t apart = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_apart, apart_fields)};

static const cyaml_schema_field_t robot_fields[] = {
    TEXT("urdf", yaml_robot, urdf),
    OPTIONAL_TEXT("srdf", yaml_robot, srdf),
    OPTIONAL_TEXT("prefix", yaml_robot, prefix),
    OPTIONAL_TEXT("state", yaml_robot, state),
    OPTIONAL_TEXT("meshes", yaml_robot, meshes),
    MOTION_FIELDS(yaml_robot),
    CYAML_FIELD_MAPPING_PTR("pose", OPTIONAL, yaml_robot, pose, pose_fields),
    LIST("packages", yaml_robot, packages, &package, SMALL_MAX),
    LIST("joints", yaml_robot, joints, &joint, SMALL_MAX),
    LIST("links", yaml_robot, links, &robot_link, SMALL_MAX),
    LIST("apart", yaml_robot, apart, &apart, APART_MAX),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t robot = {CYAML_VALUE_MAPPING(CYAML_FLAG_DEFAULT, yaml_robot, robot_fields)};

static const cyaml_schema_field_t scene_fields[] = {
    LIST("bodies", yaml_scene, bodies, &body, BODIES_MAX),
    LIST("robots", yaml_scene, robots, &robot, SMALL_MAX),
    CYAML_FIELD_END,
};
static const cyaml_schema_value_t top = {CYAML_VALUE_MAPPING(CYAML_FLAG_POINTER, yaml_scene, scene_fields)};

/* libcyaml logs first what is wrong, then the way to it, innermost first, each with "(line: L, column: C)". In a
 * mapping that is where its last good value began, or its first key. */
typedef struct complaint {
    char what[256];
    int line, column; /* from 1; 0 = not said */
    int entry_line;   /* of the innermost entry of a list on the way */
} complaint;

static int number_after(const char *text, const char *word)
{
    const char *found = strstr(text, word);
    return found ? (int)strtol(found + strlen(word), NULL, 10) : 0;
}

static void listen(cyaml_log_t level, void *context, const char *format, va_list arguments)
{
    static const char prefix[] = "Load: ";
    complaint *c = context;
    char text[512];
    (void)level;
    vsnprintf(text, sizeof text, format, arguments);
    text[strcspn(text, "\n")] = '\0';
    int line = number_after(text, "line: ");
    if (c->line == 0) c->line = line, c->column = number_after(text, "column: ");
    if (c->entry_line == 0 && strstr(text, "in sequence entry")) c->entry_line = line;
    const char *what = strncmp(text, prefix, sizeof prefix - 1) == 0 ? text + sizeof prefix - 1 : text;
    bool of_the_way = *what == ' ' || strncmp(what, "Backtrace", 9) == 0;
    if (!c->what[0] && !of_the_way) snprintf(c->what, sizeof c->what, "%.255s", what);
}

/* Does the key stand in this line of text, from that column on? */
static bool has_key(const char *text, size_t length, size_t column, const char *key)
{
    size_t n = strlen(key);
    for (size_t i = column; i + n < length; i++) {
        size_t after = i + n;
        while (after < length && text[after] == ' ') after++;
        bool begins = i == 0 || strchr(" -{,\"'", text[i - 1]);
        if (begins && strncmp(text + i, key, n) == 0 && after < length && strchr(":\"'", text[after])) return true;
    }
    return false;
}

/* A key that is wrong stands behind the last good value: in its line (unless that is a list of lines), or in the next
 * one that is indented no more. */
static int line_of_key(const complaint *c, const char *key, const char *data, size_t size)
{
    const char *text = data, *end = data + size;
    for (int line = 1; text < end; line++) {
        const char *stop = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((stop ? stop : end) - text), indent = 0;
        while (indent < length && strchr(" -", text[indent])) indent++;
        bool same = line == c->line && (size_t)c->column <= length && text[c->column - 1] != '-',
             later = line > c->line && indent < (size_t)c->column;
        size_t from = same ? (size_t)c->column - 1 : indent;
        if ((same || later) && from < length && has_key(text, length, from, key)) return line;
        text += length + 1;
    }
    return c->line;
}

static int line_of(const complaint *c, const char *data, size_t size)
{
    static const char *const of_keys[] = {"Unexpected key: ", "Mapping field already seen: "};
    if (c->line == 0 || c->column == 0) return c->line;
    if (strncmp(c->what, "Missing required", 16) == 0 && c->entry_line > 0) return c->entry_line;
    for (size_t i = 0; i < sizeof of_keys / sizeof *of_keys; i++) {
        size_t n = strlen(of_keys[i]);
        if (strncmp(c->what, of_keys[i], n) == 0) return line_of_key(c, c->what + n, data, size);
    }
    return c->line;
}

static cyaml_config_t config_with(complaint *c)
{
    return (cyaml_config_t){.log_fn = c ? listen : NULL,
        .log_ctx = c,
        .mem_fn = cyaml_mem,
        .log_level = CYAML_LOG_ERROR,
        .flags = CYAML_CFG_NO_ALIAS};
}

yaml_scene *yaml_scene_read(const char *data, size_t size, const char *file, load_report *r)
{
    complaint c = {0};
    cyaml_config_t config = config_with(&c);
    yaml_scene *scene = NULL;
    cyaml_err_t status = cyaml_load_data((const uint8_t *)data, size, &config, &top, (cyaml_data_t **)&scene, NULL);
    if (status == CYAML_OK && scene) return scene;
    const char *what = c.what[0] ? c.what : status == CYAML_OK ? "the file is empty" : cyaml_strerror(status);
    int line = line_of(&c, data, size);
    if (line > 0)
        load_fail(r, "%s:%d: %s", file, line, what);
    else
        load_fail(r, "%s: %s", file, what);
    return NULL;
}

void yaml_scene_free(yaml_scene *scene)
{
    cyaml_config_t config = config_with(NULL);
    cyaml_free(&config, &top, scene, 0);
}
