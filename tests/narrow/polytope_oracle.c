/* polytope_oracle: brute force over the features of two polytopes, in 113 bits. */
#include "polytope_oracle.h"

#include <stdlib.h>

enum { VERTICES_MAX = 64, TRIANGLES_MAX = 128, EDGES_MAX = 192 };

typedef struct polytope {
    int vertices, triangles, edges;
    real3 vertex[VERTICES_MAX];
    int triangle[TRIANGLES_MAX][3], edge[EDGES_MAX][2];
} polytope;

static const real FAR = 1e4000Q;

static void add_edge(polytope *p, int i, int j)
{
    for (int k = 0; k < p->edges; k++)
        if ((p->edge[k][0] == i && p->edge[k][1] == j) || (p->edge[k][0] == j && p->edge[k][1] == i)) return;
    if (p->edges == EDGES_MAX) abort();
    p->edge[p->edges][0] = i, p->edge[p->edges++][1] = j;
}

static void add_triangle(polytope *p, int i, int j, int k)
{
    if (p->triangles == TRIANGLES_MAX) abort();
    int *t = p->triangle[p->triangles++];
    t[0] = i, t[1] = j, t[2] = k;
    add_edge(p, i, j);
    add_edge(p, j, k);
    add_edge(p, k, i);
}

