/* scene: from a scene as it was written to bodies and robots: units halved, keys checked against the type, rotations
 * made unit. One thread a pool. */
#include "scene.h"

#include "decompose/decompose.h"
#include "rigid.h"
#include "scene_schema.h"
#include "text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    pool *pool;
    load_report *report;
    const char *file, *folder;
    char where[256]; /* "cell.yaml: body 'table', shape 2" */
} reader;

static bool finite_all(const double *numbers, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(numbers[i])) return false;
    return true;
}

static bool take_pose(const reader *in, const yaml_pose *from, collided_pose *out)
{
    *out = rigid_identity();
    if (!from) return true;
    if (from->rpy && from->orientation)
        return load_fail(in->report, "%s: its pose has rpy and orientation: give one of them", in->where);
    if ((from->position && !finite_all(from->position, 3)) || (from->rpy && !finite_all(from->rpy, 3)))
        return load_fail(in->report, "%s: its pose has a number that is not finite", in->where);
    if (from->position) memcpy(out->position, from->position, sizeof out->position);
    if (from->rpy) rigid_from_rpy(from->rpy, out->orientation);
    if (!from->orientation) return true;
    const double *q = from->orientation;
    double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (!(fabs(norm - 1) < 1e-3))
        return load_fail(in->report, "%s: its orientation [w, x, y, z] has the norm %g, not 1", in->where, norm);
    for (int i = 0; i < 4; i++) out->orientation[i] = q[i] / norm;
    return true;
}

static bool take_name(const reader *in, const char *what, const char *name, const char **out)
{
    const char *fault = text_name_fault(name);
    if (fault) return load_fail(in->report, "%s: the %s '%s' %s", in->where, what, name, fault);
    *out = pool_copy(in->pool, name);
    return true;
}

/* ---- shapes ---- */

enum { SIZE = 1, SEMI_AXES = 2, RADIUS = 4, LENGTH = 8, HEIGHT = 16, POINTS = 32, MESH = 64, SCALE = 128 };
enum { HEIGHTS = 256, SPACING = 512, BASE = 1024, RANGE = 2048 }; /* of height fields */
enum { CHILDREN = 4096 };                                         /* of compounds */
enum { AS = 8192, PIECES = 16384, DEVIATION = 32768 };            /* of meshes */
static const struct {
    unsigned bit;
    const char *key;
} keys[] = {{SIZE, "size"}, {SEMI_AXES, "semi_axes"}, {RADIUS, "radius"}, {LENGTH, "length"}, {HEIGHT, "height"},
    {POINTS, "points"}, {MESH, "mesh"}, {SCALE, "scale"}, {HEIGHTS, "heights"}, {SPACING, "spacing"}, {BASE, "base"},
    {RANGE, "range"}, {CHILDREN, "children"}, {AS, "as"}, {PIECES, "pieces"}, {DEVIATION, "deviation"}};

static unsigned keys_given(const yaml_shape *s)
{
    return (s->size ? SIZE : 0) | (s->semi_axes ? SEMI_AXES : 0) | (s->radius ? RADIUS : 0) | (s->length ? LENGTH : 0) |
           (s->height ? HEIGHT : 0) | (s->points ? POINTS : 0) | (s->mesh ? MESH : 0) | (s->scale ? SCALE : 0) |
           (s->heights ? HEIGHTS : 0) | (s->spacing ? SPACING : 0) | (s->base ? BASE : 0) | (s->range ? RANGE : 0) |
           (s->children ? CHILDREN : 0) | (s->as ? AS : 0) | (s->pieces ? PIECES : 0) | (s->deviation ? DEVIATION : 0);
}

