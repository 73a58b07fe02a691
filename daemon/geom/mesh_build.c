/* Building meshes: weld the vertices, look at the edges, leave out what others cover, build the hierarchy and the hull.
 * Any thread. Every step sorts by content and index, so the same input gives the same mesh. */
#include "mesh.h"

#include "base/array.h"
#include "mesh_steps.h"
#include "round.h"
#include "shape.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *mesh_status_text(mesh_status status)
{
    switch (status) {
    case MESH_OK:
        return "ok";
    case MESH_NO_TRIANGLES:
        return "mesh has no triangle with an area";
    case MESH_TOO_MANY:
        return "mesh has too many triangles";
    case MESH_BAD_INDEX:
        return "mesh has a triangle with a vertex that does not exist";
    case MESH_NOT_FINITE:
        return "mesh has a coordinate that is not finite or beyond the limit";
    case MESH_WIDE_HULL:
        return "the convex hull of the mesh could not be built: it may have too many corners";
    }
    return "unknown";
}

static mesh_status check_input(const double *points, size_t count, const int32_t *corners, size_t triangles)
{
    if (triangles == 0 || count == 0) return MESH_NO_TRIANGLES;
    if (triangles > MESH_TRIANGLES_MAX || count > 3 * (size_t)MESH_TRIANGLES_MAX) return MESH_TOO_MANY;
    for (size_t i = 0; i < 3 * count; i++)
        if (!(fabs(points[i]) <= SHAPE_SIZE_MAX)) return MESH_NOT_FINITE;
    for (size_t i = 0; i < 3 * triangles; i++)
        if (corners[i] < 0 || (size_t)corners[i] >= count) return MESH_BAD_INDEX;
    return MESH_OK;
}

/* ---- vertices ---- */

static vec3 mesh_input_point(const double *points, size_t i)
{
    return vec(points[3 * i] + 0.0, points[3 * i + 1] + 0.0, points[3 * i + 2] + 0.0); /* -0 becomes 0 */
}

static int compare_mesh_points(const void *left, const void *right, void *points)
{
    uint32_t i = *(const uint32_t *)left, j = *(const uint32_t *)right;
    vec3 a = mesh_input_point(points, i), b = mesh_input_point(points, j);
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    if (a.y != b.y) return a.y < b.y ? -1 : 1;
    if (a.z != b.z) return a.z < b.z ? -1 : 1;
    return (i > j) - (i < j);
}

/* first[i]: the first input point that equals point i. */
static uint32_t *first_of_equals(const double *points, uint32_t count)
{
    uint32_t *order = base_alloc(count, sizeof *order), *first = base_alloc(count, sizeof *first);
    for (uint32_t i = 0; i < count; i++) order[i] = i;
    qsort_r(order, count, sizeof *order, compare_mesh_points, (void *)points);
    for (uint32_t i = 0; i < count; i++) {
        bool again = i && vec_equal(mesh_input_point(points, order[i]), mesh_input_point(points, order[i - 1]));
        first[order[i]] = again ? first[order[i - 1]] : order[i];
    }
    free(order);
    return first;
}

/* ---- triangles ---- */

/* Its height is within the rounding of its longest side: it covers no more than its sides do. */
static bool has_no_area(vec3 a, vec3 b, vec3 c)
{
    vec3 sides[3] = {vec_sub(b, a), vec_sub(c, b), vec_sub(a, c)};
    double most = fmax(vec_max_abs(sides[0]), fmax(vec_max_abs(sides[1]), vec_max_abs(sides[2])));
    if (!(most > 0)) return true;
    vec3 u = vec(sides[0].x / most, sides[0].y / most, sides[0].z / most);
    vec3 v = vec(sides[2].x / most, sides[2].y / most, sides[2].z / most);
    return vec_norm(vec_cross(u, v)) <= 8 * ROUND_U;
}

/* The same three corners in the same sense begin with the same corner when the least comes first. */
static mesh_triangle least_first(mesh_triangle t)
{
    while (t.v[0] > t.v[1] || t.v[0] > t.v[2]) {
        uint32_t v = t.v[0];
        t.v[0] = t.v[1];
        t.v[1] = t.v[2];
        t.v[2] = v;
    }
    return t;
}

