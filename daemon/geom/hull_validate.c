/* The whole-structure check of a hull: what every other file takes for granted about one. Pure; any thread. Made for
 * tests: its time grows with faces times vertices. Each check names the first fault that it finds.
 *
 * It holds for hulls of any size, so squares and quotients are only made of numbers that a power of two has brought to
 * about 1: of one that was subnormal, no bit is lost. */
#include "hull.h"

#include "base/array.h"
#include "round.h"

#include <stdlib.h>

static vec3 times_power(vec3 v, int exponent)
{
    return vec(ldexp(v.x, exponent), ldexp(v.y, exponent), ldexp(v.z, exponent));
}

/* The power of two that is the least above `size`. */
static int exponent_of(double size)
{
    int exponent;
    (void)frexp(size, &exponent);
    return exponent;
}

static bool is_within_reach(const hull *h, vec3 v)
{
    int exponent = exponent_of(h->reach);
    return vec_norm(times_power(v, -exponent)) <= ldexp(h->reach, -exponent);
}

static const char *vertices_fault(const hull *h)
{
    double max_abs = 0;
    if (h->vertex_count == 0 || h->vertex_count > HULL_VERTICES_MAX) return "vertex count out of range";
    if (h->padded_count % 8 || h->padded_count < h->vertex_count || h->padded_count >= h->vertex_count + 8)
        return "padded count is not the vertex count rounded up to 8";
    for (uint32_t i = 0; i < h->padded_count; i++) {
        vec3 v = hull_vertex(h, i);
        if (!vec_finite(v)) return "vertex is not finite";
        if (!is_within_reach(h, v)) return "vertex lies beyond the reach";
        max_abs = fmax(max_abs, vec_max_abs(v));
    }
    vec3 last = hull_vertex(h, h->vertex_count - 1);
    for (uint32_t i = h->vertex_count; i < h->padded_count; i++) {
        vec3 v = hull_vertex(h, i);
        if (v.x != last.x || v.y != last.y || v.z != last.z) return "padding does not repeat the last vertex";
    }
    return max_abs == h->max_abs ? NULL : "max_abs is not the greatest coordinate";
}

static double extent_of(const hull *h)
{
    double most = 0;
    for (uint32_t i = 1; i < h->vertex_count; i++)
        most = fmax(most, vec_max_abs(vec_sub(hull_vertex(h, i), hull_vertex(h, 0))));
    return most;
}

static vec3 corner_from_first(const hull *h, const hull_face *f, uint32_t i)
{
    const uint32_t *loop = &h->face_vertices[f->first];
    return vec_sub(hull_vertex(h, loop[i]), hull_vertex(h, loop[0]));
}

/* Along the face's normal, in squares of the face's own size. */
static double area_of_face(const hull *h, const hull_face *f)
{
    vec3 area = VEC_ZERO, last = VEC_ZERO;
    double size = 0;
    for (uint32_t i = 1; i < f->count; i++) size = fmax(size, vec_max_abs(corner_from_first(h, f, i)));
    int exponent = exponent_of(size);
    for (uint32_t i = 1; i < f->count; i++) {
        vec3 d = times_power(corner_from_first(h, f, i), -exponent);
        area = vec_add(area, vec_cross(last, d));
        last = d;
    }
    return vec_dot(area, f->normal);
}

static const char *loop_fault(const hull *h, const hull_face *f, double extent, uint32_t stamp, uint32_t *seen)
{
    double below = HULL_PLANE_RATIO * extent + 16 * ROUND_U * h->max_abs + HULL_SUBNORMAL;
    if (f->count < 3) return "face has fewer than three corners";
    for (uint32_t i = 0; i < f->count; i++) {
        uint32_t v = h->face_vertices[f->first + i];
        if (v >= h->vertex_count) return "face has a corner that is no vertex";
        if (seen[v] == stamp) return "face has a corner twice";
        seen[v] = stamp;
        if (vec_dot(f->normal, hull_vertex(h, v)) < f->offset - below) return "corner lies below its face's plane";
    }
    return area_of_face(h, f) > 0 ? NULL : "face's loop is not counter-clockwise";
}

