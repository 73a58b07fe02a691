/* scalar: least, greatest, powers of two and unit vectors, as the few instructions that they are. Plain values.
 *
 * fmax, frexp and ldexp of the C library are calls with cases for NaN and for numbers out of range; a query makes
 * dozens. Inside narrow/ no NaN enters and all is of about unit size. */
#ifndef COLLIDED_NARROW_MATH_SCALAR_H
#define COLLIDED_NARROW_MATH_SCALAR_H

#include "geom/vec.h"

#include <stdint.h>
#include <string.h>

static inline double max_of(double a, double b)
{
    return a > b ? a : b;
}
static inline double min_of(double a, double b)
{
    return a < b ? a : b;
}
static inline double clamp_to(double x, double h) /* -h <= x <= h */
{
    return min_of(max_of(x, -h), h);
}

static inline double vec_greatest(vec3 v) /* of the |coordinates| */
{
    return max_of(fabs(v.x), max_of(fabs(v.y), fabs(v.z)));
}

/* 2^exponent, for exponents of normal numbers. */
static inline double power_of_two(int exponent)
{
    uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* x < 2^exponent, and 2^(exponent - 1) <= x when x is normal. */
static inline int exponent_above(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (int)(bits >> 52 & 0x7ff) - 1022;
}

/* vec_unit, without its divisions where the squares are in range. */
static inline vec3 direction_of(vec3 v)
{
    double norm2 = vec_norm2(v);
    return norm2 > 0x1p-900 && norm2 < 0x1p900 ? vec_scale(v, 1 / sqrt(norm2)) : vec_unit(v);
}

/* Is it one already, as near as need be? */
static inline bool is_direction(vec3 v)
{
    return fabs(vec_norm2(v) - 1) <= 0x1p-50;
}

/* The same for a vector that is a unit vector already, but for the rounding of what made it. */
static inline vec3 direction_again(vec3 v)
{
    return is_direction(v) ? v : direction_of(v);
}

/* ---- vectors by their coordinates ---- */

static inline void vec_to(vec3 v, double out[3])
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}
static inline vec3 vec_from(const double v[3])
{
    return vec(v[0], v[1], v[2]);
}
static inline double vec_at(vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}
static inline vec3 vec_on_axis(int axis, double length)
{
    return vec(axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0);
}
static inline vec3 vec_magnitudes(vec3 v)
{
    return vec(fabs(v.x), fabs(v.y), fabs(v.z));
}
static inline double vec_sum_magnitudes(vec3 v)
{
    return fabs(v.x) + fabs(v.y) + fabs(v.z);
}
static inline vec3 vec_times(vec3 a, vec3 b) /* coordinate by coordinate */
{
    return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}
static inline vec3 vec_turned_to(vec3 v, vec3 to) /* or its opposite, whichever points there */
{
    return vec_dot(v, to) < 0 ? vec_neg(v) : v;
}
static inline vec3 mat_column(const mat3 *m, int i)
{
    return i == 0 ? m->x : i == 1 ? m->y : m->z;
}

/* ---- a plane's own vectors ---- */

typedef struct plane2 {
    double x, y;
} plane2;

static inline double dot2(plane2 a, plane2 b)
{
    return a.x * b.x + a.y * b.y;
}
static inline double cross2(plane2 a, plane2 b)
{
    return a.x * b.y - a.y * b.x;
}
static inline plane2 sub2(plane2 a, plane2 b)
{
    return (plane2){a.x - b.x, a.y - b.y};
}

#endif
