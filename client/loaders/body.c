/* body: the meshes of a body are read here. */
#include "body.h"

bool load_body_meshes(pool *p, load_body *body, load_report *r)
{
    for (size_t i = 0; i < body->shape_count; i++) {
        load_shape *s = &body->shapes[i];
        if (s->mesh && !mesh_load(p, s->mesh, s->scale, &s->points, r)) return false;
    }
    return true;
}
