/* Components that are inside of a solid, by one point of each. Pure; any thread.
 *
 * A mesh may be a hundred thousand loose triangles: where a box around many of them is nowhere near the solid's
 * surface, all of these are on one side of it, and one point tells for all. So only components near the surface,
 * compared with how far they are from each other, are asked one by one. */
#include "mesh_held.h"

#include "core.h"

enum { FEW = MESH_LEAF_MAX }; /* components that are rather asked each than by a box */

typedef struct held_search {
    const mesh_walk *w;
    const mesh *m, *solid;
    bool of_a;
} held_search;

vec3 mesh_component_point(const mesh_walk *w, bool of_a, uint32_t component)
{
    const mesh *m = of_a ? w->ma : w->mb;
    vec3 own = vec_scale(m->corners[3 * (size_t)m->components[component].triangle], w->part.scale);
    return of_a ? own : transform_point(&w->part.b_in_a, own);
}

double mesh_component_width(const mesh_walk *w, bool of_a, uint32_t component, vec3 direction)
{
    const mesh *m = of_a ? w->ma : w->mb;
    const mesh_component *c = &m->components[component];
    vec3 d = of_a ? direction : mat_tmul(w->part.b_in_a.r, direction);
    vec3 extent = vec(
        (double)c->hi[0] - (double)c->lo[0], (double)c->hi[1] - (double)c->lo[1], (double)c->hi[2] - (double)c->lo[2]);
    return (fabs(d.x) * extent.x + fabs(d.y) * extent.y + fabs(d.z) * extent.z) * m->unit * w->part.scale;
}

static bool is_inside(const held_search *q, uint32_t component)
{
    vec3 own = vec_scale(q->m->corners[3 * (size_t)q->m->components[component].triangle], q->w->part.scale);
    vec3 there = transform_point(q->of_a ? &q->w->a_in_b : &q->w->part.b_in_a, own);
    return mesh_inside(q->solid, vec_scale(there, q->w->part.unit));
}

/* The first of those from `first` to `end` that begins at a triangle or after it; `end`: none does. */
static uint32_t component_from(const mesh *m, uint32_t first, uint32_t end, uint32_t triangle)
{
    while (first < end) {
        uint32_t middle = first + (end - first) / 2;
        if (m->components[middle].triangle < triangle)
            first = middle + 1;
        else
            end = middle;
    }
    return first;
}

static uint32_t first_triangle(const mesh *m, uint32_t node, uint32_t child)
{
    while (m->nodes[node].count[child] == 0) node = m->nodes[node].first[child], child = 0;
    return m->nodes[node].first[child];
}

static uint32_t ask_each(const held_search *q, uint32_t first, uint32_t end)
{
    for (uint32_t i = first; i < end; i++) {
        if (q->w->effort && !effort_spend(q->w->effort, EFFORT_INSIDE)) return MESH_HELD_UNKNOWN;
        if (is_inside(q, i)) return i;
    }
    return MESH_NOT_HELD;
}

/* Of the components from `first` to `end`, which are all that begin below the node. As deep as the tree. */
static uint32_t search(const held_search *q, uint32_t node, uint32_t first, uint32_t end)
{
    const mesh_node *n = &q->m->nodes[node];
    if (end - first <= FEW) return ask_each(q, first, end);
    for (uint32_t i = 0, next; i < n->used; i++, first = next) {
        next = i + 1 < n->used ? component_from(q->m, first, end, first_triangle(q->m, node, i + 1)) : end;
        bool few = next - first <= FEW, clear = !few && mesh_walk_is_clear(q->w, q->of_a, node, i);
        uint32_t held = few || n->count[i] > 0 || clear ? ask_each(q, first, clear ? first + 1 : next)
                                                        : search(q, n->first[i], first, next);
        if (held != MESH_NOT_HELD) return held;
    }
    return MESH_NOT_HELD;
}

uint32_t mesh_held_component(mesh_walk *w, bool of_a)
{
    const held_search q = {w, of_a ? w->ma : w->mb, of_a ? w->mb : w->ma, of_a};
    if (!q.solid->solid) return MESH_NOT_HELD;
    if (q.m->component_count > FEW) {
        mesh_walk_move(w, w->part.b_in_a.t);
        w->within = 0;
    }
    return search(&q, 0, 0, q.m->component_count);
}
