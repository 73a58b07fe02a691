/* fit_hull: the hull that qhull finds (quickhull.h), and the check of what it says. */
#include "fit_hull.h"

#include "fit_gap.h"
#include "loaders/decompose/quickhull.h"
#include "loaders/decompose/vec3.h"

#include <libqhull_r/qhull_ra.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct answer {
    fit_hull *hull;
    pool *pool;
} answer;

static void take_facets(void *context, void *qhull)
{
    fit_hull *h = ((answer *)context)->hull;
    pool *p = ((answer *)context)->pool;
    qhT *qh = qhull;
    h->planes = pool_alloc(p, (size_t)qh->num_facets, sizeof *h->planes);
    h->corners = pool_alloc(p, (size_t)qh->num_facets, sizeof *h->corners);
    qh_getarea(qh, qh->facet_list);
    h->volume = qh->totvol;
    facetT *facet;
    vertexT *vertex, **vertexp;
    FORALLfacet_(qh->facet_list)
    {
        int corner = 0;
        if (!facet->simplicial) return; /* seen by the check: the surface does not close */
        int32_t *to = h->corners[h->plane_count];
        FOREACHvertex_(facet->vertices) to[corner++] = qh_pointid(qh, vertex->point);
        memcpy(h->planes[h->plane_count++].normal, facet->normal, 3 * sizeof(double));
    }
}

static bool find_facets(pool *p, fit_hull *h)
{
    return quickhull_run(p, h->points, h->count, "qhull Qt Pp", take_facets, &(answer){h, p});
}

/* Turns the corners outward, and moves each plane so that no point is above it. False if its corners are below it. */
static bool settle_planes(fit_hull *h)
{
    for (size_t i = 0; i < h->plane_count; i++) {
        piece_plane *plane = &h->planes[i];
        int32_t *c = h->corners[i];
        double u[3], v[3], n[3];
        sub3(h->points + 3 * c[1], h->points + 3 * c[0], u);
        sub3(h->points + 3 * c[2], h->points + 3 * c[0], v);
        cross3(u, v, n);
        if (dot3(n, plane->normal) < 0) {
            int32_t second = c[1];
            c[1] = c[2];
            c[2] = second;
        }
        plane->offset = -INFINITY;
        for (size_t k = 0; k < h->count; k++)
            plane->offset = fmax(plane->offset, dot3(plane->normal, h->points + 3 * k));
        for (int k = 0; k < 3; k++)
            if (dot3(plane->normal, h->points + 3 * c[k]) < plane->offset - h->slack) return false;
    }
    return true;
}

typedef struct edge {
    int32_t from, to;
} edge;

static int compare_hull_edges(const void *left, const void *right)
{
    const edge *a = left, *b = right;
    return a->from != b->from ? (a->from < b->from ? -1 : 1) : (a->to > b->to) - (a->to < b->to);
}

/* Each edge once, and its way back once. */
static bool is_closed(const fit_hull *h)
{
    pool work = {0};
    size_t count = 3 * h->plane_count;
    edge *edges = pool_alloc(&work, count, sizeof *edges);
    for (size_t i = 0; i < count; i++) edges[i] = (edge){h->corners[i / 3][i % 3], h->corners[i / 3][(i + 1) % 3]};
    qsort(edges, count, sizeof *edges, compare_hull_edges);
    bool closed = count >= 12;
    for (size_t i = 0; closed && i < count; i++) {
        edge back = {edges[i].to, edges[i].from};
        closed = (i == 0 || compare_hull_edges(&edges[i - 1], &edges[i]) != 0) &&
                 bsearch(&back, edges, count, sizeof *edges, compare_hull_edges);
    }
    pool_free(&work);
    return closed;
}

/* Keeps only the points that are corners of facets. */
static void drop_unused_points(pool *p, fit_hull *h)
{
    int32_t *place = pool_alloc(p, h->count, sizeof *place);
    for (size_t i = 0; i < 3 * h->plane_count; i++) place[h->corners[i / 3][i % 3]] = 1;
    size_t kept = 0;
    for (size_t i = 0; i < h->count; i++) {
        if (!place[i]) continue;
        memmove(h->points + 3 * kept, h->points + 3 * i, 3 * sizeof *h->points);
        place[i] = (int32_t)kept++;
    }
    h->count = kept;
    for (size_t i = 0; i < 3 * h->plane_count; i++) h->corners[i / 3][i % 3] = place[h->corners[i / 3][i % 3]];
}

