/* Convex pieces of a solid mesh. Any thread; the same mesh has the same pieces.
 *
 * A piece is grown from a point inside: the triangles are taken in order of their distance from it, and each that still
 * reaches into the region gets a plane that cuts it off: its own where the point is behind that, else the plane
 * across the line to the nearest point of what reaches in (as Deits and Tedrake, "Computing large convex regions of
 * obstacle-free space", 2014). So an L has its two arms, each in full length, and a plate with a hole of n sides n
 * pieces, all of which reach across the plate: pieces overlap, and their union is the solid in such cases.
 *
 * Nothing is believed of the growing: each piece is held against all triangles afterwards. Those, clipped by the
 * planes of the piece moved inward by CLEARANCE, must vanish; then the piece, scaled about its centre by 1 - CLEARANCE
 * / r, r the distance of the centre from the nearest plane, meets no triangle, and as the centre is inside, so is all
 * of it. No point of the piece is moved by more than the piece's `slack` by that. */
#include "base/array.h"
#include "hull_support.h"
#include "mesh_steps.h"

#include <stdlib.h>

enum {
    PLANES_MAX = 96,
    CORNERS_MAX = 3 + PLANES_MAX, /* of a triangle that was clipped */
    TRIANGLES_MAX = 20000,        /* of a mesh that is not convex */
    GROWTH_MAX = 120000,          /* triangles looked at, for all pieces of a mesh together */
    SEEDS_MAX = 400,              /* points to grow from, and ... */
    CHORDS_MAX = 300000,          /* ... triangles that are asked for them */
    FAILURES_MAX = 6,             /* of growing without giving anything up: it is curved all over */
    FIRST_PLANES = 16,
    POINTS_MAX = 1600, /* of all pieces together */
    EDGES_MAX = 2600
};

/* In units of mesh.unit: lengths up to 1. */
static const double TOUCHING = 0x1p-34, CLEARANCE = 0x1p-36, SLACK_MAX = 0x1p-24, LEAST_RADIUS = 0x1p-12;

/* A share of the distance to each plane by which it is moved inward, so that one plane cuts off many triangles of a
 * curved surface. Tried one after the other. */
typedef struct attempt {
    double given_up;
    uint32_t planes; /* at most */
} attempt;
static const attempt ATTEMPTS[3] = {{0, PLANES_MAX}, {0.08, 24}, {0.2, 24}};

typedef struct region { /* dot(normal, x) <= offset */
    uint32_t count;
    vec3 normal[PLANES_MAX];
    double offset[PLANES_MAX];
} region;

typedef struct polygon {
    int count;
    vec3 at[CORNERS_MAX];
} polygon;

typedef struct near_triangle {
    double away2;
    uint32_t triangle;
} near_triangle;

typedef struct grower {
    mesh *m;
    double scale;  /* into units */
    vec3 *corners; /* three a triangle, in units */
    vec3 *normals; /* of triangles, unit */
    near_triangle *order;
    uint32_t looked_at, points, edges, failures;
} grower;

/* ---- points and triangles ---- */

static vec3 nearest_of_triangle(vec3 p, vec3 a, vec3 b, vec3 c)
{
    vec3 ab = vec_sub(b, a), ac = vec_sub(c, a), ap = vec_sub(p, a), bp = vec_sub(p, b), cp = vec_sub(p, c);
    double d1 = vec_dot(ab, ap), d2 = vec_dot(ac, ap), d3 = vec_dot(ab, bp), d4 = vec_dot(ac, bp);
    double d5 = vec_dot(ab, cp), d6 = vec_dot(ac, cp);
    if (d1 <= 0 && d2 <= 0) return a;
    if (d3 >= 0 && d4 <= d3) return b;
    if (d6 >= 0 && d5 <= d6) return c;
    double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return vec_madd(a, d1 / (d1 - d3), ab);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return vec_madd(a, d2 / (d2 - d6), ac);
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) return vec_madd(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), vec_sub(c, b));
    double whole = va + vb + vc;
    if (!(whole > 0)) return a;
    return vec_madd(vec_madd(a, vb / whole, ab), vc / whole, ac);
}

static vec3 nearest_of_polygon(const polygon *g, vec3 p)
{
    vec3 best = g->at[0];
    double least = vec_norm2(vec_sub(best, p));
    for (int i = 1; i + 1 < g->count || i == 1; i++) {
        vec3 b = g->at[i < g->count ? i : g->count - 1], c = g->at[i + 1 < g->count ? i + 1 : g->count - 1];
        vec3 at = nearest_of_triangle(p, g->at[0], b, c);
        double away2 = vec_norm2(vec_sub(at, p));
        if (away2 < least) least = away2, best = at;
    }
    return best;
}

