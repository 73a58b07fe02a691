/* body_announce: hands a loaded body to the client library. The only file of the loaders that calls it. */
#include "body.h"

static void fill_body_def(const load_body *body, collided_body_def *def)
{
    def->name = body->name;
    def->group = body->group;
    def->motion = body->motion;
    def->category = body->category;
    def->mask = body->mask;
    def->one_way = body->one_way;
    def->ccd = body->ccd;
    def->acceleration_m_s2 = body->acceleration_m_s2;
    def->angular_acceleration_rad_s2 = body->angular_acceleration_rad_s2;
    def->pose = body->pose;
    def->deadline_s = body->deadline_s;
    def->shape_count = body->shape_count;
    def->rules = body->rules;
    def->rule_count = body->rule_count;
}

static bool create_geometry(collided *c, const load_shape *from, collided_shape *to)
{
    const mesh_triangles *t = &from->triangles;
    const load_heights *h = &from->heights;
    if (to->type == COLLIDED_HULL)
        to->geometry = collided_create_hull(c, from->points.at, from->points.count);
    else if (to->type == COLLIDED_MESH)
        to->geometry = collided_create_mesh(c, t->points, t->point_count, t->corners, t->count);
    else if (to->type == COLLIDED_HEIGHT_FIELD)
        to->geometry = collided_create_height_field(
            c, h->grid.at, h->grid.rows, h->grid.columns, h->spacing[0], h->spacing[1], h->base);
    else
        return true;
    return to->geometry.hash != 0;
}

/* `children`: room for them, which lasts until the body is made. */
static bool create_shape(collided *c, const load_shape *from, collided_shape *to, collided_shape *children)
{
    *to = from->shape;
    to->children = children;
    to->child_count = from->child_count;
    for (size_t i = 0; i < from->child_count; i++) {
        children[i] = from->children[i].shape;
        if (!create_geometry(c, &from->children[i], &children[i])) return false;
    }
    return create_geometry(c, from, to);
}

collided_body load_body_announce(collided *c, const load_body *body, int32_t id)
{
    collided_shape shapes[LOAD_SHAPES_MAX], children[LOAD_SHAPES_MAX];
    size_t used = 0;
    for (size_t i = 0; i < body->shape_count; used += body->shapes[i++].child_count)
        if (!create_shape(c, &body->shapes[i], &shapes[i], children + used)) return (collided_body){COLLIDED_NONE};
    collided_body_def def = collided_body_def_default();
    fill_body_def(body, &def);
    def.id = id;
    def.shapes = shapes;
    return collided_create_body(c, &def);
}
