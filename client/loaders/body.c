/* body: the meshes and heights of a body are read here. */
#include "body.h"

bool load_body_meshes(pool *p, load_body *body, load_report *r)
{
    for (size_t i = 0; i < body->shape_count; i++) {
        load_shape *s = &body->shapes[i];
        load_heights *h = &s->heights;
        if (h->path && !heights_load(p, h->path, h->range, &h->grid, r)) return false;
        if (!s->mesh) continue;
        bool loaded = s->shape.type == COLLIDED_MESH ? mesh_load_triangles(p, s->mesh, s->scale, &s->triangles, r)
                                                     : mesh_load(p, s->mesh, s->scale, &s->points, r);
        if (!loaded) return false;
    }
    return true;
}
