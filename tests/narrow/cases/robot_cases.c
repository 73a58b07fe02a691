/* robot_cases: a robot loaded by the client's loaders, its links as hulls, and as meshes where hulls touch that should
 * not, asked of the engine pair by pair. */
#include "robot_cases.h"

#include "case_json.h"
#include "geom/mesh.h"
#include "loaders/body.h"
#include "loaders/robot.h"

#include <fnmatch.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The published distances are rounded to 1e-9 m and good to 1e-7 m. */
#define ROBOT_TOLERANCE 1e-7

typedef struct link_part { /* one shape of one link */
    const load_body *body;
    const load_shape *from;
    subject subject; /* by its hull */
    mesh *mesh;      /* owned; NULL until it is asked for */
} link_part;

typedef struct cell { /* a posed robot */
    pool pool;
    robot robot;
    load_bodies bodies;
    link_part *parts;
    size_t part_count;
} cell;

typedef struct robot_pair {
    const char *a, *b;
    link_part *parts[2]; /* of a and b; NULL: not a link */
    narrow_result result;
} robot_pair;

bool robot_query(const char *query)
{
    return strncmp(query, "robot_", 6) == 0 || strncmp(query, "self_", 5) == 0;
}

static pose pose_of(const collided_pose *p)
{
    return (pose){{p->position[0], p->position[1], p->position[2]},
        {p->orientation[0], p->orientation[1], p->orientation[2], p->orientation[3]}};
}

static pose pose_product(pose outer, pose inner)
{
    return (pose){vec_add(quat_rotate(outer.q, inner.p), outer.p), quat_unit(quat_mul(outer.q, inner.q))};
}

static bool part_from_shape(link_part *part, const load_body *body, const load_shape *from)
{
    static const shape_type types[] = {[COLLIDED_SPHERE] = SHAPE_SPHERE,
        [COLLIDED_CAPSULE] = SHAPE_CAPSULE,
        [COLLIDED_BOX] = SHAPE_BOX,
        [COLLIDED_CYLINDER] = SHAPE_CYLINDER,
        [COLLIDED_CONE] = SHAPE_CONE,
        [COLLIDED_ELLIPSOID] = SHAPE_ELLIPSOID,
        [COLLIDED_HALFSPACE] = SHAPE_HALFSPACE};
    const collided_shape *s = &from->shape;
    part->body = body;
    part->from = from;
    if (s->type == COLLIDED_HULL) {
        const char *why = subject_from_points(&part->subject, from->points.at, from->points.count, s->radius);
        if (why) printf("  %s: %s\n", body->name, why);
        if (why) return false;
    } else {
        shape core = {.type = types[s->type], .radius = s->radius, .half = {s->half[0], s->half[1], s->half[2]}};
        subject_from_shape(&part->subject, core);
    }
    subject_place(&part->subject, pose_product(pose_of(&body->pose), pose_of(&s->pose)));
    return true;
}

static bool cell_parts(cell *c)
{
    size_t count = 0;
    for (size_t i = 0; i < c->bodies.count; i++) count += c->bodies.at[i].shape_count;
    c->parts = calloc(count + 1, sizeof *c->parts);
    if (!c->parts) abort();
    for (size_t i = 0; i < c->bodies.count; i++)
        for (size_t k = 0; k < c->bodies.at[i].shape_count; k++, c->part_count++)
            if (!part_from_shape(&c->parts[c->part_count], &c->bodies.at[i], &c->bodies.at[i].shapes[k])) return false;
    return true;
}

static bool set_joints(const cell *c, json_object *joints, double *values, load_report *report)
{
    json_object_object_foreach(joints, name, value)
    {
        if (!robot_set(&c->robot, name, json_object_get_double(value), values, report)) return false;
    }
    return true;
}

/* Joint values by name, or a state of the SRDF when `joints` is NULL. */
static bool cell_open(cell *c, const char *robots, json_object *joints, const char *state)
{
    load_report report = {.warnings = 0};
    char package_path[4096], urdf_path[4096], srdf_path[4096];
    (void)snprintf(package_path, sizeof package_path, "%s/panda/panda_description", robots);
    (void)snprintf(urdf_path, sizeof urdf_path, "%s/panda/panda_description/urdf/panda.urdf", robots);
    (void)snprintf(srdf_path, sizeof srdf_path, "%s/panda/panda_moveit_config/config/panda.srdf", robots);
    *c = (cell){.part_count = 0};
    const load_package package = {.name = "moveit_resources_panda_description", .path = package_path};
    const robot_source source = {.urdf = urdf_path, .srdf = srdf_path, .packages = &package, .package_count = 1};
    double *values = NULL;
    bool good = robot_load(&c->robot, &c->pool, &source, &report);
    if (good) {
        values = pool_alloc(&c->pool, (size_t)c->robot.model.joint_count + 1, sizeof *values);
        robot_default_values(&c->robot, values);
        good = joints ? set_joints(c, joints, values, &report) : robot_state(&c->robot, state, values, &report);
    }
    good = good &&
           robot_bodies(&c->robot, collided_pose_identity(), values, COLLIDED_MOVING, &c->pool, &c->bodies, &report);
    if (!good) printf("  %s\n", report.error);
    return good && cell_parts(c);
}

