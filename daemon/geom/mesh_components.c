/* The components of a mesh: what hangs together by common vertices. Any thread.
 *
 * By trees of vertices that point to one of their own component (Tarjan, "Efficiency of a good but not linear set union
 * algorithm", 1975); of two trees the one with the greater root goes below the other, with paths halved on the way. */
#include "mesh_steps.h"

#include "base/array.h"

#include <stdlib.h>
#include <string.h>

static uint32_t root_of(uint32_t *parent, uint32_t v)
{
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

static void join_components(uint32_t *parent, uint32_t v, uint32_t w)
{
    uint32_t a = root_of(parent, v), b = root_of(parent, w);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

static void take_box(const mesh *m, uint32_t triangle, mesh_component *c)
{
    for (int k = 0; k < 3; k++) {
        vec3 v = mesh_corner(m, triangle, k);
        const double at[3] = {v.x / m->unit, v.y / m->unit, v.z / m->unit};
        for (int i = 0; i < 3; i++) {
            c->lo[i] = fminf(c->lo[i], -float_above(-at[i]));
            c->hi[i] = fmaxf(c->hi[i], float_above(at[i]));
        }
    }
}

void mesh_components_build(mesh *m)
{
    uint32_t *parent = base_alloc(m->vertex_count, sizeof *parent),
             *number = base_alloc(m->vertex_count, sizeof *number);
    for (uint32_t v = 0; v < m->vertex_count; v++) parent[v] = v;
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        const uint32_t *v = m->triangles[t].v;
        join_components(parent, v[0], v[1]);
        join_components(parent, v[0], v[2]);
    }
    memset(number, 0xff, m->vertex_count * sizeof *number);
    ARRAY(mesh_component) all = {0};
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        uint32_t root = root_of(parent, m->triangles[t].v[0]);
        if (number[root] == UINT32_MAX) {
            number[root] = (uint32_t)all.count;
            array_push(&all,
                ((mesh_component){
                    .triangle = t, .lo = {INFINITY, INFINITY, INFINITY}, .hi = {-INFINITY, -INFINITY, -INFINITY}}));
        }
        take_box(m, t, &all.at[number[root]]);
    }
    m->component_count = (uint32_t)all.count;
    m->components = base_realloc(all.at, all.count, sizeof *all.at);
    free(parent);
    free(number);
}
