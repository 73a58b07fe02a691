/* polytope: the convex hull of points by brute force, in 113 bits. */
#include "polytope.h"

#include "body.h"

#define PLANE_TOLERANCE ((quad)1e-27)

static quad size_of(const qvec *points, size_t count)
{
    quad most = 0;
    for (size_t i = 0; i < count; i++) most = q_max(most, q_max_abs(q_sub(points[i], points[0])));
    return most;
}

static void *grown(void *array, size_t count, size_t size)
{
    if (count & (count - 1)) return array; /* full only at powers of two */
    void *memory = realloc(array, (count ? 2 * count : 1) * size);
    if (!memory) abort();
    return memory;
}

static bool in_known_face(const polytope *p, size_t i, size_t j, size_t k)
{
    for (size_t f = 0; f < p->face_count; f++)
        if (p->faces[f].on[i] && p->faces[f].on[j] && p->faces[f].on[k]) return true;
    return false;
}

/* Adds the plane through i, j, k as a face, if all points are on one side of it. */
static void try_face(polytope *p, size_t i, size_t j, size_t k, quad tolerance)
{
    qvec to_j = q_sub(p->points[j], p->points[i]), to_k = q_sub(p->points[k], p->points[i]);
    qvec across = q_cross(to_j, to_k);
    quad length = q_norm(across), on_plane = tolerance * length;
    if (length <= tolerance * q_max(q_max_abs(to_j), q_max_abs(to_k))) return; /* in line */
    bool below = false, above = false;
    quad heights[ORACLE_FEATURES_MAX];
    for (size_t l = 0; l < p->count; l++) {
        heights[l] = q_dot(across, q_sub(p->points[l], p->points[i]));
        if (heights[l] > on_plane) above = true;
        if (heights[l] < -on_plane) below = true;
        if (above && below) return;
    }
    polytope_face face = {.normal = q_scale(across, (above ? -1 : 1) / length)};
    for (size_t l = 0; l < p->count; l++) face.on[l] = q_abs(heights[l]) <= on_plane;
    p->faces = grown(p->faces, p->face_count, sizeof *p->faces);
    p->faces[p->face_count++] = face;
}

static void add_edge(polytope *p, polytope_edge edge)
{
    p->edges = grown(p->edges, p->edge_count, sizeof *p->edges);
    p->edges[p->edge_count++] = edge;
}

/* Is (i, j) an edge of the face: all its points on one side of the line, and those on the line between i and j? */
static bool is_edge(const polytope *p, const polytope_face *face, size_t i, size_t j, quad tolerance, qvec *inward)
{
    qvec along = q_sub(p->points[j], p->points[i]);
    quad length = q_norm(along);
    if (!(length > tolerance)) return false;
    qvec side = q_scale(q_cross(face->normal, along), 1 / length);
    bool left = false, right = false;
    for (size_t l = 0; l < p->count; l++) {
        if (!face->on[l]) continue;
        qvec to = q_sub(p->points[l], p->points[i]);
        quad across = q_dot(side, to), ahead = q_dot(along, to) / length;
        if (across > tolerance) left = true;
        if (across < -tolerance) right = true;
        if (q_abs(across) <= tolerance && (ahead < -tolerance || ahead > length + tolerance)) return false;
    }
    *inward = left ? side : q_neg(side);
    return !(left && right);
}

/* Points at the place of an earlier one are left out of everything. */
static void find_repeated(const polytope *p, quad tolerance, bool *repeated)
{
    for (size_t i = 0; i < p->count; i++)
        for (size_t l = 0; l < i && !repeated[i]; l++)
            repeated[i] = q_max_abs(q_sub(p->points[l], p->points[i])) <= tolerance;
}

static void find_edges(polytope *p, polytope_face *face, quad tolerance, const bool *repeated)
{
    face->first_edge = p->edge_count;
    for (size_t i = 0; i < p->count; i++) {
        if (!face->on[i] || repeated[i]) continue;
        for (size_t j = i + 1; j < p->count; j++) {
            polytope_edge edge = {.from = i, .to = j};
            if (!face->on[j] || repeated[j]) continue;
            if (is_edge(p, face, i, j, tolerance, &edge.inward)) add_edge(p, edge);
        }
    }
    face->edge_count = p->edge_count - face->first_edge;
}

/* Points all in one line, or in one place: the two that are farthest apart. */
static void find_line(polytope *p)
{
    polytope_edge edge = {.from = 0, .to = 0};
    for (size_t i = 0; i < p->count; i++)
        for (size_t j = i + 1; j < p->count; j++)
            if (q_norm(q_sub(p->points[j], p->points[i])) > q_norm(q_sub(p->points[edge.to], p->points[edge.from])))
                edge.from = i, edge.to = j;
    add_edge(p, edge);
}

polytope polytope_build(const qvec *points, size_t count)
{
    polytope p = {.points = points, .count = count};
    if (count == 0 || count > ORACLE_FEATURES_MAX) abort();
    quad tolerance = PLANE_TOLERANCE * size_of(points, count);
    bool repeated[ORACLE_FEATURES_MAX] = {false};
    find_repeated(&p, tolerance, repeated);
    for (size_t i = 0; i < count; i++)
        for (size_t j = i + 1; j < count && !repeated[i]; j++)
            for (size_t k = j + 1; k < count && !repeated[j]; k++)
                if (!repeated[k] && !in_known_face(&p, i, j, k)) try_face(&p, i, j, k, tolerance);
    for (size_t f = 0; f < p.face_count; f++) find_edges(&p, &p.faces[f], tolerance, repeated);
    if (p.face_count == 0) find_line(&p);
    return p;
}

void polytope_free(polytope *p)
{
    free(p->faces);
    free(p->edges);
    *p = (polytope){.points = NULL};
}