static void cell_close(cell *c)
{
    for (size_t i = 0; i < c->part_count; i++) {
        subject_free(&c->parts[i].subject);
        mesh_destroy(c->parts[i].mesh);
    }
    free(c->parts);
    pool_free(&c->pool);
}

static bool rules_allow(const load_body *body, const char *other)
{
    for (size_t i = 0; i < body->rule_count; i++)
        if (fnmatch(body->rules[i].pattern, other, 0) == 0) return body->rules[i].allow;
    return false;
}

static int nearer_first(const void *x, const void *y)
{
    double a = ((const robot_pair *)x)->result.hi, b = ((const robot_pair *)y)->result.hi;
    return (a > b) - (a < b);
}

/* All pairs of links that may not touch, nearest first. Links have one shape each here, or the nearest counts. */
static robot_pair *self_pairs(const cell *c, size_t *count)
{
    robot_pair *pairs = calloc(c->part_count * c->part_count + 1, sizeof *pairs);
    if (!pairs) abort();
    *count = 0;
    for (size_t i = 0; i < c->part_count; i++)
        for (size_t k = i + 1; k < c->part_count; k++) {
            const load_body *a = c->parts[i].body, *b = c->parts[k].body;
            if (a == b || rules_allow(a, b->name) || rules_allow(b, a->name)) continue;
            pairs[*count] = (robot_pair){a->name, b->name, {&c->parts[i], &c->parts[k]}, {.lo = 0}};
            ask(&c->parts[i].subject, &c->parts[k].subject, &pairs[(*count)++].result);
        }
    qsort(pairs, *count, sizeof *pairs, nearer_first);
    return pairs;
}

static robot_pair *world_pairs(const cell *c, const subject *other, size_t *count)
{
    robot_pair *pairs = calloc(c->part_count + 1, sizeof *pairs);
    if (!pairs) abort();
    *count = 0;
    for (size_t i = 0; i < c->part_count; i++) {
        pairs[*count] = (robot_pair){c->parts[i].body->name, "", {&c->parts[i], NULL}, {.lo = 0}};
        ask(&c->parts[i].subject, other, &pairs[(*count)++].result);
    }
    qsort(pairs, *count, sizeof *pairs, nearer_first);
    return pairs;
}

static bool within(const narrow_result *r, double distance)
{
    return fabs(r->lo - distance) <= ROBOT_TOLERANCE && fabs(r->hi - distance) <= ROBOT_TOLERANCE;
}

static bool is_pair(const robot_pair *p, const char *a, const char *b)
{
    return (strcmp(p->a, a) == 0 && strcmp(p->b, b) == 0) || (strcmp(p->a, b) == 0 && strcmp(p->b, a) == 0);
}

static const char *text_at(json_object *array, size_t i)
{
    return json_object_get_string(json_object_array_get_idx(array, i));
}

static const char hulls_touch_more[] = "hulls of links touch where the meshes do not";

/* The named pairs are those that touch. A hull holds its mesh, so of hulls more pairs may touch, but never fewer. */
static const char *check_colliding(json_object *named, const robot_pair *pairs, size_t touching)
{
    for (size_t i = 0; i < json_object_array_length(named); i++) {
        json_object *pair = json_object_array_get_idx(named, i);
        bool found = false;
        for (size_t k = 0; k < touching; k++) found |= is_pair(&pairs[k], text_at(pair, 0), text_at(pair, 1));
        if (!found) return "a named pair does not touch";
    }
    return touching > json_object_array_length(named) ? hulls_touch_more : NULL;
}

/* The same link, by its mesh; by its hull where there is no mesh. */
static subject meshed(cell *c, link_part *part)
{
    subject s = part->subject;
    load_report report = {.warnings = 0};
    mesh_triangles t;
    if (!part->mesh && part->from->mesh &&
        mesh_load_triangles(&c->pool, part->from->mesh, part->from->scale, &t, &report) &&
        mesh_build(t.points, t.point_count, t.corners, t.count, &part->mesh) != MESH_OK)
        abort();
    if (part->mesh) {
        part->mesh->solid = false; /* the source's truth is of surfaces: what is wholly inside does not touch */
        s.shape = (shape){.type = SHAPE_MESH, .radius = s.shape.radius, .hull = part->mesh->hull, .mesh = part->mesh};
    }
    return s;
}