/* A hull takes its points from either of two keys; pictures need a range that text must not have (heights.h tells). */
static unsigned keys_wanted(const yaml_shape *s)
{
    static const unsigned wanted[] = {
        [COLLIDED_SPHERE] = RADIUS,
        [COLLIDED_CAPSULE] = RADIUS | LENGTH,
        [COLLIDED_BOX] = SIZE,
        [COLLIDED_CYLINDER] = RADIUS | HEIGHT,
        [COLLIDED_CONE] = RADIUS | HEIGHT,
        [COLLIDED_ELLIPSOID] = SEMI_AXES,
        [COLLIDED_HALFSPACE] = 0,
        [COLLIDED_HULL] = POINTS,
        [COLLIDED_MESH] = MESH,
        [COLLIDED_HEIGHT_FIELD] = HEIGHTS | SPACING | BASE,
        [COLLIDED_COMPOUND] = CHILDREN,
    };
    unsigned inside = s->deviation && s->type != COLLIDED_MESH ? DEVIATION : 0;
    if (s->type == COLLIDED_HEIGHT_FIELD && s->range) return wanted[s->type] | RANGE | inside;
    if (s->mesh && s->type == COLLIDED_HULL) return MESH | (s->scale ? SCALE : 0) | inside;
    bool decomposed = s->as && *s->as == LOAD_MESH_DECOMPOSE;
    unsigned how = SCALE | AS | (decomposed ? PIECES | DEVIATION : 0);
    if (s->mesh && s->type == COLLIDED_MESH) return MESH | (keys_given(s) & how);
    return wanted[s->type] | inside;
}

static bool check_keys(const reader *in, const yaml_shape *s)
{
    unsigned given = keys_given(s), wanted = keys_wanted(s);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        if ((wanted & ~given) & keys[i].bit)
            return load_fail(in->report, "%s: it needs the key '%s'%s", in->where, keys[i].key,
                keys[i].bit == POINTS ? " or 'mesh'" : "");
        if ((given & ~wanted) & keys[i].bit)
            return load_fail(in->report, "%s: the key '%s' does not belong to its type", in->where, keys[i].key);
    }
    return true;
}

static bool check_sizes(const reader *in, const char *key, const double *sizes, int count)
{
    for (int i = 0; sizes && i < count; i++)
        if (!(sizes[i] >= 0) || isinf(sizes[i]))
            return load_fail(in->report, "%s: %s is %g: must be finite and not negative", in->where, key, sizes[i]);
    return true;
}

static bool check_numbers(const reader *in, const yaml_shape *s)
{
    for (unsigned i = 0; i < s->points_count; i++)
        if (!finite_all(s->points[i].at, 3))
            return load_fail(in->report, "%s: point %u is not finite", in->where, i + 1);
    if (s->scale && !finite_all(s->scale, 3)) return load_fail(in->report, "%s: scale is not finite", in->where);
    return check_sizes(in, "size", s->size, 3) && check_sizes(in, "semi_axes", s->semi_axes, 3) &&
           check_sizes(in, "radius", s->radius, 1) && check_sizes(in, "length", s->length, 1) &&
           check_sizes(in, "height", s->height, 1) && check_sizes(in, "rounding", s->rounding, 1) &&
           (s->type == COLLIDED_MESH || check_sizes(in, "deviation", s->deviation, 1));
}

static void fill_sizes(const yaml_shape *s, collided_shape *out)
{
    switch (out->type) {
    case COLLIDED_SPHERE:
        out->radius = *s->radius;
        break;
    case COLLIDED_CAPSULE:
        out->radius = *s->radius;
        out->half[2] = *s->length / 2;
        break;
    case COLLIDED_BOX:
        for (int i = 0; i < 3; i++) out->half[i] = s->size[i] / 2;
        break;
    case COLLIDED_CYLINDER:
    case COLLIDED_CONE:
        out->half[0] = out->half[1] = *s->radius;
        out->half[2] = *s->height / 2;
        break;
    case COLLIDED_ELLIPSOID:
        memcpy(out->half, s->semi_axes, sizeof out->half);
        break;
    case COLLIDED_HALFSPACE:
    case COLLIDED_HULL:
    case COLLIDED_MESH:
    case COLLIDED_HEIGHT_FIELD:
    case COLLIDED_COMPOUND:
    case COLLIDED_SOFT: /* not in scenes */
        break;
    }
    if (s->rounding) out->radius += *s->rounding;
}

