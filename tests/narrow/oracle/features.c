/* features: the signed distance of two polytopes by trying every pair of features, in 113 bits.
 *
 * Apart: the least of all vertex-face and edge-edge distances, proved by the separation along the line between the two
 * points. Not apart: the greatest separation along all face normals and all cross products of edges. */
#include "body.h"
#include "polytope.h"

typedef struct nearest { /* of what was tried so far */
    quad distance;
    qvec from_a_to_b;
} nearest;

static void keep_nearer(nearest *best, qvec on_a, qvec on_b)
{
    qvec d = q_sub(on_b, on_a);
    quad distance = q_norm(d);
    if (distance < best->distance) *best = (nearest){distance, d};
}

static bool over_face(const polytope *p, const polytope_face *face, qvec point)
{
    for (size_t e = face->first_edge; e < face->first_edge + face->edge_count; e++)
        if (q_dot(p->edges[e].inward, q_sub(point, p->points[p->edges[e].from])) < 0) return false;
    return true;
}

/* All vertices of `v` against all faces of `p`; `p_is_a` tells which way the vector goes. */
static void try_vertices_faces(const polytope *v, const polytope *p, bool p_is_a, nearest *best)
{
    for (size_t f = 0; f < p->face_count; f++) {
        const polytope_face *face = &p->faces[f];
        qvec origin = p->points[p->edges[face->first_edge].from];
        for (size_t i = 0; i < v->count; i++) {
            if (!over_face(p, face, v->points[i])) continue;
            quad height = q_dot(face->normal, q_sub(v->points[i], origin));
            qvec foot = q_sub(v->points[i], q_scale(face->normal, height));
            if (p_is_a)
                keep_nearer(best, foot, v->points[i]);
            else
                keep_nearer(best, v->points[i], foot);
        }
    }
}

static quad clamped(quad t)
{
    return q_max(0, q_min(1, t));
}

/* The point of the segment from `start` along `along` that is nearest to `to`. */
static qvec nearest_on(qvec start, qvec along, qvec to)
{
    quad length2 = q_dot(along, along);
    if (!(length2 > 0)) return start;
    return q_add(start, q_scale(along, clamped(q_dot(along, q_sub(to, start)) / length2)));
}

/* Ends against the other segment, and the common perpendicular where it meets both. */
static void try_edges(qvec a, qvec da, qvec b, qvec db, nearest *best)
{
    qvec a_end = q_add(a, da), b_end = q_add(b, db), n = q_cross(da, db), ab = q_sub(b, a);
    keep_nearer(best, a, nearest_on(b, db, a));
    keep_nearer(best, a_end, nearest_on(b, db, a_end));
    keep_nearer(best, nearest_on(a, da, b), b);
    keep_nearer(best, nearest_on(a, da, b_end), b_end);
    quad n2 = q_dot(n, n);
    if (!(n2 > 0)) return;
    quad s = q_dot(q_cross(ab, db), n) / n2, t = q_dot(q_cross(ab, da), n) / n2;
    if (s < 0 || s > 1 || t < 0 || t > 1) return;
    keep_nearer(best, q_add(a, q_scale(da, s)), q_add(b, q_scale(db, t)));
}

static qvec edge_along(const polytope *p, size_t e)
{
    return q_sub(p->points[p->edges[e].to], p->points[p->edges[e].from]);
}

/* The edges of a solid stand in the list twice; the second time they are skipped. */
static bool seen_before(const polytope *p, size_t e)
{
    for (size_t k = 0; k < e; k++)
        if (p->edges[k].from == p->edges[e].from && p->edges[k].to == p->edges[e].to) return true;
    return false;
}

static size_t unique_edges(polytope *p)
{
    size_t kept = 0;
    size_t *order = body_allocate(p->edge_count, sizeof *order);
    for (size_t e = 0; e < p->edge_count; e++)
        if (!seen_before(p, e)) order[kept++] = e;
    polytope_edge *edges = body_allocate(kept, sizeof *edges);
    for (size_t e = 0; e < kept; e++) edges[e] = p->edges[order[e]];
    free(order);
    free(p->edges);
    p->edges = edges;
    p->edge_count = kept;
    return kept;
}

static nearest nearest_features(polytope *a, polytope *b)
{
    nearest best = {.distance = INFINITY};
    try_vertices_faces(b, a, true, &best);
    try_vertices_faces(a, b, false, &best);
    unique_edges(a); /* the faces' own lists are not needed any more */
    unique_edges(b);
    for (size_t i = 0; i < a->edge_count; i++)
        for (size_t j = 0; j < b->edge_count; j++)
            try_edges(
                a->points[a->edges[i].from], edge_along(a, i), b->points[b->edges[j].from], edge_along(b, j), &best);
    return best;
}

/* f along `n` and along its opposite, of the cores. */
static void keep_deeper(const oracle_body *a, const oracle_body *b, qvec n, oracle_truth *best)
{
    if (!(q_dot(n, n) > 0)) return;
    for (int sign = 0; sign < 2; sign++, n = q_neg(n)) {
        quad f = oracle_separation(a, b, n);
        if (f > best->lo) *best = (oracle_truth){.lo = f, .axis = q_unit(n)};
    }
}

static oracle_truth deepest_axis(const oracle_body *a, const oracle_body *b, const polytope *pa, const polytope *pb)
{
    oracle_truth best = {.lo = -INFINITY};
    for (size_t f = 0; f < pa->face_count; f++) keep_deeper(a, b, pa->faces[f].normal, &best);
    for (size_t f = 0; f < pb->face_count; f++) keep_deeper(a, b, pb->faces[f].normal, &best);
    for (size_t i = 0; i < pa->edge_count; i++)
        for (size_t j = 0; j < pb->edge_count; j++) {
            qvec da = edge_along(pa, i), db = edge_along(pb, j), n = q_cross(da, db);
            bool parallel = q_norm(n) <= (quad)1e-27 * q_norm(da) * q_norm(db);
            if (!parallel) keep_deeper(a, b, n, &best);
        }
    /* points and lines in one line: there is no area to push against */
    if (!(best.lo > -(quad)INFINITY)) best = (oracle_truth){.lo = 0, .axis = qv(1, 0, 0)};
    return best;
}

static qvec *world_points(const oracle_body *body, qvec origin)
{
    qvec *points = body_allocate(body->count, sizeof *points);
    qvec shift = q_sub(body->position, origin);
    for (size_t i = 0; i < body->count; i++) points[i] = q_add(q_mul(body->rotation, body->points[i]), shift);
    return points;
}

oracle_truth oracle_distance_features(const oracle_body *a, const oracle_body *b)
{
    oracle_body core_a = *a, core_b = *b;
    core_a.radius = core_b.radius = 0;
    qvec *points_a = world_points(a, a->position), *points_b = world_points(b, a->position);
    polytope pa = polytope_build(points_a, a->count), pb = polytope_build(points_b, b->count);
    quad tiny = (quad)1e-26 * oracle_size(a, b);

    nearest gap = nearest_features(&pa, &pb);
    oracle_truth truth = {.lo = gap.distance, .axis = q_unit(gap.from_a_to_b)};
    bool apart = gap.distance > tiny && oracle_separation(&core_a, &core_b, gap.from_a_to_b) >= gap.distance - tiny;
    if (!apart) truth = deepest_axis(&core_a, &core_b, &pa, &pb);
    truth.lo -= a->radius + b->radius;
    truth.hi = truth.lo + tiny;
    truth.lo -= tiny;
    polytope_free(&pa);
    polytope_free(&pb);
    free(points_a);
    free(points_b);
    return truth;
}