static int compare_triangles(const void *left, const void *right)
{
    const mesh_triangle *a = left, *b = right;
    for (int k = 0; k < 3; k++)
        if (a->v[k] != b->v[k]) return a->v[k] < b->v[k] ? -1 : 1;
    return (a->source > b->source) - (a->source < b->source);
}

static int compare_forms(const void *left, const void *right)
{
    const mesh_triangle *a = left, *b = right;
    if (a->form != b->form) return a->form < b->form ? -1 : 1;
    return (a->source > b->source) - (a->source < b->source);
}

/* A triangle with two equal corners: the lesser first, the other twice. */
static void fold(mesh_triangle *t)
{
    uint32_t lo = t->v[0], hi = t->v[0];
    for (int k = 1; k < 3; k++) {
        lo = t->v[k] < lo ? t->v[k] : lo;
        hi = t->v[k] > hi ? t->v[k] : hi;
    }
    t->v[0] = lo;
    t->v[1] = t->v[2] = hi;
    t->form = MESH_FOLDED;
}

static void take_triangles(mesh *m, const int32_t *corners, uint32_t count, const uint32_t *first)
{
    m->triangles = base_alloc(count, sizeof *m->triangles);
    m->triangle_count = count;
    for (uint32_t i = 0; i < count; i++) {
        mesh_triangle t = {.source = i, .form = MESH_AREA};
        for (int k = 0; k < 3; k++) t.v[k] = first[corners[3 * i + (uint32_t)k]];
        if (t.v[0] == t.v[1] || t.v[1] == t.v[2] || t.v[2] == t.v[0])
            fold(&t);
        else
            t = least_first(t);
        m->triangles[i] = t;
    }
}

static void drop_repeated(mesh *m)
{
    uint32_t kept = 0;
    qsort(m->triangles, m->triangle_count, sizeof *m->triangles, compare_triangles);
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        const mesh_triangle *t = &m->triangles[i], *last = kept ? &m->triangles[kept - 1] : NULL;
        bool again = last && last->v[0] == t->v[0] && last->v[1] == t->v[1] && last->v[2] == t->v[2];
        m->found.repeated += again;
        if (!again) m->triangles[kept++] = *t;
    }
    m->triangle_count = kept;
}

/* Numbers the vertices that triangles use, in the order of the input. */
static void take_vertices(mesh *m, const double *points, uint32_t count)
{
    uint32_t *place = base_alloc(count, sizeof *place), used = 0;
    memset(place, 0xff, count * sizeof *place);
    for (uint32_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) place[m->triangles[i].v[k]] = 0;
    for (uint32_t i = 0; i < count; i++)
        if (place[i] == 0) place[i] = used++;
    m->vertices = base_alloc(used + 1, sizeof *m->vertices);
    for (uint32_t i = 0; i < count; i++)
        if (place[i] != UINT32_MAX) m->vertices[place[i]] = mesh_input_point(points, i);
    for (uint32_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) m->triangles[i].v[k] = place[m->triangles[i].v[k]];
    m->vertex_count = used;
    m->found.welded = count - used;
    free(place);
}

/* ---- triangles without area ---- */

/* How many have one; in the order of their forms, and each form in that of the input. */
static uint32_t find_forms(mesh *m)
{
    uint32_t with_area = 0;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        mesh_triangle *t = &m->triangles[i];
        bool flat = has_no_area(mesh_corner(m, i, 0), mesh_corner(m, i, 1), mesh_corner(m, i, 2));
        if (flat && t->form == MESH_AREA) t->form = MESH_NEEDLE;
        with_area += t->form == MESH_AREA;
    }
    qsort(m->triangles, m->triangle_count, sizeof *m->triangles, compare_forms);
    return with_area;
}

/* What triangles that stay cover. */
typedef struct covered {
    bool *edges, *vertices;
} covered;

static void cover(const covered *c, const mesh_triangle *t, int side)
{
    c->edges[t->edge[side]] = true;
    for (int k = 0; k < 3; k++) c->vertices[t->v[k]] = true;
}

