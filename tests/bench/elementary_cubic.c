#include "elementary_cubic.h"

#include <math.h>

static vec3 at_time(const elementary_query *q, int i, double t)
{
    return vec_add(vec_scale(q->start[i], 1 - t), vec_scale(q->end[i], t));
}

static double value(const double c[4], double t)
{
    return ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
}

/* (x0 + t x1) . ((y0 + t y1) x (z0 + t z1)) */
static void coplanarity(const elementary_query *q, double c[4])
{
    static const int PAIRS[2][3][2] = {{{0, 1}, {1, 2}, {1, 3}}, {{0, 2}, {0, 1}, {2, 3}}};
    vec3 s[3], v[3];
    for (int i = 0; i < 3; i++) {
        const int *pair = PAIRS[q->kind][i];
        s[i] = vec_sub(q->start[pair[1]], q->start[pair[0]]);
        v[i] = vec_sub(vec_sub(q->end[pair[1]], q->end[pair[0]]), s[i]);
    }
    vec3 ss = vec_cross(s[1], s[2]), vv = vec_cross(v[1], v[2]);
    vec3 sv = vec_add(vec_cross(s[1], v[2]), vec_cross(v[1], s[2]));
    c[0] = vec_dot(s[0], ss);
    c[1] = vec_dot(s[0], sv) + vec_dot(v[0], ss);
    c[2] = vec_dot(s[0], vv) + vec_dot(v[0], sv);
    c[3] = vec_dot(v[0], vv);
}

static bool within(double x, double tolerance)
{
    return x >= -tolerance && x <= 1 + tolerance;
}

static bool inside(const elementary_query *q, double t, double tolerance)
{
    vec3 p[4];
    for (int i = 0; i < 4; i++) p[i] = at_time(q, i, t);
    bool face = q->kind == ELEMENTARY_VF;
    vec3 e = face ? vec_sub(p[2], p[1]) : vec_sub(p[1], p[0]), f = vec_sub(p[3], face ? p[1] : p[2]);
    vec3 r = face ? vec_sub(p[0], p[1]) : vec_sub(p[2], p[0]);
    double ee = vec_dot(e, e), ef = vec_dot(e, f), ff = vec_dot(f, f), er = vec_dot(e, r), fr = vec_dot(f, r);
    double determinant = ee * ff - ef * ef;
    if (!(determinant > 0)) return false;
    double x = (er * ff - fr * ef) / determinant, y = (face ? fr * ee - er * ef : er * ef - fr * ee) / determinant;
    return within(x, tolerance) && within(y, tolerance) && (!face || x + y <= 1 + tolerance);
}

/* Newton's method between two times at which the cubic has opposite signs, halving where it leaves them. */
static double root_between(const double c[4], double a, double b)
{
    bool rising = value(c, a) < 0;
    double t = 0.5 * (a + b);
    for (int i = 0; i < 60 && b - a > 1e-15; i++) {
        double f = value(c, t), slope = (3 * c[3] * t + 2 * c[2]) * t + c[1];
        if (f == 0) return t;
        *((f < 0) == rising ? &a : &b) = t;
        double next = t - f / slope;
        if (fabs(next - t) < 1e-16) return next;
        t = next > a && next < b ? next : 0.5 * (a + b);
    }
    return t;
}

/* The times at which the cubic turns, in order, and 1. */
static int turning_points(const double c[4], double out[3])
{
    double a = 3 * c[3], b = c[2], disc = b * b - a * c[1], t[2] = {2, 2};
    int count = 0;
    if (disc > 0) {
        double k = -(b + copysign(sqrt(disc), b)); /* a t^2 + 2 b t + c1 */
        t[0] = k / a, t[1] = c[1] / k;
    } else if (a == 0 && b != 0) {
        t[0] = -c[1] / (2 * b);
    }
    if (t[0] > t[1]) {
        double swap = t[0];
        t[0] = t[1], t[1] = swap;
    }
    for (int i = 0; i < 2; i++)
        if (t[i] > 0 && t[i] < 1) out[count++] = t[i];
    out[count++] = 1;
    return count;
}

bool elementary_cubic(const elementary_query *q, double tolerance, double *t)
{
    double c[4], ends[3], a = 0;
    coplanarity(q, c);
    double b1 = c[0] + c[1] / 3, b2 = b1 + (c[1] + c[2]) / 3, b3 = c[0] + c[1] + c[2] + c[3]; /* Bernstein */
    if ((c[0] > 0 && b1 > 0 && b2 > 0 && b3 > 0) || (c[0] < 0 && b1 < 0 && b2 < 0 && b3 < 0)) return false;
    int count = turning_points(c, ends);
    for (int i = 0; i < count; a = ends[i++]) {
        double fa = value(c, a), fb = value(c, ends[i]);
        if (fa * fb > 0) continue;
        *t = fa == 0 ? a : fb == 0 ? ends[i] : root_between(c, a, ends[i]);
        if (inside(q, *t, tolerance)) return true;
    }
    return false;
}