/* Where hulls touch, the meshes say. */
static void ask_meshes(cell *c, robot_pair *pairs, size_t count)
{
    for (size_t i = 0; i < count && pairs[i].result.lo <= 0; i++) {
        subject a = meshed(c, pairs[i].parts[0]), b = meshed(c, pairs[i].parts[1]);
        ask(&a, &b, &pairs[i].result);
    }
    qsort(pairs, count, sizeof *pairs, nearer_first);
}

static const char *check_robot(json_object *said, const robot_pair *pairs, size_t count)
{
    size_t touching = 0;
    double number;
    while (touching < count && pairs[touching].result.hi <= 0) touching++;
    json_object *colliding = member(said, "colliding"), *named = member(said, "colliding_pairs"), *array;
    if (count == 0) return "nothing to compare";
    if (colliding && json_object_get_boolean(colliding) != (touching > 0)) return "the verdict is wrong";
    if (member_number(said, "links_hit", &number) && number != (double)touching) return "other links are hit";
    if (named) {
        const char *why = check_colliding(named, pairs, touching);
        if (why) return why;
    }
    if (member_number(said, "pairs_checked", &number) && number != (double)count) return "other pairs are filtered";
    if (member_number(said, "min_distance", &number) && !within(&pairs[0].result, number))
        return "the distance is wrong";
    if (*member_text(said, "link") && strcmp(pairs[0].a, member_text(said, "link")) != 0)
        return "another link is nearest";
    if ((array = member(said, "pair")) && !is_pair(&pairs[0], text_at(array, 0), text_at(array, 1)))
        return "another pair is nearest";
    if ((array = member(said, "next|nearest_other"))) {
        size_t next = touching > 0 ? touching : 1;
        double distance = json_object_get_double(json_object_array_get_idx(array, 0));
        if (next >= count || !within(&pairs[next].result, distance)) return "the next distance is wrong";
        if (!is_pair(&pairs[next], text_at(array, 1), text_at(array, 2))) return "another pair is next";
    }
    return NULL;
}

static void print_robot(json_object *object, const robot_pair *pairs, size_t count, const char *why)
{
    json_object *said = member(object, "expected|expect");
    double expected = NAN;
    (void)member_number(said, "min_distance", &expected);
    const narrow_result none = {.lo = NAN, .hi = NAN}, *r = count ? &pairs[0].result : &none;
    printf("%-36s %24.17g %24.17g %24.17g %9.2g  %s\n", member_text(object, "id"), expected, r->lo, r->hi,
        r->hi - r->lo, why ? why : "holds");
    if (count) printf("%-36s nearest %s %s of %zu pairs\n", "", pairs[0].a, pairs[0].b, count);
}

robot_verdict robot_case(json_object *object, const char *robots)
{
    json_object *other = member(object, "shapeB|B");
    if (strcmp(member_text(member(object, "shapeA|A"), "file"), "panda.urdf") != 0) {
        printf("%-36s skipped: no such robot here\n", member_text(object, "id"));
        return ROBOT_SKIPPED;
    }
    cell c;
    const char *why = NULL;
    robot_pair *pairs = NULL;
    size_t count = 0;
    if (!cell_open(&c, robots, member(member(object, "poseA"), "joints"), "ready")) {
        why = "the robot does not load";
    } else if (other) {
        subject obstacle;
        why = subject_from_json(&obstacle, other, member(object, "poseB"));
        if (!why) pairs = world_pairs(&c, &obstacle, &count);
        if (!why) subject_free(&obstacle);
    } else {
        pairs = self_pairs(&c, &count);
    }
    if (!why) why = check_robot(member(object, "expected|expect"), pairs, count);
    if (why == hulls_touch_more && !other) {
        ask_meshes(&c, pairs, count);
        why = check_robot(member(object, "expected|expect"), pairs, count);
    }
    print_robot(object, pairs, count, why);
    free(pairs);
    cell_close(&c);
    return why ? ROBOT_WRONG : ROBOT_HOLDS;
}

bool robot_state_touches(const char *robots, const char *state, const char *link_a, const char *link_b)
{
    cell c;
    bool touches = false;
    if (cell_open(&c, robots, NULL, state)) {
        size_t count;
        robot_pair *pairs = self_pairs(&c, &count);
        for (size_t i = 0; i < count; i++) touches |= is_pair(&pairs[i], link_a, link_b) && pairs[i].result.hi <= 0;
        free(pairs);
    }
    cell_close(&c);
    return touches;
}
