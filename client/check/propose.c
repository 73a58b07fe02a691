/* propose: by bisection, and by GJK with all sub-simplices. */
#include "propose.h"

#include <math.h>
#include <stdbool.h>

static double product(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* The point is a_i^2 q_i / (a_i^2 + t), with t where its image in the unit ball comes to the sphere (Eberly, Distance
 * from a Point to an Ellipsoid): the image's length falls with t. Inside, t is 0. */
void propose_ellipsoid(const double q[3], const double a[3], double u[3])
{
    double low = 0, high = 0;
    for (int i = 0; i < 3; i++) u[i] = 0, high += a[i] * fabs(q[i]);
    for (int step = 0; step < 128; step++) {
        double t = step ? (low + high) / 2 : 0, v[3];
        for (int i = 0; i < 3; i++) v[i] = a[i] > 0 && fabs(q[i]) > 0 ? a[i] * q[i] / (a[i] * a[i] + t) : 0;
        bool outside = !(product(v, v) <= 1);
        for (int i = 0; i < 3; i++) u[i] = outside ? u[i] : v[i];
        if (!step && !outside) return;
        low = outside ? t : low;
        high = outside ? high : t;
    }
}

typedef struct simplex {
    double at[4][3]; /* from the point that is asked for */
    size_t corner[4];
    double weight[4];
    int count;
} simplex;

static void where(const simplex *s, double v[3])
{
    for (int k = 0; k < 3; k++) {
        v[k] = 0;
        for (int i = 0; i < s->count; i++) v[k] += s->weight[i] * s->at[i][k];
    }
}

static double squared(const simplex *s)
{
    double v[3];
    where(s, v);
    return product(v, v);
}

static double determinant(const double a[3], const double b[3], const double c[3])
{
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/* The weights of the nearest point to the origin of the corners chosen by `mask`: normal equations, by Cramer's rule,
 * and again for what is left, of which thin triangles leave much. False if there is none between the corners. */
static bool weigh(simplex *s, unsigned mask)
{
    double e[3][3] = {{0}}, row[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, w[3] = {0, 0, 0}, near[3];
    int place[4] = {0, 0, 0, 0}, n = 0;
    for (int i = 0; i < s->count; i++)
        if (mask >> i & 1) place[n++] = i;
    for (int i = 1; i < n; i++)
        for (int k = 0; k < 3; k++) e[i - 1][k] = s->at[place[i]][k] - s->at[place[0]][k];
    for (int i = 0; i < n - 1; i++)
        for (int k = 0; k < n - 1; k++) row[i][k] = product(e[i], e[k]);
    double det = determinant(row[0], row[1], row[2]);
    if (!(det > 0)) return false;
    for (int k = 0; k < 3; k++) near[k] = s->at[place[0]][k];
    for (int round = 0; round < 3; round++) {
        double b[3] = {-product(e[0], near), -product(e[1], near), -product(e[2], near)};
        w[0] += determinant(b, row[1], row[2]) / det; /* the matrix is symmetric */
        w[1] += determinant(row[0], b, row[2]) / det;
        w[2] += determinant(row[0], row[1], b) / det;
        for (int k = 0; k < 3; k++) near[k] = s->at[place[0]][k] + w[0] * e[0][k] + w[1] * e[1][k] + w[2] * e[2][k];
    }
    double rest = 1 - w[0] - w[1] - w[2];
    if (!(w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && rest >= 0)) return false;
    for (int i = 0; i < 4; i++) s->weight[i] = 0;
    for (int i = 0; i < n; i++) s->weight[place[i]] = i ? w[i - 1] : rest;
    return true;
}

/* Keeps the corners that carry the nearest point. */
static void shrink(simplex *s)
{
    simplex best = *s, tried = *s;
    for (int i = 0; i < 4; i++) best.weight[i] = i == s->count - 1;
    for (unsigned mask = 1; mask < 1u << s->count; mask++)
        if (weigh(&tried, mask) && squared(&tried) < squared(&best)) best = tried;
    s->count = 0;
    for (int i = 0; i < best.count; i++) {
        if (!(best.weight[i] > 0)) continue;
        for (int k = 0; k < 3; k++) s->at[s->count][k] = best.at[i][k];
        s->corner[s->count] = best.corner[i];
        s->weight[s->count++] = best.weight[i];
    }
}

static void add(simplex *s, const double *points, size_t corner, const double q[3], double by)
{
    for (int k = 0; k < 3; k++) s->at[s->count][k] = points[3 * corner + (size_t)k] * by - q[k];
    s->corner[s->count] = corner;
    s->weight[s->count++] = 0;
}

void propose_hull(
    const double *points, size_t count, const double q[3], double by, size_t corners[4], double weights[4])
{
    enum { STEPS = 128 };
    simplex s = {.count = 0}, best;
    add(&s, points, 0, q, by);
    s.weight[0] = 1;
    best = s;
    for (int step = 0; step < STEPS && s.count > 0 && s.count < 4; step++) {
        double v[3], least = INFINITY;
        size_t far = 0;
        where(&s, v);
        for (size_t i = 0; i < count; i++) {
            double height = 0;
            for (int k = 0; k < 3; k++) height += v[k] * (points[3 * i + (size_t)k] * by - q[k]);
            if (height < least) least = height, far = i;
        }
        if (!(least < product(v, v))) break;
        add(&s, points, far, q, by);
        shrink(&s);
        if (!(squared(&s) < squared(&best))) break;
        best = s;
    }
    for (int i = 0; i < 4; i++) {
        corners[i] = i < best.count ? best.corner[i] : 0;
        weights[i] = i < best.count ? best.weight[i] : 0;
    }
}
