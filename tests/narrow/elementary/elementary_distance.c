/* The exact squared distance of the origin from the polygon of differences at one time: the least over its corners, its
 * edges and its face. */
#include "elementary_oracle.h"

#include <gmp.h>
#include <math.h>

typedef struct point {
    mpq_t at[3];
} point;

static void point_init(point *p)
{
    for (int k = 0; k < 3; k++) mpq_init(p->at[k]);
}

static void point_clear(point *p)
{
    for (int k = 0; k < 3; k++) mpq_clear(p->at[k]);
}

static void point_sub(point *out, const point *a, const point *b)
{
    for (int k = 0; k < 3; k++) mpq_sub(out->at[k], a->at[k], b->at[k]);
}

static void point_dot(mpq_t out, const point *a, const point *b)
{
    mpq_t term, sum;
    mpq_inits(term, sum, NULL);
    for (int k = 0; k < 3; k++) {
        mpq_mul(term, a->at[k], b->at[k]);
        mpq_add(sum, sum, term);
    }
    mpq_set(out, sum);
    mpq_clears(term, sum, NULL);
}

static double coordinate(vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/* (1 - t) (b0 - a0) + t (b1 - a1) */
static void difference(point *out, const elementary_query *q, int a, int b, double t)
{
    mpq_t end, time, x;
    mpq_inits(end, time, x, NULL);
    mpq_set_d(time, t);
    for (int k = 0; k < 3; k++) {
        mpq_set_d(out->at[k], coordinate(q->start[b], k));
        mpq_set_d(x, coordinate(q->start[a], k));
        mpq_sub(out->at[k], out->at[k], x);
        mpq_set_d(end, coordinate(q->end[b], k));
        mpq_set_d(x, coordinate(q->end[a], k));
        mpq_sub(end, end, x);
        mpq_sub(end, end, out->at[k]);
        mpq_mul(end, end, time);
        mpq_add(out->at[k], out->at[k], end);
    }
    mpq_clears(end, time, x, NULL);
}

static void take_least(mpq_t least, const mpq_t x)
{
    if (mpq_cmp(x, least) < 0) mpq_set(least, x);
}

/* Of the inside of the edge from a to b: |a|^2 - (a . e)^2 / e^2, if the foot is between. */
static void edge_distance(mpq_t least, const point *a, const point *b)
{
    point e;
    mpq_t ee, along, aa;
    point_init(&e);
    mpq_inits(ee, along, aa, NULL);
    point_sub(&e, b, a);
    point_dot(ee, &e, &e);
    point_dot(along, a, &e);
    mpq_neg(along, along);
    if (mpq_sgn(along) > 0 && mpq_cmp(along, ee) < 0) {
        point_dot(aa, a, a);
        mpq_mul(along, along, along);
        mpq_div(along, along, ee);
        mpq_sub(aa, aa, along);
        take_least(least, aa);
    }
    mpq_clears(ee, along, aa, NULL);
    point_clear(&e);
}

/* Of the inside of the face w0 + x e1 + y e2: the normal equations of x and y, by Cramer's rule. */
static void face_distance(mpq_t least, const point *w, int corners)
{
    point e1, e2;
    mpq_t a, b, c, d, f, x, y, s, determinant, distance;
    point_init(&e1), point_init(&e2);
    mpq_inits(a, b, c, d, f, x, y, s, determinant, distance, NULL);
    point_sub(&e1, &w[1], &w[0]);
    point_sub(&e2, &w[corners - 1], &w[0]);
    point_dot(a, &e1, &e1), point_dot(b, &e1, &e2), point_dot(c, &e2, &e2);
    point_dot(d, &e1, &w[0]), point_dot(f, &e2, &w[0]);
    mpq_mul(determinant, a, c), mpq_mul(s, b, b), mpq_sub(determinant, determinant, s);
    mpq_mul(x, b, f), mpq_mul(s, c, d), mpq_sub(x, x, s);
    mpq_mul(y, b, d), mpq_mul(s, a, f), mpq_sub(y, y, s);
    mpq_add(s, x, y);
    bool in =
        mpq_sgn(determinant) > 0 && mpq_sgn(x) >= 0 && mpq_sgn(y) >= 0 &&
        (corners == 3 ? mpq_cmp(s, determinant) <= 0 : mpq_cmp(x, determinant) <= 0 && mpq_cmp(y, determinant) <= 0);
    if (in) { /* |w0|^2 + (x d + y f) / determinant */
        mpq_mul(x, x, d), mpq_mul(y, y, f), mpq_add(s, x, y), mpq_div(s, s, determinant);
        point_dot(distance, &w[0], &w[0]);
        mpq_add(distance, distance, s);
        take_least(least, distance);
    }
    mpq_clears(a, b, c, d, f, x, y, s, determinant, distance, NULL);
    point_clear(&e1), point_clear(&e2);
}

bool elementary_oracle_within(const elementary_query *q, double t, double distance)
{
    static const int AROUND[4][2] = {{0, 0}, {0, 1}, {1, 1}, {1, 0}};
    int corners = q->kind == ELEMENTARY_VF ? 3 : 4;
    point w[4];
    mpq_t least, x;
    if (isinf(distance)) return true;
    mpq_inits(least, x, NULL);
    for (int i = 0; i < corners; i++) {
        point_init(&w[i]);
        difference(&w[i], q, corners == 3 ? 0 : AROUND[i][0], corners == 3 ? 1 + i : 2 + AROUND[i][1], t);
        point_dot(x, &w[i], &w[i]);
        if (i == 0) mpq_set(least, x);
        take_least(least, x);
    }
    for (int i = 0; i < corners; i++) edge_distance(least, &w[i], &w[(i + 1) % corners]);
    face_distance(least, w, corners);
    mpq_set_d(x, distance);
    mpq_mul(x, x, x);
    bool within = mpq_cmp(least, x) <= 0;
    for (int i = 0; i < corners; i++) point_clear(&w[i]);
    mpq_clears(least, x, NULL);
    return within;
}