/* Keeps what is at or below the plane. */
static void clip(polygon *g, vec3 normal, double offset)
{
    polygon out = {.count = 0};
    for (int i = 0; i < g->count; i++) {
        vec3 a = g->at[i], b = g->at[(i + 1) % g->count];
        double over_a = vec_dot(normal, a) - offset, over_b = vec_dot(normal, b) - offset;
        if (over_a <= 0) out.at[out.count++] = a;
        if ((over_a <= 0) != (over_b <= 0) && out.count < CORNERS_MAX)
            out.at[out.count++] = vec_madd(a, over_a / (over_a - over_b), vec_sub(b, a));
        if (out.count == CORNERS_MAX) break;
    }
    *g = out;
}

/* What of a triangle is in the region by more than `margin`; false: nothing. */
static bool reaches_in(const region *r, const vec3 *corner, double margin, polygon *left)
{
    for (uint32_t k = 0; k < r->count; k++) {
        double limit = r->offset[k] - margin;
        vec3 n = r->normal[k];
        if (vec_dot(n, corner[0]) > limit && vec_dot(n, corner[1]) > limit && vec_dot(n, corner[2]) > limit)
            return false;
    }
    *left = (polygon){.count = 3, .at = {corner[0], corner[1], corner[2]}};
    for (uint32_t k = 0; k < r->count && left->count; k++) clip(left, r->normal[k], r->offset[k] - margin);
    return left->count > 0;
}

/* ---- growing ---- */

static int compare_near(const void *left, const void *right)
{
    const near_triangle *a = left, *b = right;
    if (a->away2 != b->away2) return a->away2 < b->away2 ? -1 : 1;
    return (a->triangle > b->triangle) - (a->triangle < b->triangle);
}

static bool cut_off(const grower *w, region *r, vec3 from, uint32_t t, const polygon *left, const attempt *how)
{
    const vec3 *c = w->corners + 3 * (size_t)t;
    vec3 n = w->normals[t];
    double least = fmin(vec_dot(n, c[0]), fmin(vec_dot(n, c[1]), vec_dot(n, c[2]))), height = vec_dot(n, from);
    if (r->count == how->planes) return false;
    if (!(least - height > 0x1p-24)) { /* the point is not behind it */
        vec3 to = nearest_of_polygon(left, from);
        n = vec_unit(vec_sub(to, from));
        height = vec_dot(n, from);
        least = vec_dot(n, to);
        if (!(least - height > 0x1p-24)) return false;
    }
    r->normal[r->count] = n;
    r->offset[r->count++] = least - how->given_up * (least - height);
    return true;
}

/* Leaves out what the newest plane cuts off. */
static uint32_t thin_order(const grower *w, const region *r, uint32_t count)
{
    vec3 n = r->normal[r->count - 1];
    double limit = r->offset[r->count - 1] - TOUCHING;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        const vec3 *c = w->corners + 3 * (size_t)w->order[i].triangle;
        if (!(vec_dot(n, c[0]) > limit && vec_dot(n, c[1]) > limit && vec_dot(n, c[2]) > limit))
            w->order[kept++] = w->order[i];
    }
    return kept;
}

static bool grow(grower *w, vec3 from, const attempt *how, region *r)
{
    polygon left;
    uint32_t count = w->m->triangle_count;
    r->count = 0;
    w->looked_at += count;
    for (uint32_t t = 0; t < count; t++) {
        const vec3 *c = w->corners + 3 * (size_t)t;
        w->order[t] = (near_triangle){vec_norm2(vec_sub(nearest_of_triangle(from, c[0], c[1], c[2]), from)), t};
    }
    for (int k = 0; k < FIRST_PLANES && count; k++) { /* they cut off most; then the order of the rest is found */
        uint32_t nearest = 0;
        for (uint32_t i = 1; i < count; i++)
            if (compare_near(&w->order[i], &w->order[nearest]) < 0) nearest = i;
        uint32_t t = w->order[nearest].triangle;
        if (!reaches_in(r, w->corners + 3 * (size_t)t, TOUCHING, &left))
            w->order[nearest] = w->order[--count];
        else if (cut_off(w, r, from, t, &left, how))
            count = thin_order(w, r, count);
        else
            return false;
    }
    qsort(w->order, count, sizeof *w->order, compare_near);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t t = w->order[i].triangle;
        if (reaches_in(r, w->corners + 3 * (size_t)t, TOUCHING, &left) && !cut_off(w, r, from, t, &left, how))
            return false;
    }
    return true;
}

