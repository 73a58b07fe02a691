/* body: the meshes and heights of a body are read here. */
#include "body.h"

static bool load_mesh(pool *p, load_shape *s, load_report *r)
{
    if (!s->mesh) return true;
    bool triangles = s->shape.type == COLLIDED_MESH;
    return triangles ? mesh_load_triangles(p, s->mesh, s->scale, &s->triangles, r)
                     : mesh_load(p, s->mesh, s->scale, &s->points, r);
}

bool load_body_meshes(pool *p, load_body *body, load_report *r)
{
    for (size_t i = 0; i < body->shape_count; i++) {
        load_shape *s = &body->shapes[i];
        load_heights *h = &s->heights;
        if (h->path && !heights_load(p, h->path, h->range, &h->grid, r)) return false;
        if (!load_mesh(p, s, r)) return false;
        for (size_t k = 0; k < s->child_count; k++)
            if (!load_mesh(p, &s->children[k], r)) return false;
    }
    return true;
}