static const char *plane_fault(const hull *h, const hull_face *f)
{
    double most = -INFINITY;
    if (!(fabs(vec_norm(f->normal) - 1) < 1e-14)) return "face's normal is not unit";
    for (uint32_t i = 0; i < h->vertex_count; i++) most = fmax(most, vec_dot(f->normal, hull_vertex(h, i)));
    return most == f->offset ? NULL : "face's offset is not that of the outermost vertex";
}

static const char *faces_fault(const hull *h, uint32_t *corner_count)
{
    const char *fault = NULL;
    double extent = extent_of(h);
    uint32_t *seen = base_zalloc(h->vertex_count, sizeof *seen);
    *corner_count = 0;
    for (uint32_t f = 0; !fault && f < h->face_count; f++) {
        const hull_face *face = &h->faces[f];
        if (face->first != *corner_count) fault = "loops are not stored one after the other";
        if (!fault) fault = loop_fault(h, face, extent, f + 1, seen);
        if (!fault) fault = plane_fault(h, face);
        *corner_count += face->count;
    }
    free(seen);
    return fault;
}

/* Whether the loop of face f walks from a to b. */
static bool walks(const hull *h, uint32_t f, uint32_t a, uint32_t b)
{
    const hull_face *face = &h->faces[f];
    for (uint32_t i = 0; i < face->count; i++)
        if (h->face_vertices[face->first + i] == a && h->face_vertices[face->first + (i + 1) % face->count] == b)
            return true;
    return false;
}

static bool is_neighbour(const hull *h, uint32_t v, uint32_t of)
{
    for (uint32_t i = h->neighbour_first[of]; i < h->neighbour_first[of + 1]; i++)
        if (h->neighbours[i] == v) return true;
    return false;
}

static const char *edge_fault(const hull *h, const hull_edge *e)
{
    if (!(e->v0 < e->v1 && e->v1 < h->vertex_count)) return "edge's vertices are out of order or range";
    if (e->f0 >= h->face_count || e->f1 >= h->face_count || e->f0 == e->f1) return "edge has no two faces";
    if (!walks(h, e->f0, e->v0, e->v1) || !walks(h, e->f1, e->v1, e->v0))
        return "edge is not in the loops of its faces";
    if (!is_neighbour(h, e->v0, e->v1) || !is_neighbour(h, e->v1, e->v0)) return "edge's vertices are no neighbours";
    return NULL;
}

static const char *neighbours_fault(const hull *h)
{
    if (h->neighbour_first[0] != 0 || h->neighbour_first[h->vertex_count] != 2 * h->edge_count)
        return "neighbours are not two an edge";
    for (uint32_t v = 0; v < h->vertex_count; v++) {
        uint32_t begin = h->neighbour_first[v], end = h->neighbour_first[v + 1];
        if (begin > end || (h->face_count && end - begin < 3)) return "vertex has fewer than three neighbours";
        for (uint32_t i = begin; i + 1 < end; i++)
            if (h->neighbours[i] >= h->neighbours[i + 1]) return "neighbours are not in ascending order";
    }
    return NULL;
}

static const char *edges_fault(const hull *h)
{
    for (uint32_t e = 0; e < h->edge_count; e++) {
        const hull_edge *a = &h->edges[e], *before = e ? a - 1 : NULL;
        if (before && !(before->v0 < a->v0 || (before->v0 == a->v0 && before->v1 < a->v1)))
            return "edges are not in ascending order";
        const char *fault = edge_fault(h, a);
        if (fault) return fault;
    }
    return NULL;
}

const char *hull_validate(const hull *h)
{
    const char *fault = vertices_fault(h);
    uint32_t corners = 0;
    if (fault) return fault;
    if (h->dimension != 3) return h->face_count || h->edge_count ? "flat hull has faces or edges" : neighbours_fault(h);
    if ((fault = faces_fault(h, &corners))) return fault;
    if (corners != 2 * h->edge_count) return "edges do not match the loops";
    if (h->vertex_count + h->face_count != h->edge_count + 2) return "Euler's formula does not hold";
    if ((fault = neighbours_fault(h))) return fault;
    return edges_fault(h);
}