/* ---- from planes to corners ---- */

/* Where three planes meet. */
static bool common_point(const region *r, const uint32_t k[3], vec3 *out)
{
    vec3 yz = vec_cross(r->normal[k[1]], r->normal[k[2]]), zx = vec_cross(r->normal[k[2]], r->normal[k[0]]);
    vec3 xy = vec_cross(r->normal[k[0]], r->normal[k[1]]);
    double det = vec_dot(r->normal[k[0]], yz);
    if (!(fabs(det) > 0x1p-30)) return false;
    vec3 sum = vec_scale(yz, r->offset[k[0]] / det);
    *out = vec_madd(vec_madd(sum, r->offset[k[1]] / det, zx), r->offset[k[2]] / det, xy);
    return true;
}

/* Of the planes that meet in a corner (a face of the dual hull) the three that tell best where it is. */
static void sharpest_planes(const region *r, const uint32_t *planes, uint32_t count, uint32_t out[3])
{
    double most = -1;
    out[0] = out[1] = out[2] = planes[0];
    for (uint32_t i = 1; i < count; i++) {
        double sine = vec_norm2(vec_cross(r->normal[planes[0]], r->normal[planes[i]]));
        if (sine > most) most = sine, out[1] = planes[i];
    }
    most = -1;
    vec3 across = vec_cross(r->normal[out[0]], r->normal[out[1]]);
    for (uint32_t i = 1; i < count; i++) {
        double det = fabs(vec_dot(across, r->normal[planes[i]]));
        if (det > most) most = det, out[2] = planes[i];
    }
}

/* A corner of the mesh that is there but for rounding, or the point itself. */
static vec3 snapped_to_vertex(const grower *w, vec3 point)
{
    for (uint32_t i = 0; i < w->m->vertex_count; i++) {
        vec3 v = vec_scale(w->m->vertices[i], w->scale);
        if (vec_max_abs(vec_sub(v, point)) < 0x1p-30) return v;
    }
    return point;
}

/* The corners of a region are the faces of the hull of the dual points n / (offset - n . from). NULL: it has no end. */
static hull *hull_of_region(const grower *w, const region *r, vec3 from)
{
    double dual[3 * PLANES_MAX];
    uint32_t plane_of[PLANES_MAX];
    hull *d = NULL, *out = NULL;
    for (uint32_t i = 0; i < r->count; i++) {
        vec3 q = vec_scale(r->normal[i], 1 / (r->offset[i] - vec_dot(r->normal[i], from)));
        dual[3 * i] = q.x;
        dual[3 * i + 1] = q.y;
        dual[3 * i + 2] = q.z;
    }
    if (r->count < 4 || hull_build(dual, r->count, 0, &d) != HULL_OK) return NULL;
    for (uint32_t i = 0; i < d->vertex_count; i++) {
        uint32_t k = 0;
        while (k + 1 < r->count && (dual[3 * k] != d->x[i] || dual[3 * k + 1] != d->y[i] || dual[3 * k + 2] != d->z[i]))
            k++;
        plane_of[i] = k;
    }
    double *points = base_alloc(3 * (size_t)d->face_count, sizeof *points);
    bool closed = true;
    for (uint32_t f = 0; f < d->face_count && closed; f++) {
        const hull_face *face = &d->faces[f];
        uint32_t of_face[PLANES_MAX] = {0}, three[3];
        for (uint32_t i = 0; i < face->count; i++) of_face[i] = plane_of[d->face_vertices[face->first + i]];
        vec3 point = vec_madd(from, 1 / face->offset, face->normal);
        sharpest_planes(r, of_face, face->count, three);
        (void)common_point(r, three, &point);
        closed = face->offset > 0x1p-10 && vec_finite(point) && vec_max_abs(point) <= 2;
        point = vec_scale(snapped_to_vertex(w, point), w->m->unit);
        points[3 * f] = point.x;
        points[3 * f + 1] = point.y;
        points[3 * f + 2] = point.z;
    }
    if (closed && hull_build(points, d->face_count, 0, &out) != HULL_OK) out = NULL;
    free(points);
    hull_destroy(d);
    return out;
}

/* ---- proving ---- */

static vec3 centre_of(const hull *h, double scale)
{
    vec3 sum = VEC_ZERO;
    for (uint32_t i = 0; i < h->vertex_count; i++) sum = vec_madd(sum, scale / h->vertex_count, hull_vertex(h, i));
    return sum;
}

/* By how much points are moved that the hull is scaled about a point inside the mesh, so that its planes come inward by
 * `clearance`; INFINITY where that cannot be said. */
