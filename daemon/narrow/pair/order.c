/* order: the canonical order of two shapes, so that a pair is always computed the same way round. Pure; any thread. */
#include "geom/compound.h"
#include "geom/mesh.h"
#include "unit_pair.h"

#include <string.h>

static int compare(double x, double y)
{
    return (x > y) - (x < y);
}

static int compare_array(const double *x, const double *y, uint32_t count)
{
    int c = 0;
    for (uint32_t i = 0; i < count && c == 0; i++) c = compare(x[i], y[i]);
    return c;
}

static int compare_hull(const hull *a, const hull *b)
{
    if (a == b) return 0;
    if (a->vertex_count != b->vertex_count) return a->vertex_count < b->vertex_count ? -1 : 1;
    int c = compare_array(a->x, b->x, a->vertex_count);
    if (c == 0) c = compare_array(a->y, b->y, a->vertex_count);
    return c ? c : compare_array(a->z, b->z, a->vertex_count);
}

static int compare_mesh(const mesh *a, const mesh *b)
{
    if (a == b) return 0;
    if (a->triangle_count != b->triangle_count) return a->triangle_count < b->triangle_count ? -1 : 1;
    if (a->vertex_count != b->vertex_count) return a->vertex_count < b->vertex_count ? -1 : 1;
    int c = compare_array(&a->vertices->x, &b->vertices->x, 3 * a->vertex_count);
    return c ? c : memcmp(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles);
}

static int compare_vec(vec3 a, vec3 b)
{
    int c = compare(a.x, b.x);
    if (c == 0) c = compare(a.y, b.y);
    return c ? c : compare(a.z, b.z);
}

static int compare_compound(const compound *a, const compound *b)
{
    if (a == b) return 0;
    if (a->child_count != b->child_count) return a->child_count < b->child_count ? -1 : 1;
    int c = 0;
    for (uint32_t i = 0; i < a->child_count && c == 0; i++) {
        c = order_shapes(&a->children[i].shape, &b->children[i].shape); /* no child is a compound */
        if (c == 0) c = order_poses(a->children[i].local, b->children[i].local);
        if (c == 0) c = compare(a->children[i].shape.deviation, b->children[i].shape.deviation);
    }
    return c;
}

int order_shapes(const shape *a, const shape *b)
{
    if (a->type != b->type) return a->type < b->type ? -1 : 1;
    int c = compare_vec(a->half, b->half);
    if (c == 0) c = compare(a->radius, b->radius);
    if (c == 0 && a->type == SHAPE_COMPOUND) return compare_compound(a->compound, b->compound);
    if (c || !a->hull) return c;
    c = compare_hull(a->hull, b->hull);
    return c || a->type != SHAPE_MESH ? c : compare_mesh(a->mesh, b->mesh);
}

int order_poses(pose a, pose b)
{
    int c = compare_vec(a.p, b.p);
    if (c == 0) c = compare(a.q.w, b.q.w);
    return c ? c : compare_vec(vec(a.q.x, a.q.y, a.q.z), vec(b.q.x, b.q.y, b.q.z));
}
