/* build_kinds: the building of one geometry out of its numbers. Pure: any thread. */
#include "builds.h"
#include "geometries.h"

#include "geom/height_field.h"
#include "service.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

geometry_numbers *geometry_numbers_create(uint8_t kind, int64_t hash, size_t vertex_numbers, size_t index_numbers)
{
    geometry_numbers *n = base_zalloc(1, sizeof *n);
    atomic_init(&n->refs, 1);
    n->kind = kind;
    n->hash = hash;
    n->vertex_numbers = vertex_numbers;
    n->index_numbers = index_numbers;
    n->vertices = base_zalloc(vertex_numbers ? vertex_numbers : 1, sizeof *n->vertices);
    n->indices = base_zalloc(index_numbers ? index_numbers : 1, sizeof *n->indices);
    return n;
}

geometry_numbers *geometry_numbers_keep(geometry_numbers *n)
{
    atomic_fetch_add(&n->refs, 1);
    return n;
}

void geometry_numbers_release(geometry_numbers *n)
{
    if (!n || atomic_fetch_sub(&n->refs, 1) != 1) return;
    free(n->vertices);
    free(n->indices);
    free(n);
}

bool geometry_numbers_equal(const geometry_numbers *a, const geometry_numbers *b)
{
    return a->hash == b->hash && a->kind == b->kind && a->vertex_numbers == b->vertex_numbers &&
           a->index_numbers == b->index_numbers &&
           memcmp(a->vertices, b->vertices, a->vertex_numbers * sizeof *a->vertices) == 0 &&
           memcmp(a->indices, b->indices, a->index_numbers * sizeof *a->indices) == 0;
}

/* Measured: a hull of 64 points takes 0.2 ms, the worst of several kinds 4 ms; a mesh of 32 triangles 0.5 ms, of 80 2.4
 * ms, of 4 million 25 s. What is built takes 270 to 400 bytes a triangle. */
build_cost build_cost_of(uint8_t kind, size_t vertex_numbers, size_t index_numbers)
{
    enum { BUILT_BYTES = 400, TRIANGLE_UNITS = 2 };
    build_cost c = {.points = vertex_numbers / 3,
        .bytes = (uint64_t)geometry_bytes((int64_t)vertex_numbers, (int64_t)index_numbers)};
    if (kind == WIRE_GEOMETRY_MESH || kind == WIRE_GEOMETRY_SOFT) c.triangles = index_numbers / 3;
    if (kind == WIRE_GEOMETRY_HEIGHT_FIELD) {
        c.points = vertex_numbers > WIRE_FIELD_HEAD ? vertex_numbers - WIRE_FIELD_HEAD : 0;
        c.triangles = 2 * c.points;
    }
    c.bytes += BUILT_BYTES * (c.points + c.triangles);
    c.units = c.triangles ? TRIANGLE_UNITS * c.triangles : c.points;
    return c;
}

static void refuse_geometry(built *out, wire_reason reason, const char *fields, const char *text)
{
    out->why.reason = reason;
    snprintf(out->why.text, sizeof out->why.text, "%s: %s", fields, text);
}

static void build_hull(const geometry_numbers *n, built *out)
{
    hull_status status = hull_build(n->vertices, n->vertex_numbers / 3, 0, &out->hull);
    wire_reason reason = status == HULL_FLAT       ? WIRE_FLAT_HULL
                         : status == HULL_TOO_MANY ? WIRE_TOO_LARGE
                                                   : WIRE_BAD_SIZE;
    if (status != HULL_OK) refuse_geometry(out, reason, "vertices", hull_status_text(status));
}

static void build_mesh(const geometry_numbers *n, built *out)
{
    mesh_status status = mesh_build(n->vertices, n->vertex_numbers / 3, n->indices, n->index_numbers / 3, &out->mesh);
    bool large = status == MESH_TOO_MANY || status == MESH_WIDE_HULL;
    if (status != MESH_OK)
        refuse_geometry(out, large ? WIRE_TOO_LARGE : WIRE_BAD_SIZE, "vertices, indices", mesh_status_text(status));
}