static bool take_heights(const reader *in, const yaml_shape *from, load_heights *out)
{
    out->path = text_beside(in->pool, in->folder, from->heights);
    for (int i = 0; i < 2; i++) out->spacing[i] = from->spacing[i];
    out->base = *from->base;
    for (int i = 0; i < 2; i++)
        if (!(out->spacing[i] > 0) || isinf(out->spacing[i]))
            return load_fail(in->report, "%s: spacing is %g: must be finite and above 0", in->where, out->spacing[i]);
    if (!(out->base > 0) || isinf(out->base))
        return load_fail(in->report, "%s: base is %g: must be finite and above 0", in->where, out->base);
    if (!from->range) return true;
    if (!finite_all(from->range, 2)) return load_fail(in->report, "%s: range is not finite", in->where);
    double *range = pool_alloc(in->pool, 2, sizeof *range);
    memcpy(range, from->range, 2 * sizeof *range);
    out->range = range;
    return true;
}

/* A mesh is a solid unless it says otherwise. */
static bool take_meshes(const reader *in, const yaml_shape *from, load_shape *out)
{
    load_meshes meshes = {.as = from->type == COLLIDED_HULL ? LOAD_MESH_HULL : LOAD_MESH_SOLID};
    if (from->as) meshes.as = (load_mesh_as)*from->as;
    if (from->pieces && (*from->pieces < 1 || *from->pieces > DECOMPOSE_PIECES_MAX))
        return load_fail(in->report, "%s: pieces must be from 1 to %d", in->where, DECOMPOSE_PIECES_MAX);
    if (from->deviation && !(*from->deviation > 0 && isfinite(*from->deviation)))
        return load_fail(in->report, "%s: deviation is %g: must be finite and positive", in->where, *from->deviation);
    if (from->pieces) meshes.pieces = (size_t)*from->pieces;
    if (from->deviation) meshes.deviation_m = *from->deviation;
    load_shape_becomes(out, &meshes);
    return true;
}

static bool take_shape(const reader *in, const yaml_shape *from, load_shape *out)
{
    if (!check_keys(in, from) || !check_numbers(in, from)) return false;
    *out = (load_shape){.shape.type = (collided_shape_type)from->type, .scale = {1, 1, 1}};
    fill_sizes(from, &out->shape);
    if (from->deviation && from->type != COLLIDED_MESH) out->shape.deviation = *from->deviation;
    if (from->mesh && !take_meshes(in, from, out)) return false;
    if (from->mesh) out->mesh = text_beside(in->pool, in->folder, from->mesh);
    if (from->scale) memcpy(out->scale, from->scale, sizeof out->scale);
    if (from->points) {
        double *points = pool_alloc(in->pool, from->points_count, 3 * sizeof *points);
        for (unsigned i = 0; i < from->points_count; i++)
            memcpy(points + 3 * i, from->points[i].at, 3 * sizeof *points);
        out->points = (mesh_points){points, from->points_count};
    }
    if (from->heights && !take_heights(in, from, &out->heights)) return false;
    return take_pose(in, from->pose, &out->shape.pose);
}

static bool can_be_child(int type)
{
    return type != COLLIDED_HALFSPACE && type != COLLIDED_MESH && type != COLLIDED_HEIGHT_FIELD &&
           type != COLLIDED_COMPOUND;
}

/* in->where names the compound, and then each child. */
static bool take_children(reader *in, const yaml_shape *from, load_shape *out)
{
    size_t length = strlen(in->where);
    if (from->type == COLLIDED_COMPOUND && from->children_count == 0)
        return load_fail(in->report, "%s: a compound needs a child", in->where);
    out->children = pool_alloc(in->pool, from->children_count, sizeof *out->children);
    for (unsigned i = 0; i < from->children_count; i++) {
        snprintf(in->where + length, sizeof in->where - length, ", child %u", i + 1);
        if (!can_be_child(from->children[i].type))
            return load_fail(in->report, "%s: a half-space, mesh, height field or compound cannot be one", in->where);
        if (!take_shape(in, &from->children[i], &out->children[out->child_count++])) return false;
    }
    return true;
}

/* ---- bodies ---- */

static bool take_rate(const reader *in, const char *key, const double *from, double *out)
{
    *out = from ? *from : 0;
    return (*out >= 0 && isfinite(*out)) ||
           load_fail(in->report, "%s: %s is %g: must be finite and not negative", in->where, key, *out);
}

