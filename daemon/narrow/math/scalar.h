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

#endif