/* A ring takes by vertex as many numbers as there are vertices in it: there is a limit. */
static void build_soft(const geometry_numbers *n, built *out)
{
    static const size_t MOST_BYTES_A_TRIANGLE = 1000, MOST_BYTES_AT_LEAST = 1 << 20;
    size_t vertices = (n->vertex_numbers - WIRE_SOFT_HEAD) / 3, triangles = n->index_numbers / 3;
    vec3 *rest = base_alloc(vertices, sizeof *rest);
    uint32_t(*corners)[3] = base_alloc(triangles, sizeof *corners);
    const double *at = n->vertices + WIRE_SOFT_HEAD;
    for (size_t i = 0; i < vertices; i++) rest[i] = vec(at[3 * i], at[3 * i + 1], at[3 * i + 2]);
    for (size_t i = 0; i < n->index_numbers; i++) corners[i / 3][i % 3] = (uint32_t)n->indices[i];
    const soft_mesh_def def = {.rest = rest,
        .vertex_count = vertices,
        .triangles = (const uint32_t(*)[3])corners,
        .triangle_count = triangles,
        .ring = (unsigned)n->vertices[0],
        .rest_exclusion = n->vertices[1],
        .memory_max = MOST_BYTES_AT_LEAST + MOST_BYTES_A_TRIANGLE * triangles};
    soft_status status;
    out->soft = soft_mesh_create(&def, &status);
    bool large = status == SOFT_TOO_MANY || status == SOFT_OVER_MEMORY;
    if (!out->soft)
        refuse_geometry(out, large ? WIRE_TOO_LARGE : WIRE_BAD_SIZE, "vertices, indices", soft_status_name(status));
    free(corners);
    free(rest);
}

static void build_height_field(const geometry_numbers *n, built *out)
{
    const double *head = n->vertices;
    int32_t columns = n->indices[0], rows = n->indices[1];
    int64_t heights = (int64_t)n->vertex_numbers - WIRE_FIELD_HEAD;
    if (columns < 2 || rows < 2 || (int64_t)columns * rows != heights) { /* they came in pieces of their own */
        out->why.reason = WIRE_MALFORMED;
        snprintf(out->why.text, sizeof out->why.text, "indices: %d columns and %d rows are not %" PRId64 " heights",
            columns, rows, heights);
        return;
    }
    const height_field field = {.rows = (uint32_t)rows,
        .columns = (uint32_t)columns,
        .dx = head[0],
        .dy = head[1],
        .base = head[2],
        .heights = head + WIRE_FIELD_HEAD};
    height_field_status status = height_field_build(&field, &out->mesh);
    bool large = status == HEIGHT_FIELD_TOO_MANY || status == HEIGHT_FIELD_NO_MESH;
    if (status != HEIGHT_FIELD_OK)
        refuse_geometry(
            out, large ? WIRE_TOO_LARGE : WIRE_BAD_SIZE, "vertices, indices", height_field_status_text(status));
}

void build_now(const geometry_numbers *n, built *out)
{
    *out = (built){.same = 0};
    int64_t hash = wire_geometry_hash(n->kind, (wire_f64s){(uint32_t)n->vertex_numbers, n->vertices},
        (wire_i32s){(uint32_t)n->index_numbers, n->indices});
    if (hash != n->hash)
        refuse_geometry(out, WIRE_BAD_HASH, "hash", "the content has another one");
    else if (n->kind == WIRE_GEOMETRY_MESH)
        build_mesh(n, out);
    else if (n->kind == WIRE_GEOMETRY_SOFT)
        build_soft(n, out);
    else if (n->kind == WIRE_GEOMETRY_HEIGHT_FIELD)
        build_height_field(n, out);
    else
        build_hull(n, out);
}