static void add_box(polytope *p, const placed *s)
{
    static const int FACES[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
    vec3 h = s->s->half;
    for (int i = 0; i < 8; i++)
        p->vertex[p->vertices++] = oracle_point(s, (real3){i & 4 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 1 ? h.z : -h.z});
    for (int i = 0; i < 6; i++) {
        add_triangle(p, FACES[i][0], FACES[i][1], FACES[i][2]);
        add_triangle(p, FACES[i][0], FACES[i][2], FACES[i][3]);
    }
}

static void add_hull(polytope *p, const placed *s)
{
    const hull *h = s->s->hull;
    if (h->vertex_count > VERTICES_MAX) abort();
    for (uint32_t i = 0; i < h->vertex_count; i++)
        p->vertex[p->vertices++] = oracle_point(s, real3_of(hull_vertex(h, i)));
    for (uint32_t f = 0; f < h->face_count; f++) {
        const uint32_t *v = h->face_vertices + h->faces[f].first;
        for (uint32_t k = 2; k < h->faces[f].count; k++) add_triangle(p, (int)v[0], (int)v[k - 1], (int)v[k]);
    }
}

static polytope polytope_of(const placed *s)
{
    polytope p = {.vertices = 0};
    if (s->s->type == SHAPE_HULL) {
        add_hull(&p, s);
    } else if (s->s->type == SHAPE_BOX) {
        add_box(&p, s);
    } else {
        real h = s->s->type == SHAPE_CAPSULE ? s->s->half.z : 0;
        p.vertex[p.vertices++] = oracle_point(s, (real3){0, 0, h});
        p.vertex[p.vertices++] = oracle_point(s, (real3){0, 0, -h});
        add_edge(&p, 0, 1);
    }
    return p;
}

static real3 sub(const polytope *p, int i, int j)
{
    return real3_sub(p->vertex[i], p->vertex[j]);
}

static real separation(const polytope *a, const polytope *b, real3 n)
{
    real low = FAR, high = -FAR, length2 = real3_dot(n, n);
    if (length2 <= 1e-50Q) return -FAR;
    for (int i = 0; i < b->vertices; i++) {
        real h = real3_dot(n, b->vertex[i]);
        low = h < low ? h : low;
    }
    for (int i = 0; i < a->vertices; i++) {
        real h = real3_dot(n, a->vertex[i]);
        high = h > high ? h : high;
    }
    return (low - high) / real_sqrt(length2);
}

static void keep_greater(real *best, real x)
{
    *best = x > *best ? x : *best;
}
static void keep_less(real *best, real x)
{
    *best = x < *best ? x : *best;
}

static real best_axis(const polytope *a, const polytope *b)
{
    real best = -FAR;
    for (int side = 0; side < 2; side++) {
        const polytope *p = side ? b : a;
        for (int i = 0; i < p->triangles; i++) {
            const int *t = p->triangle[i];
            real3 n = real3_cross(sub(p, t[1], t[0]), sub(p, t[2], t[0]));
            keep_greater(&best, separation(a, b, n));
            keep_greater(&best, separation(a, b, real3_scale(n, -1)));
        }
    }
    for (int i = 0; i < a->edges; i++)
        for (int j = 0; j < b->edges; j++) {
            real3 n = real3_cross(sub(a, a->edge[i][1], a->edge[i][0]), sub(b, b->edge[j][1], b->edge[j][0]));
            keep_greater(&best, separation(a, b, n));
            keep_greater(&best, separation(a, b, real3_scale(n, -1)));
        }
    return best;
}

static real clamp01(real x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

static real point_segment2(real3 x, real3 p, real3 q)
{
    real3 e = real3_sub(q, p), r = real3_sub(x, p);
    real ee = real3_dot(e, e), s = ee > 0 ? clamp01(real3_dot(r, e) / ee) : 0;
    r = real3_sub(r, real3_scale(e, s));
    return real3_dot(r, r);
}

/* Squared distance of a point from the inside of a triangle; FAR when it projects outside (an edge is nearer). */
static real point_triangle2(real3 x, real3 p0, real3 p1, real3 p2)
{
    real3 n = real3_cross(real3_sub(p1, p0), real3_sub(p2, p0));
    const real3 p[3] = {p0, p1, p2};
    for (int i = 0; i < 3; i++) {
        real3 e = real3_sub(p[(i + 1) % 3], p[i]);
        if (real3_dot(real3_cross(e, real3_sub(x, p[i])), n) < 0) return FAR;
    }
    real h = real3_dot(n, real3_sub(x, p0));
    return h * h / real3_dot(n, n);
}

static real segment_segment2(real3 p, real3 q, real3 r, real3 s)
{
    real best = point_segment2(p, r, s);
    keep_less(&best, point_segment2(q, r, s));
    keep_less(&best, point_segment2(r, p, q));
    keep_less(&best, point_segment2(s, p, q));
    real3 d = real3_sub(q, p), e = real3_sub(s, r), w = real3_sub(r, p);
    real dd = real3_dot(d, d), ee = real3_dot(e, e), de = real3_dot(d, e), det = dd * ee - de * de;
    if (det <= 1e-30Q * dd * ee) return best;
    real u = (real3_dot(d, w) * ee - real3_dot(e, w) * de) / det, v = (u * de - real3_dot(e, w)) / ee;
    if (u < 0 || u > 1 || v < 0 || v > 1) return best;
    real3 gap = real3_sub(real3_sub(real3_scale(d, u), w), real3_scale(e, v));
    keep_less(&best, real3_dot(gap, gap));
    return best;
}

static real nearest_features(const polytope *a, const polytope *b)
{
    real best = FAR;
    for (int side = 0; side < 2; side++) {
        const polytope *p = side ? b : a, *q = side ? a : b;
        for (int i = 0; i < p->vertices; i++)
            for (int j = 0; j < q->triangles; j++) {
                const int *t = q->triangle[j];
                keep_less(&best, point_triangle2(p->vertex[i], q->vertex[t[0]], q->vertex[t[1]], q->vertex[t[2]]));
            }
    }
    for (int i = 0; i < a->edges; i++)
        for (int j = 0; j < b->edges; j++)
            keep_less(&best, segment_segment2(a->vertex[a->edge[i][0]], a->vertex[a->edge[i][1]],
                                 b->vertex[b->edge[j][0]], b->vertex[b->edge[j][1]]));
    return real_sqrt(best);
}

real polytope_signed_distance(const placed *a, const placed *b)
{
    polytope p = polytope_of(a), q = polytope_of(b);
    real axis = p.triangles || q.triangles ? best_axis(&p, &q) : FAR, radius = (real)a->s->radius + b->s->radius;
    return (axis < 0 ? axis : nearest_features(&p, &q)) - radius;
}
