/* narrow_truth_mesh: pieces, and the best pair of them. */
#include "narrow_truth_mesh.h"

#include <stdlib.h>

typedef struct piece { /* a triangle, or the whole box */
    qvec points[8];    /* in the body's frame */
    size_t count;
    vec3 centre; /* of a triangle, in the world: one of its points */
    double radius;
} piece;

typedef struct pieces {
    const narrow_body *body;
    pose at;
    oracle_body core; /* without points */
    piece *all;
    size_t count;
} pieces;

typedef struct near_pair {
    double least; /* no nearer than this, m */
    size_t a, b;
} near_pair;

static piece box_piece(const double half[3])
{
    piece p = {.count = 8};
    for (int i = 0; i < 8; i++)
        p.points[i] = qv(i & 1 ? half[0] : -half[0], i & 2 ? half[1] : -half[1], i & 4 ? half[2] : -half[2]);
    return p;
}

static piece triangle_piece(const narrow_polytope *m, size_t triangle, pose at)
{
    piece p = {.count = 3};
    vec3 v[3], sum = VEC_ZERO;
    for (int i = 0; i < 3; i++) {
        const double *x = &m->vertices[3 * m->face_vertices[3 * triangle + (size_t)i]];
        p.points[i] = qv(x[0], x[1], x[2]);
        v[i] = vec(x[0], x[1], x[2]);
        sum = vec_add(sum, v[i]);
    }
    vec3 centre = vec_scale(sum, 1.0 / 3);
    for (int i = 0; i < 3; i++) p.radius = fmax(p.radius, vec_norm(vec_sub(v[i], centre)));
    p.centre = pose_point(at, centre);
    return p;
}

static pieces take_apart(const narrow_body *b, const narrow_place *at)
{
    pieces p = {.body = b, .at = narrow_scene_pose(at), .count = b->kind == KIND_MESH ? b->polytope->face_count : 1};
    p.core = (oracle_body){.core = ORACLE_POINTS, .rotation = oracle_rotation(at->q[0], at->q[1], at->q[2], at->q[3])};
    p.core.position = qv(at->p[0], at->p[1], at->p[2]);
    p.all = calloc(p.count, sizeof *p.all);
    if (!p.all) abort();
    for (size_t i = 0; i < p.count; i++)
        p.all[i] = b->kind == KIND_MESH ? triangle_piece(b->polytope, i, p.at) : box_piece(b->half);
    return p;
}

/* From the piece of A to the centre of the triangle of B: exact for a box, else from centre to centre. */
static double to_centre(const pieces *a, const piece *of_a, const piece *of_b)
{
    if (a->body->kind == KIND_MESH) return vec_norm(vec_sub(of_b->centre, of_a->centre));
    const double *h = a->body->half;
    vec3 x = quat_rotate(quat_conj(a->at.q), vec_sub(of_b->centre, a->at.p));
    return vec_norm(vec(fmax(fabs(x.x) - h[0], 0), fmax(fabs(x.y) - h[1], 0), fmax(fabs(x.z) - h[2], 0)));
}

static int nearest_first(const void *x, const void *y)
{
    double a = ((const near_pair *)x)->least, b = ((const near_pair *)y)->least;
    return (a > b) - (a < b);
}

/* All pairs that may be the nearest, by what bounds each from below. */
static near_pair *candidates(const pieces *a, const pieces *b, size_t *count)
{
    double most = INFINITY;
    size_t room = 0;
    near_pair *found = NULL;
    for (size_t i = 0; i < a->count; i++)
        for (size_t j = 0; j < b->count; j++) most = fmin(most, to_centre(a, &a->all[i], &b->all[j]));
    *count = 0;
    for (size_t i = 0; i < a->count; i++)
        for (size_t j = 0; j < b->count; j++) {
            double least = to_centre(a, &a->all[i], &b->all[j]) - a->all[i].radius - b->all[j].radius - 1e-12;
            if (least > most) continue;
            if (*count == room) found = realloc(found, (room = room ? 2 * room : 64) * sizeof *found);
            if (!found) abort();
            found[(*count)++] = (near_pair){least, i, j};
        }
    qsort(found, *count, sizeof *found, nearest_first);
    return found;
}

static oracle_body body_of(const pieces *p, size_t i)
{
    oracle_body b = p->core;
    b.points = p->all[i].points;
    b.count = p->all[i].count;
    return b;
}

narrow_truth narrow_truth_of_meshes(const narrow_item *item)
{
    pieces a = take_apart(item->a, &item->at_a), b = take_apart(item->b, &item->at_b);
    size_t count;
    near_pair *pairs = candidates(&a, &b, &count);
    narrow_truth best = {.distance = INFINITY};
    shape shape_a = narrow_scene_shape(item->a), shape_b = narrow_scene_shape(item->b);
    for (size_t i = 0; i < count && (quad)pairs[i].least <= best.distance; i++) {
        oracle_body of_a = body_of(&a, pairs[i].a), of_b = body_of(&b, pairs[i].b);
        oracle_truth t = oracle_distance_features(&of_a, &of_b);
        if (t.lo < best.distance) best = (narrow_truth){.distance = t.lo, .lo = t.lo, .hi = t.hi};
    }
    best.size = fmax(fmax(shape_reach(&shape_a), shape_reach(&shape_b)), vec_norm(vec_sub(b.at.p, a.at.p)));
    free(pairs);
    free(a.all);
    free(b.all);
    return best;
}
