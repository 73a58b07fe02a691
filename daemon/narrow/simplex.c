/* simplex: nearest point of up to four points to the origin, by brute force over their faces. Pure; any thread. */
#include "simplex.h"

/* A feature under test: its points by index, its weights, what it gives. */
typedef struct candidate {
    int count, index[3];
    double weight[3];
    vec3 point, axis;
    double norm2;
} candidate;

static void set_point(candidate *c, const vec3 *p)
{
    vec3 sum = VEC_ZERO;
    for (int i = 0; i < c->count; i++) sum = vec_madd(sum, c->weight[i], p[c->index[i]]);
    c->point = sum;
    c->norm2 = vec_norm2(sum);
}

static void vertex_candidate(candidate *c, const vec3 *p, int i)
{
    c->count = 1;
    c->index[0] = i;
    c->weight[0] = 1;
    set_point(c, p);
    c->axis = p[i];
}

/* False when the projection of the origin is not between the two points. */
static bool edge_candidate(candidate *c, const vec3 *p, int i, int j)
{
    vec3 e = vec_sub(p[j], p[i]);
    double to_j = -vec_dot(p[i], e), to_i = vec_dot(p[j], e), sum = to_i + to_j;
    if (!(to_i > 0 && to_j > 0)) return false;
    c->count = 2;
    c->index[0] = i, c->index[1] = j;
    c->weight[0] = to_i / sum, c->weight[1] = to_j / sum;
    set_point(c, p);
    /* orthogonal to the edge, twice: the first pass loses what cancels when the edge passes close to the origin */
    vec3 n = c->point;
    double ee = vec_norm2(e);
    n = vec_madd(n, -vec_dot(n, e) / ee, e);
    c->axis = vec_madd(n, -vec_dot(n, e) / ee, e);
    return true;
}

vec3 triangle_normal(vec3 a, vec3 b, vec3 c)
{
    vec3 ab = vec_sub(b, a), bc = vec_sub(c, b), ca = vec_sub(a, c);
    double l_ab = vec_norm2(ab), l_bc = vec_norm2(bc), l_ca = vec_norm2(ca);
    if (l_ab >= l_bc && l_ab >= l_ca) return vec_cross(bc, ca);
    return l_bc >= l_ca ? vec_cross(ca, ab) : vec_cross(ab, bc);
}

/* False when the projection of the origin is outside, or the triangle is a line. */
static bool face_candidate(candidate *c, const vec3 *p, int i, int j, int k)
{
    vec3 n = triangle_normal(p[i], p[j], p[k]);
    if (!(vec_norm2(n) > 0)) return false;
    double w0 = vec_dot(n, vec_cross(p[j], p[k])), w1 = vec_dot(n, vec_cross(p[k], p[i]));
    double w2 = vec_dot(n, vec_cross(p[i], p[j])), sum = w0 + w1 + w2;
    if (!(w0 > 0 && w1 > 0 && w2 > 0)) return false;
    c->count = 3;
    c->index[0] = i, c->index[1] = j, c->index[2] = k;
    c->weight[0] = w0 / sum, c->weight[1] = w1 / sum, c->weight[2] = w2 / sum;
    set_point(c, p);
    c->axis = n;
    return true;
}

static double triple(vec3 a, vec3 b, vec3 c)
{
    return vec_dot(a, vec_cross(b, c));
}

/* Four points hold the origin when the four tetrahedra with it in place of one of them have the sign of the whole;
 * their shares are its weights. A whole within rounding of flat says nothing: its faces answer then. */
static bool holds_origin(const vec3 *p, double weight[4])
{
    double v0 = triple(p[1], p[3], p[2]), v1 = triple(p[0], p[2], p[3]);
    double v2 = triple(p[0], p[3], p[1]), v3 = triple(p[0], p[1], p[2]);
    vec3 e1 = vec_sub(p[1], p[0]), e2 = vec_sub(p[2], p[0]), e3 = vec_sub(p[3], p[0]);
    double whole = triple(e1, e2, e3);
    double noise = 64 * UNIT_ROUNDOFF * sqrt(vec_norm2(e1) * vec_norm2(e2) * vec_norm2(e3));
    if (fabs(whole) <= noise) return false;
    bool positive = v0 >= 0 && v1 >= 0 && v2 >= 0 && v3 >= 0, negative = v0 <= 0 && v1 <= 0 && v2 <= 0 && v3 <= 0;
    double share[4] = {v0, v1, v2, v3}, sum = v0 + v1 + v2 + v3;
    for (int i = 0; i < 4; i++) weight[i] = share[i] / sum;
    return (positive || negative) && sum != 0;
}

static void keep_less(candidate *best, const candidate *c)
{
    if (c->norm2 < best->norm2) *best = *c;
}

/* Points at distance zero have no direction of their own; any is as good. */
static vec3 outward_axis(const candidate *c)
{
    vec3 axis = vec_unit(c->axis);
    if (!(vec_norm2(axis) > 0)) return vec(1, 0, 0);
    return vec_dot(axis, c->point) < 0 ? vec_neg(axis) : axis;
}

nearest_feature simplex_reduce(simplex *s)
{
    vec3 p[4] = {VEC_ZERO, VEC_ZERO, VEC_ZERO, VEC_ZERO};
    for (int i = 0; i < s->count; i++) p[i] = s->v[i].w;
    if (s->count == 4 && holds_origin(p, s->weight)) return (nearest_feature){.inside = true};
    int last = s->count - 1;
    candidate best, c;
    vertex_candidate(&best, p, last);
    for (int i = 0; i < last; i++) {
        if (edge_candidate(&c, p, i, last)) keep_less(&best, &c);
        for (int j = i + 1; j < last; j++)
            if (face_candidate(&c, p, i, j, last)) keep_less(&best, &c);
    }
    simplex kept = {.count = best.count};
    for (int i = 0; i < best.count; i++) {
        kept.v[i] = s->v[best.index[i]];
        kept.weight[i] = best.weight[i];
    }
    *s = kept;
    return (nearest_feature){.point = best.point, .norm = sqrt(best.norm2), .axis = outward_axis(&best)};
}

double triangle_nearest(vec3 p0, vec3 p1, vec3 p2, double weight[3], vec3 *axis)
{
    const vec3 p[3] = {p0, p1, p2};
    candidate best, c;
    vertex_candidate(&best, p, 0);
    for (int i = 0; i < 3; i++) {
        vertex_candidate(&c, p, i);
        keep_less(&best, &c);
        if (edge_candidate(&c, p, i, (i + 1) % 3)) keep_less(&best, &c);
    }
    if (face_candidate(&c, p, 0, 1, 2)) keep_less(&best, &c);
    weight[0] = weight[1] = weight[2] = 0;
    for (int i = 0; i < best.count; i++) weight[best.index[i]] = best.weight[i];
    *axis = best.count == 3 ? vec_unit(best.axis) : vec_unit(best.point);
    return sqrt(best.norm2);
}

void simplex_witness(const simplex *s, vec3 *point_a, vec3 *point_b)
{
    *point_a = *point_b = VEC_ZERO;
    for (int i = 0; i < s->count; i++) {
        *point_a = vec_madd(*point_a, s->weight[i], s->v[i].a);
        *point_b = vec_madd(*point_b, s->weight[i], s->v[i].b);
    }
}
