/* triangles: see triangles.h. */
#include "triangles.h"

#include "index.h"

#include <libqhull_r/qhull_ra.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void triangles_free(triangles *t)
{
    free(t->points);
    free(t->indices);
    *t = (triangles){.known = false};
}

static void copy_points(triangles *t, const double *at, size_t count)
{
    t->points = web_allocate(3 * count + 1, sizeof *t->points);
    memcpy(t->points, at, 3 * count * sizeof *at);
    t->point_count = count;
}

static void take_facets(triangles *t, qhT *qh)
{
    size_t capacity = 0;
    facetT *facet;
    FORALLfacets
    {
        vertexT *vertex, **vertexp;
        uint32_t corners[3];
        int count = 0;
        setT *ordered = qh_facet3vertex(qh, facet);
        FOREACHvertex_(ordered)
        {
            if (count < 3) corners[count++] = (uint32_t)qh_pointid(qh, vertex->point);
        }
        qh_settempfree(qh, &ordered);
        if (count < 3) continue;
        t->indices = web_reserve(t->indices, &capacity, t->index_count + 3, sizeof *t->indices);
        memcpy(t->indices + t->index_count, corners, sizeof corners);
        t->index_count += 3;
    }
}

/* What qhull says is thrown away: a hull that it finds none of is drawn by nothing. */
static void make_hull(triangles *t, const double *points, size_t count)
{
    char command[] = "qhull Qt Pp", *messages = NULL;
    size_t size = 0;
    int long_bytes, long_blocks;
    qhT *qh = web_allocate(1, sizeof *qh);
    FILE *sink = open_memstream(&messages, &size);
    copy_points(t, points, count);
    if (count >= 4 && sink) {
        qh_zero(qh, sink);
        if (qh_new_qhull(qh, 3, (int)count, t->points, False, command, NULL, sink) == 0) take_facets(t, qh);
        qh_freeqhull(qh, !qh_ALL);
        qh_memfreeshort(qh, &long_bytes, &long_blocks);
    }
    if (sink) fclose(sink);
    free(messages);
    free(qh);
}

static void make_field(triangles *t, const collided_geometry_numbers *n)
{
    if (n->index_count < 2 || n->vertex_numbers < 3) return;
    size_t columns = (size_t)n->indices[0], rows = (size_t)n->indices[1], at = 0;
    if (columns < 2 || rows < 2 || n->vertex_numbers < 3 + columns * rows) return;
    double dx = n->vertices[0], dy = n->vertices[1];
    t->points = web_allocate(3 * columns * rows, sizeof *t->points);
    t->point_count = columns * rows;
    for (size_t i = 0; i < columns * rows; i++) {
        size_t column = i % columns, row = i / columns;
        t->points[3 * i] = ((double)column - 0.5 * (double)(columns - 1)) * dx;
        t->points[3 * i + 1] = ((double)row - 0.5 * (double)(rows - 1)) * dy;
        t->points[3 * i + 2] = n->vertices[3 + i];
    }
    t->index_count = 6 * (columns - 1) * (rows - 1);
    t->indices = web_allocate(t->index_count, sizeof *t->indices);
    for (size_t r = 0; r + 1 < rows; r++)
        for (size_t c = 0; c + 1 < columns; c++) {
            uint32_t a = (uint32_t)(r * columns + c), b = a + 1, d = a + (uint32_t)columns, e = d + 1;
            const uint32_t corners[6] = {a, b, e, a, e, d};
            memcpy(t->indices + at, corners, sizeof corners);
            at += 6;
        }
}

void triangles_make(triangles *t, const collided_geometry_numbers *n)
{
    t->known = true;
    if (n->kind == COLLIDED_GEOMETRY_HULL) make_hull(t, n->vertices, n->vertex_numbers / 3);
    if (n->kind == COLLIDED_GEOMETRY_HEIGHT_FIELD) make_field(t, n);
    if (n->kind != COLLIDED_GEOMETRY_MESH) return;
    copy_points(t, n->vertices, n->vertex_numbers / 3);
    t->indices = web_allocate(n->index_count + 1, sizeof *t->indices);
    for (size_t i = 0; i < n->index_count; i++) t->indices[i] = (uint32_t)n->indices[i];
    t->index_count = n->index_count;
}

void triangles_put(triangles_kept *k, uint32_t number, const collided_geometry_numbers *numbers)
{
    static const triangles NONE = {.known = false};
    k->at = web_reserve(k->at, &k->capacity, (size_t)number + 1, sizeof *k->at);
    while (k->count <= number) k->at[k->count++] = NONE;
    triangles_free(&k->at[number]);
    triangles_make(&k->at[number], numbers);
}

const triangles *triangles_get(const triangles_kept *k, uint32_t number)
{
    return number < k->count && k->at[number].known ? &k->at[number] : NULL;
}

void triangles_free_all(triangles_kept *k)
{
    for (size_t i = 0; i < k->count; i++) triangles_free(&k->at[i]);
    free(k->at);
    *k = (triangles_kept){.at = NULL};
}
