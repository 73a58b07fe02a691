/* robot_world: see robot_world.h. */
#include "robot_world.h"

#include <stdlib.h>

pose robot_world_pose(const collided_pose *p)
{
    const double *x = p->position, *q = p->orientation;
    return (pose){{x[0], x[1], x[2]}, {q[0], q[1], q[2], q[3]}};
}

static world_shape to_shape(robot_world *p, const load_shape *from)
{
    static const shape_type types[] = {[COLLIDED_SPHERE] = SHAPE_SPHERE,
        [COLLIDED_CAPSULE] = SHAPE_CAPSULE,
        [COLLIDED_BOX] = SHAPE_BOX,
        [COLLIDED_CYLINDER] = SHAPE_CYLINDER,
        [COLLIDED_HULL] = SHAPE_HULL,
        [COLLIDED_MESH] = SHAPE_MESH};
    const collided_shape *s = &from->shape;
    world_shape out = {.shape = {.type = types[s->type],
                           .radius = s->radius,
                           .deviation = s->deviation,
                           .half = {s->half[0], s->half[1], s->half[2]}},
        .local = robot_world_pose(&s->pose)};
    hull *h = NULL;
    mesh *m = NULL;
    const mesh_triangles *t = &from->triangles;
    bool good = true;
    if (s->type == COLLIDED_HULL) good = hull_build(from->points.at, from->points.count, 0, &h) == HULL_OK;
    if (s->type == COLLIDED_MESH) good = mesh_build(t->points, t->point_count, t->corners, t->count, &m) == MESH_OK;
    if (!good) abort();
    if (h) array_push(&p->hulls, h);  /* NOLINT(bugprone-sizeof-expression): pointers are what it keeps */
    if (m) array_push(&p->meshes, m); /* NOLINT(bugprone-sizeof-expression) */
    out.shape.hull = m ? m->hull : h;
    out.shape.mesh = m;
    return out;
}

uint32_t robot_world_put(robot_world *p, world *w, const load_body *from)
{
    world_shape shapes[LOAD_SHAPES_MAX];
    filter_rule *rules = calloc(from->rule_count + 1, sizeof *rules);
    if (!rules) abort();
    for (size_t i = 0; i < from->rule_count; i++)
        rules[i] = (filter_rule){.pattern = from->rules[i].pattern, .allow = true, .reason = from->rules[i].reason};
    for (size_t i = 0; i < from->shape_count; i++) shapes[i] = to_shape(p, &from->shapes[i]);
    world_body def = {.name = from->name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = robot_world_pose(&from->pose),
        .shapes = shapes,
        .shape_count = from->shape_count,
        .rules = rules,
        .rule_count = from->rule_count};
    uint32_t id = WORLD_NONE;
    world_put_body(w, &id, &def);
    free(rules);
    return id;
}

void robot_world_free(robot_world *r)
{
    for (size_t i = 0; i < r->hulls.count; i++) hull_destroy(r->hulls.at[i]);
    for (size_t i = 0; i < r->meshes.count; i++) mesh_destroy(r->meshes.at[i]);
    array_free(&r->hulls);
    array_free(&r->meshes);
}
