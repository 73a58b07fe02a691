/* vec3: three numbers at a time. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_VEC3_H
#define COLLIDED_LOADERS_DECOMPOSE_VEC3_H

#include <math.h>
#include <string.h>

static inline double dot3(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void sub3(const double a[3], const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}

/* a + t b */
static inline void along3(const double a[3], double t, const double b[3], double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = a[k] + t * b[k];
}

static inline void cross3(const double a[3], const double b[3], double out[3])
{
    double c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    memcpy(out, c, sizeof c);
}

static inline double norm3(const double a[3])
{
    return sqrt(dot3(a, a));
}

static inline double distance3(const double a[3], const double b[3])
{
    double d[3];
    sub3(a, b, d);
    return norm3(d);
}

/* A box that holds nothing yet, and one that holds x, too. */
static inline void box_empty(double lo[3], double hi[3])
{
    for (int k = 0; k < 3; k++) lo[k] = INFINITY, hi[k] = -INFINITY;
}

static inline void box_add(double lo[3], double hi[3], const double x[3])
{
    for (int k = 0; k < 3; k++) lo[k] = fmin(lo[k], x[k]), hi[k] = fmax(hi[k], x[k]);
}

/* A right-handed frame, unit rows, whose z is along `z` (not zero). */
static inline void frame3(const double z[3], double axes[3][3])
{
    double length = norm3(z);
    int least = 0;
    for (int k = 1; k < 3; k++) least = fabs(z[k]) < fabs(z[least]) ? k : least;
    const double unit[3] = {least == 0, least == 1, least == 2};
    for (int k = 0; k < 3; k++) axes[2][k] = z[k] / length;
    cross3(unit, axes[2], axes[0]);
    length = norm3(axes[0]);
    for (int k = 0; k < 3; k++) axes[0][k] /= length;
    cross3(axes[2], axes[0], axes[1]);
}

#endif