static double slack_for(const mesh *m, const hull *h, double clearance)
{
    double scale = 1 / m->unit, radius = INFINITY, reach = 0;
    vec3 centre = centre_of(h, scale);
    for (uint32_t f = 0; f < h->face_count; f++)
        radius = fmin(radius, h->faces[f].offset * scale - vec_dot(h->faces[f].normal, centre));
    for (uint32_t i = 0; i < h->vertex_count; i++)
        reach = fmax(reach, vec_norm(vec_sub(vec_scale(hull_vertex(h, i), scale), centre)));
    if (h->dimension < 3 || !(radius > LEAST_RADIUS) || !mesh_inside(m, vec_scale(centre, m->unit))) return INFINITY;
    double slack = 1.01 * clearance / radius * reach + h->excess * scale;
    return slack <= SLACK_MAX ? slack * m->unit : INFINITY;
}

static bool is_piece(const grower *w, const hull *h, double *slack)
{
    region r = {.count = h->face_count};
    polygon left;
    if (h->face_count > PLANES_MAX) return false;
    for (uint32_t f = 0; f < h->face_count; f++) {
        r.normal[f] = h->faces[f].normal;
        r.offset[f] = h->faces[f].offset * w->scale;
    }
    for (uint32_t t = 0; t < w->m->triangle_count; t++)
        if (reaches_in(&r, w->corners + 3 * (size_t)t, CLEARANCE, &left)) return false;
    *slack = slack_for(w->m, h, 2 * CLEARANCE);
    return *slack < INFINITY;
}

/* ---- which ---- */

static bool hull_holds(const hull *h, vec3 point, double scale, double margin)
{
    for (uint32_t f = 0; f < h->face_count; f++)
        if (vec_dot(h->faces[f].normal, point) > h->faces[f].offset * scale + margin) return false;
    return true;
}

static bool holds_hull(const hull *outer, const hull *inner, double scale)
{
    for (uint32_t i = 0; i < inner->vertex_count; i++)
        if (!hull_holds(outer, vec_scale(hull_vertex(inner, i), scale), scale, 0x1p-28)) return false;
    return true;
}

static bool is_held(const grower *w, vec3 point, double margin)
{
    for (uint32_t i = 0; i < w->m->piece_count; i++)
        if (hull_holds(w->m->pieces[i].hull, point, w->scale, margin)) return true;
    return false;
}

/* Takes the hull: beside the others, in place of those that it holds, or not at all. */
static void add_piece(grower *w, hull *h, double slack)
{
    mesh *m = w->m;
    uint32_t kept = 0;
    for (uint32_t i = 0; i < m->piece_count; i++)
        if (holds_hull(m->pieces[i].hull, h, w->scale)) {
            hull_destroy(h);
            return;
        }
    for (uint32_t i = 0; i < m->piece_count; i++) {
        if (holds_hull(h, m->pieces[i].hull, w->scale))
            hull_destroy(m->pieces[i].hull);
        else
            m->pieces[kept++] = m->pieces[i];
    }
    m->pieces[kept] = (mesh_piece){h, slack};
    m->piece_count = kept + 1;
    w->points = w->edges = 0;
    for (uint32_t i = 0; i <= kept; i++) {
        w->points += m->pieces[i].hull->vertex_count;
        w->edges += m->pieces[i].hull->edge_count;
    }
}

static bool is_done(const grower *w)
{
    return w->m->piece_count == MESH_PIECES_MAX || w->looked_at >= GROWTH_MAX || w->points >= POINTS_MAX ||
           w->edges >= EDGES_MAX;
}

static void grow_piece(grower *w, vec3 from)
{
    region r;
    double slack;
    for (int k = w->failures < FAILURES_MAX ? 0 : 1; k < 3 && !is_done(w); k++) {
        hull *h = grow(w, from, &ATTEMPTS[k], &r) ? hull_of_region(w, &r, from) : NULL;
        if (k == 0) w->failures += !h;
        if (h && is_piece(w, h, &slack)) {
            add_piece(w, h, slack);
            return;
        }
        hull_destroy(h);
    }
}