/* Eigenvectors of a symmetric matrix by Jacobi's rotations, as rows of `axes`; m is used up. */
static void eigenvectors(double m[3][3], double axes[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) axes[i][k] = i == k;
    for (int sweep = 0; sweep < 24; sweep++) {
        int p = sweep % 3, q = (sweep + 1) % 3;
        if (m[p][q] == 0) continue;
        double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)), c = 1 / sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; k++) {
            double a = m[k][p], b = m[k][q];
            m[k][p] = c * a - s * b, m[k][q] = s * a + c * b;
        }
        for (int k = 0; k < 3; k++) {
            double a = m[p][k], b = m[q][k];
            m[p][k] = c * a - s * b, m[q][k] = s * a + c * b;
            a = axes[p][k], b = axes[q][k];
            axes[p][k] = c * a - s * b, axes[q][k] = s * a + c * b;
        }
    }
}

/* Principal axes of the surface: of the facets' centres, each weighted by its area. */
static void find_axes(fit_hull *h)
{
    double sum = 0, mean[3] = {0, 0, 0}, m[3][3] = {{0}}, axes[3][3];
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < h->plane_count; i++) {
            const double *a = h->points + 3 * h->corners[i][0], *b = h->points + 3 * h->corners[i][1],
                         *c = h->points + 3 * h->corners[i][2];
            double u[3], v[3], n[3], at[3];
            sub3(b, a, u);
            sub3(c, a, v);
            cross3(u, v, n);
            double area = norm3(n);
            for (int k = 0; k < 3; k++) at[k] = (a[k] + b[k] + c[k]) / 3 - (pass ? mean[k] : 0);
            sum += pass ? 0 : area;
            for (int k = 0; k < 3 && !pass; k++) mean[k] += area * at[k];
            for (int k = 0; k < 9 && pass; k++) m[k / 3][k % 3] += area * at[k / 3] * at[k % 3];
        }
        for (int k = 0; k < 3 && !pass; k++) mean[k] /= sum;
    }
    eigenvectors(m, axes);
    int order[3] = {0, 1, 2};
    for (int i = 0; i < 3; i++)
        for (int k = i + 1; k < 3; k++)
            if (m[order[k]][order[k]] > m[order[i]][order[i]]) {
                int other = order[i];
                order[i] = order[k];
                order[k] = other;
            }
    for (int i = 0; i < 3; i++) memcpy(h->axes[i], axes[order[i]], sizeof axes[i]);
    cross3(h->axes[0], h->axes[1], h->axes[2]); /* right-handed */
}

bool fit_hull_make(pool *p, const double *points, size_t count, fit_hull *out)
{
    *out = (fit_hull){0};
    out->points = pool_alloc(p, count, 3 * sizeof *points);
    memcpy(out->points, points, 3 * count * sizeof *points);
    out->count = quickhull_sort(out->points, count);
    box_empty(out->lo, out->hi);
    for (size_t i = 0; i < out->count; i++) box_add(out->lo, out->hi, out->points + 3 * i);
    for (int k = 0; k < 3; k++) {
        out->most = fmax(out->most, fmax(fabs(out->lo[k]), fabs(out->hi[k])));
        out->centre[k] = (out->lo[k] + out->hi[k]) / 2;
    }
    out->slack = 0x1p-36 * out->most;
    if (!find_facets(p, out) || !settle_planes(out) || !is_closed(out)) return false;
    drop_unused_points(p, out);
    find_axes(out);
    return true;
}

double fit_hull_away(const fit_hull *h, const double x[3])
{
    double highest = -INFINITY;
    for (size_t i = 0; i < h->plane_count; i++) {
        double height = dot3(h->planes[i].normal, x) - h->planes[i].offset;
        highest = height > highest ? height : highest;
    }
    if (highest <= 0) return highest + 2 * h->slack;
    fit_gap gap;
    const double start[3] = {x[0] - h->centre[0], x[1] - h->centre[1], x[2] - h->centre[2]};
    double most = fmax(h->most, fmax(fabs(x[0]), fmax(fabs(x[1]), fabs(x[2]))));
    fit_gap_find((fit_cloud){x, 1, most}, fit_hull_cloud(h), start, h->slack, INFINITY, &gap);
    return gap.hi + 2 * h->slack;
}