static bool take_rules(const reader *in, const yaml_body *from, load_body *out)
{
    out->rules = pool_alloc(in->pool, from->rules_count, sizeof *out->rules);
    for (; out->rule_count < from->rules_count; out->rule_count++) {
        const yaml_rule *rule = &from->rules[out->rule_count];
        double padding = rule->padding ? *rule->padding : 0, margin = rule->margin ? *rule->margin : 0;
        if (!*rule->pattern) return load_fail(in->report, "%s: a rule's pattern is empty", in->where);
        if (!isfinite(padding) || !(margin >= 0 && isfinite(margin)))
            return load_fail(in->report, "%s: a rule's padding must be finite, its margin at least 0", in->where);
        out->rules[out->rule_count] = (collided_rule){.pattern = pool_copy(in->pool, rule->pattern),
            .allow = rule->allow,
            .reason = pool_copy(in->pool, rule->reason ? rule->reason : ""),
            .padding_m = padding,
            .margin_m = margin};
    }
    return true;
}

/* in->where says whose. */
static bool take_yaml_shapes(reader *in, const yaml_shape *from, unsigned shapes, load_shape **out, size_t *out_count)
{
    char of[sizeof in->where];
    size_t count = 0;
    memcpy(of, in->where, sizeof of);
    *out = pool_alloc(in->pool, shapes, sizeof **out);
    for (unsigned i = 0; i < shapes; i++) {
        snprintf(in->where, sizeof in->where, "%.200s, shape %u", of, i + 1);
        load_shape *shape = &(*out)[(*out_count)++];
        if (!take_shape(in, &from[i], shape) || !take_children(in, &from[i], shape)) return false;
        count += 1 + shape->child_count;
        if (count > LOAD_SHAPES_MAX)
            return load_fail(
                in->report, "%s: the body has more than %d shapes and children", in->where, LOAD_SHAPES_MAX);
    }
    return true;
}

static bool take_body(reader *in, const yaml_body *from, load_body *out)
{
    snprintf(in->where, sizeof in->where, "%s: body '%.127s'", in->file, from->name);
    out->motion = (collided_motion)from->motion;
    out->group = "";
    out->category = from->category ? *from->category : 1;
    out->mask = from->mask ? *from->mask : UINT64_MAX;
    out->one_way = from->one_way;
    out->ccd = (collided_ccd)from->ccd;
    if (!take_rate(in, "acceleration", from->acceleration, &out->acceleration_m_s2) ||
        !take_rate(in, "angular_acceleration", from->angular_acceleration, &out->angular_acceleration_rad_s2))
        return false;
    if (!take_name(in, "name", from->name, &out->name) || !take_pose(in, from->pose, &out->pose) ||
        !take_rules(in, from, out))
        return false;
    if (from->group && !take_name(in, "group", from->group, &out->group)) return false;
    return take_yaml_shapes(in, from->shapes, from->shapes_count, &out->shapes, &out->shape_count);
}

/* ---- robots ---- */

static bool take_joints(const reader *in, const yaml_robot *from, scene_robot *out)
{
    out->joints = pool_alloc(in->pool, from->joints_count, sizeof *out->joints);
    out->values = pool_alloc(in->pool, from->joints_count, sizeof *out->values);
    for (; out->joint_count < from->joints_count; out->joint_count++) {
        const yaml_joint *j = &from->joints[out->joint_count];
        if (!isfinite(j->value))
            return load_fail(in->report, "%s: the value of joint '%s' is not finite", in->where, j->name);
        out->joints[out->joint_count] = pool_copy(in->pool, j->name);
        out->values[out->joint_count] = j->value;
    }
    return true;
}

/* Shapes in place of the URDF's, and pairs of links that are not checked. Whether there are such links is seen when the
 * URDF is read. */
