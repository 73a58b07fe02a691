/* piece: polygons cut by planes along the axes, and the hull of what is left (quickhull.h). */
#include "piece.h"

#include "quickhull.h"
#include "solid_tree.h"
#include "vec3.h"

#include <libqhull_r/qhull_ra.h>
#include <stdio.h>
#include <stdlib.h>

void piece_free(piece *p)
{
    pool_free(&p->memory);
}

/* ---- hulls ---- */

static void take_planes(void *context, void *qhull)
{
    piece *p = context;
    qhT *qh = qhull;
    p->planes = pool_alloc(&p->memory, (size_t)qh->num_facets, sizeof *p->planes);
    qh_getarea(qh, qh->facet_list);
    p->volume = qh->totvol;
    facetT *facet;
    FORALLfacet_(qh->facet_list)
    {
        piece_plane *out = &p->planes[p->plane_count++];
        memcpy(out->normal, facet->normal, sizeof out->normal);
        out->offset = -INFINITY;
        for (size_t i = 0; i < p->point_count; i++)
            out->offset = fmax(out->offset, dot3(out->normal, p->points + 3 * i));
    }
}

static bool find_planes(piece *p)
{
    return quickhull_run(&p->memory, p->points, p->point_count, "qhull Pp", take_planes, p) && p->plane_count >= 4;
}

/* Points that are inside of the hull by more than rounding are not needed. */
static void drop_inner_points(piece *p)
{
    double deep = 1e-9 * distance3(p->lo, p->hi);
    size_t kept = 0;
    for (size_t i = 0; i < p->point_count; i++) {
        bool outer = false;
        for (size_t k = 0; !outer && k < p->plane_count; k++)
            outer = dot3(p->planes[k].normal, p->points + 3 * i) > p->planes[k].offset - deep;
        if (outer) memmove(p->points + 3 * kept++, p->points + 3 * i, 3 * sizeof *p->points);
    }
    p->point_count = kept;
}

static bool make_hull(piece *p)
{
    p->point_count = quickhull_sort(p->points, p->point_count);
    box_empty(p->lo, p->hi);
    for (size_t i = 0; i < p->point_count; i++) box_add(p->lo, p->hi, p->points + 3 * i);
    if (!find_planes(p)) return false;
    drop_inner_points(p);
    return true;
}

/* ---- cells ---- */

static void add_piece_corner(piece *out, const double at[3])
{
    memcpy(out->corners + 3 * out->corner_count++, at, 3 * sizeof *at);
}

static void crossing(const double a[3], const double b[3], int axis, double at, double out[3])
{
    double t = (at - a[axis]) / (b[axis] - a[axis]);
    for (int k = 0; k < 3; k++) out[k] = a[k] + t * (b[k] - a[k]);
    out[axis] = at;
}

/* Sutherland and Hodgman, "Reentrant polygon clipping", 1974. */
static void cut_polygon(const double *corners, size_t count, int axis, double at, double sign, piece *out)
{
    size_t before = out->corner_count;
    for (size_t i = 0; i < count; i++) {
        const double *a = corners + 3 * i, *b = corners + 3 * ((i + 1) % count);
        double from = sign * (a[axis] - at), to = sign * (b[axis] - at), cross[3];
        if (from >= 0) add_piece_corner(out, a);
        if ((from > 0 && to < 0) || (from < 0 && to > 0)) {
            crossing(a, b, axis, at, cross);
            add_piece_corner(out, cross);
        }
    }
    if (out->corner_count > before) out->ends[out->polygon_count++] = (uint32_t)out->corner_count;
}

static bool holds(const solid *s, const double x[3])
{
    return solid_side(s, x) != SOLID_OUTSIDE;
}

/* The hull of the cut triangles and of those corners of the cell that are inside; the cell shrinks to it. */
static bool finish_cell(const solid *s, piece *p)
{
    p->points = pool_alloc(&p->memory, p->corner_count + 8, 3 * sizeof *p->points);
    memcpy(p->points, p->corners, 3 * p->corner_count * sizeof *p->points);
    p->point_count = p->corner_count;
    for (int i = 0; i < 8; i++) {
        double x[3];
        for (int k = 0; k < 3; k++) x[k] = i >> k & 1 ? p->hi[k] : p->lo[k];
        if (holds(s, x)) memcpy(p->points + 3 * p->point_count++, x, sizeof x);
    }
    return make_hull(p);
}

bool piece_of_all(const solid *s, piece *out)
{
    *out = (piece){0};
    out->corner_count = 3 * s->count;
    out->polygon_count = s->count;
    out->corners = pool_alloc(&out->memory, out->corner_count, 3 * sizeof *out->corners);
    out->ends = pool_alloc(&out->memory, s->count, sizeof *out->ends);
    out->points = pool_alloc(&out->memory, out->corner_count, 3 * sizeof *out->points);
    for (size_t i = 0; i < s->count; i++) {
        memcpy(out->corners + 9 * i, s->triangles[i].at, sizeof s->triangles[i].at);
        out->ends[i] = (uint32_t)(3 * (i + 1));
    }
    memcpy(out->points, out->corners, 3 * out->corner_count * sizeof *out->points);
    out->point_count = out->corner_count;
    return make_hull(out);
}

bool piece_cut(const solid *s, const piece *from, int axis, double at, bool above, piece *out)
{
    double slack = piece_slack(s), sign = above ? 1 : -1;
    *out = (piece){0};
    memcpy(out->lo, from->lo, sizeof out->lo);
    memcpy(out->hi, from->hi, sizeof out->hi);
    (above ? out->lo : out->hi)[axis] = at;
    out->corners = pool_alloc(&out->memory, 2 * from->corner_count, 3 * sizeof *out->corners);
    out->ends = pool_alloc(&out->memory, from->polygon_count, sizeof *out->ends);
    for (size_t i = 0, first = 0; i < from->polygon_count; first = from->ends[i++])
        cut_polygon(from->corners + 3 * first, from->ends[i] - first, axis, at - sign * slack, sign, out);
    return finish_cell(s, out);
}

bool piece_unite(const piece *a, const piece *b, piece *out)
{
    *out = (piece){0};
    out->point_count = a->point_count + b->point_count;
    out->points = pool_alloc(&out->memory, out->point_count, 3 * sizeof *out->points);
    memcpy(out->points, a->points, 3 * a->point_count * sizeof *a->points);
    memcpy(out->points + 3 * a->point_count, b->points, 3 * b->point_count * sizeof *b->points);
    return make_hull(out);
}