/* How far a line into the solid is inside. */
static double length_inside(const grower *w, vec3 from, vec3 way, uint32_t self)
{
    double least = INFINITY;
    for (uint32_t t = 0; t < w->m->triangle_count; t++) {
        const vec3 *c = w->corners + 3 * (size_t)t;
        vec3 u = vec_sub(c[1], c[0]), v = vec_sub(c[2], c[0]), across = vec_cross(way, v), to = vec_sub(from, c[0]);
        double det = vec_dot(u, across);
        if (t == self || !(fabs(det) > 0)) continue;
        double x = vec_dot(to, across) / det, y, far;
        vec3 q = vec_cross(to, u);
        y = vec_dot(way, q) / det;
        far = vec_dot(v, q) / det;
        if (x >= -1e-9 && y >= -1e-9 && x + y <= 1 + 1e-9 && far > 1e-9) least = fmin(least, far);
    }
    return least;
}

/* First from the middle of the solid behind each triangle, then from close behind those that no piece has on its
 * surface. */
static void grow_pieces(grower *w)
{
    uint32_t count = w->m->triangle_count, seeds = CHORDS_MAX / count < SEEDS_MAX ? CHORDS_MAX / count : SEEDS_MAX;
    uint32_t step = count > seeds ? (count + seeds - 1) / seeds : 1;
    for (int close = 0; close < 2; close++)
        for (uint32_t t = 0; t < count && !is_done(w); t += step) {
            const vec3 *c = w->corners + 3 * (size_t)t;
            vec3 middle = vec_scale(vec_add(vec_add(c[0], c[1]), c[2]), 1.0 / 3), in = vec_neg(w->normals[t]);
            if (close && is_held(w, middle, TOUCHING)) continue;
            double far = length_inside(w, middle, in, t);
            vec3 from = vec_madd(middle, (close ? 0.05 : 0.5) * far, in);
            if (!(far < INFINITY) || is_held(w, from, close ? -INFINITY : -TOUCHING)) continue;
            grow_piece(w, from);
        }
}

static bool is_filled(const grower *w)
{
    for (uint32_t t = 0; t < w->m->triangle_count; t++) {
        const vec3 *c = w->corners + 3 * (size_t)t;
        if (!is_held(w, vec_scale(vec_add(vec_add(c[0], c[1]), c[2]), 1.0 / 3), TOUCHING)) return false;
    }
    return true;
}

/* ---- convex meshes ---- */

/* How far the farthest triangle is below the hull, seen along its own normal; in units. */
static double dent(const grower *w)
{
    double most = 0;
    uint32_t hint = HULL_NO_START;
    for (uint32_t t = 0; t < w->m->triangle_count && most <= TOUCHING; t++) {
        const vec3 *c = w->corners + 3 * (size_t)t;
        vec3 n = w->normals[t];
        hint = hull_support(w->m->hull, n, hint);
        double top = vec_dot(n, hull_vertex(w->m->hull, hint)) * w->scale;
        most = fmax(most, top - fmin(vec_dot(n, c[0]), fmin(vec_dot(n, c[1]), vec_dot(n, c[2]))));
    }
    return most;
}

/* No triangle reaches into the hull by more than rounding: so the hull is the solid. */
static bool is_convex(const grower *w, double *slack)
{
    double deep = dent(w);
    if (!(deep <= TOUCHING)) return false;
    *slack = slack_for(w->m, w->m->hull, deep + CLEARANCE);
    return *slack < INFINITY;
}

void mesh_pieces_build(mesh *m)
{
    double slack = 0;
    if (!m->solid || m->hull->dimension < 3) return;
    grower w = {.m = m, .scale = 1 / m->unit};
    w.corners = base_alloc(3 * (size_t)m->triangle_count, sizeof *w.corners);
    w.normals = base_alloc(m->triangle_count, sizeof *w.normals);
    w.order = base_alloc(m->triangle_count, sizeof *w.order);
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        vec3 *c = w.corners + 3 * (size_t)t;
        for (int k = 0; k < 3; k++) c[k] = vec_scale(mesh_corner(m, t, k), w.scale);
        w.normals[t] = vec_unit(vec_cross(vec_sub(c[1], c[0]), vec_sub(c[2], c[0])));
    }
    m->convex = is_convex(&w, &slack);
    m->filled = m->convex;
    m->pieces = base_zalloc(m->convex ? 1 : MESH_PIECES_MAX, sizeof *m->pieces);
    if (m->convex) {
        m->pieces[0] = (mesh_piece){m->hull, slack};
        m->piece_count = 1;
    } else if (m->triangle_count <= TRIANGLES_MAX) {
        grow_pieces(&w);
        m->filled = is_filled(&w);
    }
    free(w.corners);
    free(w.normals);
    free(w.order);
}

void mesh_pieces_destroy(mesh *m)
{
    for (uint32_t i = 0; i < m->piece_count; i++)
        if (!m->convex) hull_destroy(m->pieces[i].hull);
    free(m->pieces);
}