static int longest_side_of(const mesh *m, uint32_t triangle)
{
    int longest = 0;
    double length = -1;
    for (int k = 0; k < 3; k++) {
        vec3 side = vec_sub(mesh_corner(m, triangle, (k + 1) % 3), mesh_corner(m, triangle, k));
        double here = vec_norm(vec_scale(side, 1 / m->unit));
        if (here > length) length = here, longest = k;
    }
    return longest;
}

/* Of a seam only what is exactly on a line meets no ray (mesh_inside.c). */
static bool closes_solid(const mesh *m, uint32_t triangle)
{
    vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = vec_scale(mesh_corner(m, triangle, k), 1 / m->unit);
    return m->triangles[triangle].form == MESH_SEAM && !mesh_points_in_line(p[0], p[1], p[2]);
}

static bool is_covered(const covered *c, const mesh_triangle *t, int longest)
{
    if (t->v[0] == t->v[2]) return c->vertices[t->v[0]];
    if (c->edges[t->edge[longest]]) return true;
    return t->form != MESH_FOLDED && c->edges[t->edge[(longest + 1) % 3]] && c->edges[t->edge[(longest + 2) % 3]];
}

/* Leaves out those that others cover: a triangle whose corners lie on a line closes a gap between edges, but adds no
 * point of its own there. Points come last: what is a point of a segment is covered by it. */
static void leave_out_covered(mesh *m)
{
    uint32_t kept = 0, count = m->triangle_count;
    covered c = {base_zalloc(3 * (size_t)count, sizeof *c.edges), base_zalloc(m->vertex_count, sizeof *c.vertices)};
    for (int points = 0; points < 2; points++) {
        kept = 0;
        for (uint32_t i = 0; i < m->triangle_count; i++) {
            mesh_triangle *t = &m->triangles[i];
            bool point = t->v[0] == t->v[1] && t->v[1] == t->v[2], stays = true;
            if (t->form != MESH_AREA && point == (points == 1)) {
                int longest = longest_side_of(m, i);
                stays = closes_solid(m, i) || !is_covered(&c, t, longest);
                m->found.needles += stays;
                m->found.zero_area += !stays;
                if (stays) cover(&c, t, longest);
            }
            for (int k = 0; t->form == MESH_AREA && k < 3; k++) cover(&c, t, k);
            if (stays) m->triangles[kept++] = *t;
        }
        m->triangle_count = kept;
    }
    free(c.edges);
    free(c.vertices);
}

/* ---- hull ---- */

static uint32_t corners_of_hull(const hull *h, double *to)
{
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        vec3 v = hull_vertex(h, i);
        to[3 * i] = v.x;
        to[3 * i + 1] = v.y;
        to[3 * i + 2] = v.z;
    }
    return h->vertex_count;
}

/* One round of a hull of more points than hull_build takes: the corners of the hulls of its parts. */
static uint32_t thin_out(double *points, uint32_t count, double *excess)
{
    uint32_t kept = 0;
    double most = 0;
    for (uint32_t at = 0; at < count; at += HULL_VERTICES_MAX) {
        uint32_t part = count - at < HULL_VERTICES_MAX ? count - at : HULL_VERTICES_MAX;
        hull *h = NULL;
        if (hull_build(points + 3 * (size_t)at, part, HULL_ALLOW_FLAT, &h) != HULL_OK) return count;
        most = fmax(most, h->excess);
        kept += corners_of_hull(h, points + 3 * (size_t)kept); /* never ahead of what is still to be read */
        hull_destroy(h);
    }
    *excess = add_up(*excess, most);
    return kept;
}

static bool build_hull(mesh *m, const mesh_outline *outline)
{
    uint32_t count = outline ? outline->count : m->vertex_count, before = UINT32_MAX;
    double *points = base_alloc(3 * (size_t)count, sizeof *points), excess = outline ? outline->excess : 0;
    for (uint32_t i = 0; i < count; i++) {
        vec3 v = m->vertices[outline ? outline->vertices[i] : i];
        points[3 * i] = v.x;
        points[3 * i + 1] = v.y;
        points[3 * i + 2] = v.z;
    }
    while (count > HULL_VERTICES_MAX && count < before) {
        before = count;
        count = thin_out(points, count, &excess);
    }
    bool built = hull_build(points, count, HULL_ALLOW_FLAT, &m->hull) == HULL_OK;
    if (built) {
        m->hull->excess = add_up(m->hull->excess, excess);
        m->hull->reach = add_up(m->hull->reach, excess);
    }
    free(points);
    return built;
}

