/* body: where the vertices of a mesh are at the start and the end of a step, and the memory for their boxes. One thread
 * at a time. */
#include "state.h"

#include "base/array.h"

#include <stdlib.h>

soft_body *soft_body_create(const soft_mesh *mesh)
{
    soft_body *b = base_zalloc(1, sizeof *b);
    b->mesh = mesh;
    b->half_thickness = mesh->half_thickness;
    b->ways = base_zalloc(mesh->vertex_count, sizeof *b->ways);
    b->vertex_boxes = base_alloc_lines(mesh->vertex_count, sizeof *b->vertex_boxes);
    b->node_boxes = base_alloc_lines(mesh->node_count, sizeof *b->node_boxes);
    b->boxes = base_alloc_lines(mesh->block_count, sizeof *b->boxes);
    for (size_t i = 0; i < mesh->block_count; i++) /* empty places stay so */
        for (int row = 0; row < SOFT_SIDES * 3; row++)
            for (int lane = 0; lane < SOFT_LANES; lane++) b->boxes[i].at[row][lane] = INFINITY;
    return b;
}

void soft_body_destroy(soft_body *b)
{
    if (!b) return;
    free(b->ways), free(b->vertex_boxes), free(b->node_boxes), free(b->boxes);
    free(b);
}

void soft_body_set_thickness(soft_body *b, double half_thickness)
{
    b->half_thickness = half_thickness;
}

const soft_mesh *soft_body_mesh(const soft_body *b)
{
    return b->mesh;
}

size_t soft_body_bytes(const soft_body *b)
{
    const soft_mesh *m = b->mesh;
    return sizeof *b + m->vertex_count * (sizeof *b->ways + sizeof *b->vertex_boxes) +
           m->node_count * sizeof *b->node_boxes + m->block_count * sizeof *b->boxes;
}

static bool all_positions(const vec3 *at, size_t count, vec3 *lowest, vec3 *highest)
{
    vec3 low = at[0], high = at[0];
    double sum = 0; /* of zeros: no number if one is none */
    for (size_t i = 0; i < count; i++) {
        vec3 p = at[i];
        sum += 0 * p.x + 0 * p.y + 0 * p.z;
        low = (vec3){p.x < low.x ? p.x : low.x, p.y < low.y ? p.y : low.y, p.z < low.z ? p.z : low.z};
        high = (vec3){p.x > high.x ? p.x : high.x, p.y > high.y ? p.y : high.y, p.z > high.z ? p.z : high.z};
    }
    *lowest = low, *highest = high;
    return sum == 0 && vec_max_abs(low) <= SOFT_FAR_M && vec_max_abs(high) <= SOFT_FAR_M;
}

soft_status soft_body_set(soft_body *b, const vec3 *start, const vec3 *end)
{
    size_t n = b->mesh->vertex_count;
    vec3 low[2], high[2];
    if (!all_positions(start, n, &low[0], &high[0]) || !all_positions(end, n, &low[1], &high[1])) return SOFT_NO_NUMBER;
    for (size_t i = 0; i < n; i++) b->ways[i] = (soft_way){start[i], end[i]};
    b->lowest = vec_min(low[0], low[1]), b->highest = vec_max(high[0], high[1]);
    return SOFT_OK;
}
