/* solid_make: which corners are one point, whether the surface is closed, at which
 * edges it is not convex. */
#include "solid_make.h"

#include "overhang.h"
#include "solid_tree.h"
#include "vec3.h"

#include <stdlib.h>

typedef struct half_edge {
    int32_t low, high; /* points, low < high */
    int way;           /* 1: from low to high; -1: back */
    uint32_t triangle;
} half_edge;

typedef struct making {
    pool *work;
    const mesh_triangles *mesh;
    int32_t (*corners)[3]; /* of the triangles that are kept, as united points */
    size_t count;
    solid *out;
} making;

static int compare_solid_points(const void *left, const void *right, void *points)
{
    const double *a = (const double *)points + 3 * *(const int32_t *)left;
    const double *b = (const double *)points + 3 * *(const int32_t *)right;
    for (int k = 0; k < 3; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return *(const int32_t *)left - *(const int32_t *)right;
}

/* For each point the first one at the same place. */
static int32_t *unite_points(making *m)
{
    size_t n = m->mesh->point_count;
    const double *at = m->mesh->points;
    int32_t *order = pool_alloc(m->work, n, sizeof *order), *same = pool_alloc(m->work, n, sizeof *same);
    for (size_t i = 0; i < n; i++) order[i] = (int32_t)i;
    qsort_r(order, n, sizeof *order, compare_solid_points, (void *)at);
    for (size_t i = 0; i < n; i++) {
        const double *here = at + 3 * order[i], *before = i ? at + 3 * order[i - 1] : NULL;
        bool repeats = before && here[0] == before[0] && here[1] == before[1] && here[2] == before[2];
        same[order[i]] = repeats ? same[order[i - 1]] : order[i];
        m->out->united += repeats;
    }
    return same;
}

static int compare_edge_ends(const void *left, const void *right)
{
    const int32_t *a = left, *b = right;
    return a[0] != b[0] ? (a[0] > b[0]) - (a[0] < b[0]) : (a[1] > b[1]) - (a[1] < b[1]);
}

static void keep_triangle(making *m, int32_t a, int32_t b, int32_t c)
{
    m->corners[m->count][0] = a, m->corners[m->count][1] = b, m->corners[m->count++][2] = c;
}

/* Of those with two corners in one place, or three: the segments and points that no other triangle has for a side or a
 * corner. They add an edge and take it away again: closed stays closed. `folded`: their ends, the lesser first. */
static void keep_folded(making *m, int32_t (*folded)[2], size_t count)
{
    size_t sides = 3 * m->count, whole = m->count;
    int32_t(*known)[2] = pool_alloc(m->work, sides + 1, sizeof *known);
    bool *corner = pool_alloc(m->work, m->mesh->point_count, sizeof *corner);
    for (size_t i = 0; i < sides; i++) {
        int32_t a = m->corners[i / 3][i % 3], b = m->corners[i / 3][(i + 1) % 3];
        known[i][0] = a < b ? a : b, known[i][1] = a < b ? b : a;
        corner[a] = true;
    }
    qsort(known, sides, sizeof *known, compare_edge_ends);
    qsort(folded, count, sizeof *folded, compare_edge_ends);
    for (int points = 0; points < 2; points++) /* what is a point of a segment is covered by it */
        for (size_t i = 0; i < count; i++) {
            int32_t a = folded[i][0], b = folded[i][1];
            if ((a == b) != (points == 1)) continue;
            bool again = i > 0 && compare_edge_ends(folded[i], folded[i - 1]) == 0;
            bool covered =
                points ? corner[a] : bsearch(folded[i], known, sides, sizeof *known, compare_edge_ends) != NULL;
            if (again || covered) continue;
            keep_triangle(m, a, b, b);
            corner[a] = corner[b] = true;
        }
    m->out->dropped = count - (m->count - whole);
}

static void keep_triangles(making *m)
{
    const int32_t *same = unite_points(m);
    size_t count = 0;
    int32_t(*folded)[2] = pool_alloc(m->work, m->mesh->count, sizeof *folded);
    m->corners = pool_alloc(m->work, m->mesh->count, sizeof *m->corners);
    for (size_t i = 0; i < m->mesh->count; i++) {
        const int32_t *c = m->mesh->corners + 3 * i;
        int32_t a = same[c[0]], b = same[c[1]], d = same[c[2]];
        if (a == b || b == d || d == a) {
            int32_t other = a == b ? d : b; /* than a, if there is one */
            folded[count][0] = a < other ? a : other, folded[count++][1] = a < other ? other : a;
            continue;
        }
        keep_triangle(m, a, b, d);
    }
    keep_folded(m, folded, count);
}

static double signed_volume(const making *m)
{
    double six = 0;
    for (size_t i = 0; i < m->count; i++) {
        double e[3][3], n[3];
        for (int k = 0; k < 3; k++) sub3(m->mesh->points + 3 * m->corners[i][k], m->out->lo, e[k]);
        cross3(e[1], e[2], n);
        six += dot3(e[0], n);
    }
    return six;
}

static void fill_triangles(making *m)
{
    solid *s = m->out;
    box_empty(s->lo, s->hi);
    for (size_t i = 0; i < m->count; i++)
        for (int k = 0; k < 3; k++) box_add(s->lo, s->hi, m->mesh->points + 3 * m->corners[i][k]);
    s->diagonal = distance3(s->lo, s->hi);
    for (int k = 0; k < 3; k++) s->most = fmax(s->most, fmax(fabs(s->lo[k]), fabs(s->hi[k])));
    double turn = signed_volume(m) < 0 ? -1 : 1;
    for (size_t i = 0; i < m->count; i++) {
        solid_triangle *t = &s->triangles[i];
        double u[3], v[3];
        for (int k = 0; k < 3; k++) memcpy(t->at[k], m->mesh->points + 3 * m->corners[i][k], sizeof t->at[k]);
        sub3(t->at[1], t->at[0], u);
        sub3(t->at[2], t->at[0], v);
        cross3(u, v, t->normal);
        double area = norm3(t->normal);
        bool sound = area > 1e-9 * norm3(u) * norm3(v);
        for (int k = 0; k < 3; k++) t->normal[k] = sound ? turn * t->normal[k] / area : 0;
    }
}

static int by_points(const void *left, const void *right)
{
    const half_edge *a = left, *b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static half_edge *sorted_edges(const making *m, size_t *total)
{
    half_edge *edges = pool_alloc(m->work, 3 * m->count, sizeof *edges), *e = edges;
    for (uint32_t i = 0; i < m->count; i++)
        for (int k = 0; k < 3; k++) {
            int32_t from = m->corners[i][k], to = m->corners[i][(k + 1) % 3];
            if (from == to) continue;
            *e++ = from < to ? (half_edge){from, to, 1, i} : (half_edge){to, from, -1, i};
        }
    *total = (size_t)(e - edges);
    qsort(edges, *total, sizeof *edges, by_points);
    return edges;
}

/* How far beyond the other's plane a corner may be to count as in it: sine of the angle. */
static const double FLAT = 1e-9;

/* Convex or flat: both triangles have a normal, and no corner of either is above the plane of the other. */
static bool edge_is_convex(const making *m, const half_edge *e, size_t count)
{
    if (count != 2 || e[0].way + e[1].way != 0) return false;
    for (int i = 0; i < 2; i++) {
        const solid_triangle *here = &m->out->triangles[e[i].triangle], *there = &m->out->triangles[e[!i].triangle];
        if (dot3(here->normal, here->normal) == 0) return false;
        for (int k = 0; k < 3; k++) {
            double way[3];
            sub3(there->at[k], here->at[0], way);
            if (dot3(here->normal, way) > FLAT * distance3(there->at[0], there->at[1])) return false;
        }
        if (dot3(here->normal, there->normal) < -0.99) return false;
    }
    return true;
}

static void add_reflex(making *m, const half_edge *e, bool *bent)
{
    solid_edge *out = &m->out->reflex[m->out->reflex_count++];
    box_empty(out->lo, out->hi);
    box_add(out->lo, out->hi, m->mesh->points + 3 * e->low);
    box_add(out->lo, out->hi, m->mesh->points + 3 * e->high);
    bent[e->low] = bent[e->high] = true;
}

static void study_edges(making *m, pool *p)
{
    size_t total;
    half_edge *edges = sorted_edges(m, &total);
    bool *bent = pool_alloc(m->work, m->mesh->point_count, sizeof *bent);
    m->out->closed = m->count > 0;
    m->out->reflex = pool_alloc(p, 3 * m->count, sizeof *m->out->reflex);
    for (size_t i = 0, end; i < total; i = end) {
        int balance = 0;
        for (end = i; end < total && edges[end].low == edges[i].low && edges[end].high == edges[i].high; end++)
            balance += edges[end].way;
        if (balance != 0) m->out->closed = false;
        if (!edge_is_convex(m, &edges[i], end - i)) add_reflex(m, &edges[i], bent);
    }
    for (size_t i = 0; i < m->count; i++)
        for (int k = 0; k < 3; k++) m->out->triangles[i].bent |= bent[m->corners[i][k]];
}

/* A triangle of a part that is turned inside out against the rest has the solid before it, not behind it. */
static void find_backs(solid *s)
{
    for (size_t i = 0; s->closed && i < s->count; i++) {
        solid_triangle *t = &s->triangles[i];
        double behind[3];
        for (int k = 0; k < 3; k++) behind[k] = (t->at[0][k] + t->at[1][k] + t->at[2][k]) / 3;
        along3(behind, -0x1p-24 * s->diagonal, t->normal, behind);
        t->backed = dot3(t->normal, t->normal) > 0 && solid_side(s, behind) == SOLID_INSIDE;
        t->bent = t->bent || !t->backed;
    }
}

void solid_make(pool *p, const mesh_triangles *mesh, solid *out)
{
    pool work = {0};
    *out = (solid){0};
    making m = {.work = &work, .mesh = mesh, .out = out};
    keep_triangles(&m);
    out->count = m.count;
    out->triangles = pool_alloc(p, m.count, sizeof *out->triangles);
    fill_triangles(&m);
    study_edges(&m, p);
    solid_tree_make(p, out);
    find_backs(out);
    out->overhang = overhang_make(p, out);
    pool_free(&work);
}