/* Of the unit, so that its inverse is a number: meshes may be of subnormal size. */
enum { LEAST_EXPONENT = -1020 };

static void measure(mesh *m)
{
    int exponent;
    for (uint32_t i = 0; i < m->vertex_count; i++) m->max_abs = fmax(m->max_abs, vec_max_abs(m->vertices[i]));
    (void)frexp(m->max_abs, &exponent);
    m->unit = ldexp(1, exponent > LEAST_EXPONENT ? exponent : LEAST_EXPONENT);
}

mesh_status mesh_build(const double *points, size_t count, const int32_t *corners, size_t triangles, mesh **out)
{
    return mesh_build_within(points, count, corners, triangles, NULL, out);
}

mesh_status mesh_build_within(const double *points, size_t count, const int32_t *corners, size_t triangles,
    const mesh_outline *outline, mesh **out)
{
    *out = NULL;
    mesh_status status = check_input(points, count, corners, triangles);
    if (status != MESH_OK) return status;
    mesh *m = base_zalloc(1, sizeof *m);
    uint32_t *first = first_of_equals(points, (uint32_t)count);
    take_triangles(m, corners, (uint32_t)triangles, first);
    free(first);
    drop_repeated(m);
    take_vertices(m, points, (uint32_t)count);
    measure(m);
    uint32_t with_area = find_forms(m);
    mesh_orient(m);
    if (with_area < m->triangle_count) leave_out_covered(m);
    if (with_area == 0)
        status = MESH_NO_TRIANGLES;
    else if (!build_hull(m, outline))
        status = MESH_WIDE_HULL;
    if (status != MESH_OK) {
        mesh_destroy(m);
        return status;
    }
    mesh_tree_build(m);
    mesh_components_build(m);
    mesh_pieces_build(m);
    *out = m;
    return MESH_OK;
}

void mesh_destroy(mesh *m)
{
    if (!m) return;
    mesh_pieces_destroy(m);
    hull_destroy(m->hull);
    free(m->vertices);
    free(m->triangles);
    free(m->corners);
    free(m->nodes);
    free(m->patch_points);
    free(m->components);
    free(m);
}

/* ---- words ---- */

typedef struct sentence {
    char *text;
    size_t size;
    int length;
} sentence;

static void say(sentence *s, const char *before, uint32_t count, const char *one, const char *many)
{
    if (!count) return;
    size_t used = (size_t)s->length < s->size ? (size_t)s->length : s->size;
    s->length += snprintf(s->text + used, s->size - used, "%s%u %s", before, count, count == 1 ? one : many);
}

int mesh_describe(const mesh *m, char *text, size_t size)
{
    const mesh_findings *f = &m->found;
    sentence s = {text, size, snprintf(text, size, m->solid ? "a solid" : "a surface, without an inside")};
    say(&s, ": ", f->open_edges, "edge is open", "edges are open");
    say(&s, ", ", f->torn_edges, "edge has its two triangles turned against each other",
        "edges have their two triangles turned against each other");
    say(&s, ", ", f->shared_edges, "edge has more than two triangles", "edges have more than two triangles");
    say(&s, "; turned to agree with their neighbours: ", f->turned, "triangle", "triangles");
    say(&s, "; normals pointed inward and were turned: ", f->inside_out ? m->triangle_count : 0, "triangle",
        "triangles");
    say(&s, "; left out: ", f->zero_area, "triangle without area", "triangles without area");
    say(&s, "; kept as segments or points: ", f->needles, "triangle without area", "triangles without area");
    say(&s, "; left out: ", f->repeated, "repeated triangle", "repeated triangles");
    say(&s, "; left out: ", f->welded, "vertex that is repeated or unused", "vertices that are repeated or unused");
    return s.length;
}
