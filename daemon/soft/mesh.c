/* mesh: the topology of a soft mesh, built once: edges, the triangles around each vertex and beside each edge, and
 * which vertices are near by the edges between them. Any thread. */
#include "state.h"

#include "base/array.h"
#include "base/sort.h"

#include <stdlib.h>
#include <string.h>

const char *soft_status_name(soft_status s)
{
    static const char *const NAMES[] = {
        "ok", "more", "empty", "too_many", "out_of_range", "no_number", "body_twice", "over_memory"};
    return (unsigned)s < sizeof NAMES / sizeof *NAMES ? NAMES[s] : "?";
}

static void *give(soft_mesh *m, size_t count, size_t size)
{
    m->bytes += count * size;
    return base_zalloc(count ? count : 1, size);
}

static bool is_position(vec3 p)
{
    return vec_finite(p) && vec_max_abs(p) <= SOFT_FAR_M;
}

static soft_status check(const soft_mesh_def *def)
{
    if (def->vertex_count == 0 || def->triangle_count == 0) return SOFT_EMPTY;
    if (def->vertex_count > SOFT_FEATURES_MAX || def->triangle_count > SOFT_FEATURES_MAX / 3) return SOFT_TOO_MANY;
    if (def->ring > SOFT_RING_MAX) return SOFT_TOO_MANY;
    if (!(def->half_thickness >= 0 && def->half_thickness <= SOFT_FAR_M)) return SOFT_NO_NUMBER;
    if (!(def->rest_exclusion >= 0 && def->rest_exclusion <= SOFT_FAR_M)) return SOFT_NO_NUMBER;
    for (size_t i = 0; i < def->vertex_count; i++)
        if (!is_position(def->rest[i])) return SOFT_NO_NUMBER;
    for (size_t i = 0; i < def->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            if (def->triangles[i][k] >= def->vertex_count) return SOFT_OUT_OF_RANGE;
    return SOFT_OK;
}

/* ---- edges ---- */

static void make_edges(soft_mesh *m)
{
    size_t most = 3 * m->triangle_count, count = 0, edges = 0;
    uint64_t *keys = base_alloc(2 * most, sizeof *keys);
    for (size_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t a = m->triangles[i][k], b = m->triangles[i][(k + 1) % 3];
            if (a != b) keys[count++] = a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
        }
    sort_keys(keys, keys + most, count);
    for (size_t i = 0; i < count; i++)
        if (i == 0 || keys[i] != keys[i - 1]) keys[edges++] = keys[i];
    m->edge_count = edges;
    m->edges = give(m, edges, sizeof *m->edges);
    for (size_t i = 0; i < edges; i++) m->edges[i][0] = (uint32_t)(keys[i] >> 32), m->edges[i][1] = (uint32_t)keys[i];
    free(keys);
}

static uint32_t find_edge(const soft_mesh *m, uint32_t a, uint32_t b)
{
    uint32_t low = a < b ? a : b, high = a < b ? b : a;
    size_t first = 0, last = m->edge_count;
    while (last - first > 1) {
        size_t middle = first + (last - first) / 2;
        const uint32_t *e = m->edges[middle];
        if (e[0] < low || (e[0] == low && e[1] <= high))
            first = middle;
        else
            last = middle;
    }
    return (uint32_t)first;
}

/* By triangle its edges; a triangle (a, b, b) has one. */
static uint32_t (*edges_of_triangles(soft_mesh *m))[3]
{
    uint32_t(*of)[3] = base_alloc(m->triangle_count, sizeof *of);
    uint8_t *seen = base_zalloc(m->edge_count + 1, 1);
    m->beside = give(m, m->edge_count, sizeof *m->beside);
    for (size_t e = 0; e < m->edge_count; e++) m->beside[e][0] = m->beside[e][1] = SOFT_NONE;
    for (size_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t a = m->triangles[i][k], b = m->triangles[i][(k + 1) % 3];
            of[i][k] = a != b ? find_edge(m, a, b) : SOFT_NONE;
            for (int j = 0; j < k; j++)
                if (of[i][j] == of[i][k]) of[i][k] = SOFT_NONE;
            uint32_t e = of[i][k];
            if (e == SOFT_NONE) continue;
            if (seen[e] < 2)
                m->beside[e][seen[e]++] = (uint32_t)i;
            else
                m->beside[e][0] = SOFT_NONE;
        }
    free(seen);
    return of;
}

/* ---- neighbours ---- */

static void make_around(soft_mesh *m)
{
    uint32_t *first = m->around_first = give(m, m->vertex_count + 1, sizeof *m->around_first);
    for (size_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) first[m->triangles[i][k] + 1]++;
    for (size_t v = 0; v < m->vertex_count; v++) first[v + 1] += first[v];
    m->around = give(m, 3 * m->triangle_count, sizeof *m->around);
    uint32_t *next = base_alloc(m->vertex_count, sizeof *next);
    memcpy(next, first, m->vertex_count * sizeof *next);
    for (size_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) m->around[next[m->triangles[i][k]]++] = (uint32_t)i;
    free(next);
}

typedef struct reached { /* a walk over edges from one vertex */
    ARRAY(uint32_t) found;
    uint32_t *mark; /* by vertex: the last walk that has found it, 1 + its first vertex */
} reached;

static void reach_from(const soft_mesh *m, uint32_t vertex, reached *r)
{
    r->found.count = 0;
    array_push(&r->found, vertex);
    r->mark[vertex] = vertex + 1;
    size_t from = 0;
    for (unsigned ring = 0; ring < m->ring; ring++) {
        size_t until = r->found.count;
        for (; from < until; from++) {
            uint32_t v = r->found.at[from];
            for (uint32_t i = m->around_first[v]; i < m->around_first[v + 1]; i++)
                for (int k = 0; k < 3; k++) {
                    uint32_t other = m->triangles[m->around[i]][k];
                    if (r->mark[other] == vertex + 1) continue;
                    r->mark[other] = vertex + 1;
                    array_push(&r->found, other);
                }
        }
    }
    qsort(r->found.at, r->found.count, sizeof *r->found.at, sort_compare_u32);
}

/* False: it would take more memory than is allowed. */
static bool make_near(soft_mesh *m, size_t memory_max)
{
    reached r = {.mark = base_zalloc(m->vertex_count, sizeof *r.mark)};
    ARRAY(uint32_t) near = {0};
    bool fits = true;
    m->near_first = give(m, m->vertex_count + 1, sizeof *m->near_first);
    for (uint32_t v = 0; fits && v < m->vertex_count; v++) {
        reach_from(m, v, &r);
        array_reserve(&near, near.count + r.found.count);
        memcpy(near.at + near.count, r.found.at, r.found.count * sizeof *near.at);
        near.count += r.found.count;
        m->near_first[v + 1] = (uint32_t)near.count;
        fits = near.count < UINT32_MAX / 2 && (!memory_max || m->bytes + near.count * sizeof *near.at <= memory_max);
    }
    m->near = near.at;
    m->bytes += near.capacity * sizeof *near.at;
    array_free(&r.found);
    free(r.mark);
    return fits;
}

/* ---- the whole ---- */

soft_mesh *soft_mesh_create(const soft_mesh_def *def, soft_status *status)
{
    *status = check(def);
    if (*status != SOFT_OK) return NULL;
    soft_mesh *m = base_zalloc(1, sizeof *m);
    m->bytes = sizeof *m;
    m->vertex_count = def->vertex_count, m->triangle_count = def->triangle_count;
    m->half_thickness = def->half_thickness, m->rest_exclusion = def->rest_exclusion, m->ring = def->ring;
    m->triangles = give(m, def->triangle_count, sizeof *m->triangles);
    memcpy(m->triangles, def->triangles, def->triangle_count * sizeof *m->triangles);
    make_edges(m);
    uint32_t(*triangle_edges)[3] = edges_of_triangles(m);
    make_around(m);
    m->rest = give(m, def->vertex_count, sizeof *m->rest);
    memcpy(m->rest, def->rest, def->vertex_count * sizeof *m->rest);
    soft_mesh_cluster(m, def->rest, triangle_edges);
    free(triangle_edges);
    bool fits = !def->memory_max || m->bytes <= def->memory_max;
    if (fits && m->ring > 0) fits = make_near(m, def->memory_max);
    if (fits && (!def->memory_max || m->bytes <= def->memory_max)) return m;
    soft_mesh_destroy(m);
    *status = SOFT_OVER_MEMORY;
    return NULL;
}

void soft_mesh_destroy(soft_mesh *m)
{
    if (!m) return;
    free(m->triangles), free(m->edges), free(m->beside), free(m->around_first), free(m->around);
    free(m->near_first), free(m->near), free(m->rest), free(m->clusters), free(m->blocks), free(m->nodes);
    free(m);
}

size_t soft_mesh_vertex_count(const soft_mesh *m)
{
    return m->vertex_count;
}

size_t soft_mesh_triangle_count(const soft_mesh *m)
{
    return m->triangle_count;
}

size_t soft_mesh_edge_count(const soft_mesh *m)
{
    return m->edge_count;
}

void soft_mesh_triangle(const soft_mesh *m, uint32_t face, uint32_t corners[3])
{
    memcpy(corners, m->triangles[face], sizeof m->triangles[face]);
}

const vec3 *soft_mesh_rest(const soft_mesh *m)
{
    return m->rest;
}

void soft_mesh_edge(const soft_mesh *m, uint32_t edge, uint32_t ends[2])
{
    memcpy(ends, m->edges[edge], sizeof m->edges[edge]);
}

size_t soft_mesh_bytes(const soft_mesh *m)
{
    return m->bytes;
}