static bool take_links(reader *in, const yaml_robot *from, robot_source *out)
{
    robot_link_shapes *links = pool_alloc(in->pool, from->links_count, sizeof *links);
    robot_apart *apart = pool_alloc(in->pool, from->apart_count, sizeof *apart);
    out->links = links;
    out->apart = apart;
    for (unsigned i = 0; i < from->apart_count; i++) {
        const yaml_apart *a = &from->apart[i];
        apart[out->apart_count++] = (robot_apart){pool_copy(in->pool, a->link1), pool_copy(in->pool, a->link2),
            pool_copy(in->pool, a->reason ? a->reason : "")};
    }
    for (unsigned i = 0; i < from->links_count; i++) {
        const yaml_link *l = &from->links[i];
        robot_link_shapes *to = &links[out->link_count++];
        to->link = pool_copy(in->pool, l->name);
        snprintf(in->where, sizeof in->where, "%s: link '%.127s'", in->file, l->name);
        if (!take_yaml_shapes(in, l->shapes, l->shapes_count, &to->shapes, &to->shape_count)) return false;
    }
    return true;
}

static bool take_robot(reader *in, const yaml_robot *from, scene_robot *out)
{
    snprintf(in->where, sizeof in->where, "%s: robot '%.127s'", in->file, from->urdf);
    load_package *packages = pool_alloc(in->pool, from->packages_count, sizeof *packages);
    for (unsigned i = 0; i < from->packages_count; i++)
        packages[i] = (load_package){
            pool_copy(in->pool, from->packages[i].name), text_beside(in->pool, in->folder, from->packages[i].path)};
    out->source = (robot_source){.urdf = text_beside(in->pool, in->folder, from->urdf),
        .srdf = from->srdf ? text_beside(in->pool, in->folder, from->srdf) : NULL,
        .prefix = pool_copy(in->pool, from->prefix),
        .packages = packages,
        .package_count = from->packages_count};
    if (from->meshes && !load_meshes_parse(from->meshes, &out->source.meshes))
        return load_fail(
            in->report, "%s: meshes '%s': must be " LOAD_MESHES_WORDS, in->where, from->meshes, DECOMPOSE_PIECES_MAX);
    out->state = pool_copy(in->pool, from->state);
    out->motion = (collided_motion)from->motion;
    out->ccd = (collided_ccd)from->ccd;
    return take_rate(in, "acceleration", from->acceleration, &out->acceleration_m_s2) &&
           take_rate(in, "angular_acceleration", from->angular_acceleration, &out->angular_acceleration_rad_s2) &&
           take_pose(in, from->pose, &out->pose) && take_joints(in, from, out) && take_links(in, from, &out->source);
}

/* ---- the whole ---- */

static int by_text(const void *left, const void *right)
{
    return strcmp(*(const char *const *)left, *(const char *const *)right);
}

static bool check_names(const reader *in, const load_bodies *bodies)
{
    const char **names = pool_alloc(in->pool, bodies->count, sizeof *names);
    for (size_t i = 0; i < bodies->count; i++) names[i] = bodies->at[i].name;
    qsort(names, bodies->count, sizeof *names, by_text);
    for (size_t i = 1; i < bodies->count; i++)
        if (strcmp(names[i - 1], names[i]) == 0)
            return load_fail(in->report, "%s: there are two bodies named '%s'", in->file, names[i]);
    return true;
}

static bool take_scene(reader *in, const yaml_scene *from, scene *out)
{
    out->bodies.at = pool_alloc(in->pool, from->bodies_count, sizeof *out->bodies.at);
    out->robots = pool_alloc(in->pool, from->robots_count, sizeof *out->robots);
    for (unsigned i = 0; i < from->bodies_count; i++)
        if (!take_body(in, &from->bodies[i], &out->bodies.at[out->bodies.count++])) return false;
    for (unsigned i = 0; i < from->robots_count; i++)
        if (!take_robot(in, &from->robots[i], &out->robots[out->robot_count++])) return false;
    return check_names(in, &out->bodies);
}

bool scene_parse(scene *out, pool *p, const char *data, size_t size, const char *file, load_report *r)
{
    *out = (scene){0};
    if (size > SCENE_SIZE_MAX)
        return load_fail(r, "%s: has %zu bytes, more than the %d allowed", file, size, SCENE_SIZE_MAX);
    yaml_scene *raw = yaml_scene_read(data, size, file, r);
    if (!raw) return false;
    reader in = {.pool = p, .report = r, .file = file, .folder = text_folder(p, file)};
    bool ok = take_scene(&in, raw, out);
    yaml_scene_free(raw);
    return ok;
}
