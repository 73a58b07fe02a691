/* The call of libqhull_r. Any thread: the reentrant library keeps its state in a qhT that lives for one call, its error
 * exits (longjmp) end inside qh_new_qhull, and its messages go to a memory stream that is thrown away: the status says
 * that it failed. After the call its lists are only read, by macros, so no later error exit can happen. */
#include "hull_loops.h"

#include "base/array.h"

#include <assert.h>
#include <libqhull_r/qhull_ra.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static_assert(sizeof(vec3) == 3 * sizeof(coordT), "qhull reads the points as triples of doubles");

/* The neighbours of a point within the facet at hand: a loop has exactly two at each corner. */
typedef struct link_pair {
    uint32_t to[2];
    uint32_t count;
} link_pair;

typedef struct reader {
    qhT *qh;
    const vec3 *points; /* as qhull sees them: joggled, if it was asked to */
    link_pair *links;   /* one a point; all empty between facets */
    hull_loops *out;
} reader;

static void add_link(reader *r, uint32_t a, uint32_t b)
{
    link_pair *link = &r->links[a];
    if (link->count < 2) link->to[link->count] = b;
    link->count++;
}

static void add_side(reader *r, vertexT *a, vertexT *b)
{
    uint32_t from = (uint32_t)qh_pointid(r->qh, a->point), to = (uint32_t)qh_pointid(r->qh, b->point);
    add_link(r, from, to);
    add_link(r, to, from);
}

/* A simplicial facet may have no ridges of its own: its sides are the pairs of its three vertices. */
static void collect_sides(reader *r, facetT *facet)
{
    ridgeT *ridge, **ridgep;
    if (!facet->simplicial) {
        FOREACHridge_(facet->ridges)
        {
            add_side(r, SETfirstt_(ridge->vertices, vertexT), SETsecondt_(ridge->vertices, vertexT));
        }
        return;
    }
    vertexT *v[3] = {SETfirstt_(facet->vertices, vertexT), SETsecondt_(facet->vertices, vertexT),
        SETelemt_(facet->vertices, 2, vertexT)};
    for (int k = 0; k < 3; k++) add_side(r, v[k], v[(k + 1) % 3]);
}

/* Walks the links from `start` around to it again; appends the corners. */
static bool walk_loop(reader *r, uint32_t start, uint32_t expected)
{
    uint32_t *corners = &r->out->corners[r->out->corner_count], count = 0, at = start, from = r->links[start].to[1];
    do {
        const link_pair *link = &r->links[at];
        if (link->count != 2 || count == expected) return false;
        corners[count++] = at;
        uint32_t next = link->to[0] == from ? link->to[1] : link->to[0];
        from = at;
        at = next;
    } while (at != start);
    r->out->corner_count += count;
    return count == expected;
}

static vec3 area_of_loop(const vec3 *points, const uint32_t *corners, uint32_t count)
{
    vec3 sum = VEC_ZERO;
    for (uint32_t i = 1; i + 1 < count; i++)
        sum = vec_add(sum, triangle_area(points[corners[0]], points[corners[i]], points[corners[i + 1]]));
    return sum;
}

static bool read_facet(reader *r, facetT *facet)
{
    hull_loops *out = r->out;
    vertexT *vertex, **vertexp;
    uint32_t begin = out->corner_count, size = (uint32_t)qh_setsize(r->qh, facet->vertices);
    if (size < 3) return false;
    collect_sides(r, facet);
    bool closed = walk_loop(r, (uint32_t)qh_pointid(r->qh, SETfirstt_(facet->vertices, vertexT)->point), size);
    FOREACHvertex_(facet->vertices)
    {
        r->links[qh_pointid(r->qh, vertex->point)].count = 0;
    }
    if (!closed) return false;
    uint32_t *corners = &out->corners[begin];
    vec3 outward = {facet->normal[0], facet->normal[1], facet->normal[2]};
    if (vec_dot(area_of_loop(r->points, corners, size), outward) < 0)
        for (uint32_t i = 0, j = size - 1; i < j; i++, j--) {
            uint32_t swap = corners[i];
            corners[i] = corners[j];
            corners[j] = swap;
        }
    out->first[++out->face_count] = out->corner_count;
    return true;
}

static bool read_facets(qhT *qh, const vec3 *points, uint32_t count, hull_loops *out)
{
    facetT *facet;
    size_t faces = 0, corners = 0;
    FORALLfacet_(qh->facet_list)
    {
        faces++;
        corners += (size_t)qh_setsize(qh, facet->vertices);
    }
    out->first = base_zalloc(faces + 1, sizeof *out->first);
    out->corners = base_alloc(corners + 1, sizeof *out->corners);
    reader r = {qh, points, base_zalloc(count, sizeof(link_pair)), out};
    bool good = true;
    FORALLfacet_(qh->facet_list)
    {
        good = good && read_facet(&r, facet);
    }
    free(r.links);
    return good;
}

static int run_qhull(qhT *qh, vec3 *points, uint32_t count, const char *options)
{
    char command[64], *messages = NULL;
    size_t size = 0;
    snprintf(command, sizeof command, "qhull Pp %s", options);
    FILE *sink = open_memstream(&messages, &size);
    if (!sink) return qh_ERRmem;
    qh_zero(qh, sink);
    int code = qh_new_qhull(qh, 3, (int)count, (coordT *)points, False, command, NULL, sink);
    fclose(sink);
    free(messages);
    return code;
}

bool hull_loops_find(const vec3 *points, uint32_t count, const char *options, hull_loops *out)
{
    memset(out, 0, sizeof *out);
    vec3 *own = base_alloc(count, sizeof *own); /* qhull takes them as its to change */
    memcpy(own, points, count * sizeof *own);
    qhT *qh = base_zalloc(1, sizeof *qh);
    bool good = run_qhull(qh, own, count, options) == 0 && read_facets(qh, (const vec3 *)qh->first_point, count, out);
    int long_bytes, long_blocks;
    qh_freeqhull(qh, !qh_ALL);
    qh_memfreeshort(qh, &long_bytes, &long_blocks);
    free(qh);
    free(own);
    if (!good) hull_loops_free(out);
    return good;
}

void hull_loops_free(hull_loops *loops)
{
    free(loops->first);
    free(loops->corners);
    memset(loops, 0, sizeof *loops);
}
