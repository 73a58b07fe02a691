/* round: sums and lengths rounded upward, so that a bound stays a bound.
 *
 * Pure; any thread. They never change the rounding mode of the processor: the error of a rounded operation is known
 * exactly (sums) or bounded (lengths), and is put back on top. u = 2^-53 is the rounding unit. */
#ifndef COLLIDED_GEOM_ROUND_H
#define COLLIDED_GEOM_ROUND_H

#include "vec.h"

#include <float.h>
#include <stdint.h>
#include <string.h>

#define ROUND_U (DBL_EPSILON / 2)

/* The least double above x, which is finite: nextafter, as the few instructions that it is. */
static inline double next_above(double x)
{
    int64_t bits;
    if (!(x < 0 || x > 0)) return DBL_TRUE_MIN;
    memcpy(&bits, &x, sizeof bits);
    bits += x > 0 ? 1 : -1;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* The least double that is not below a + b. TwoSum (Knuth) gives the rounding error of the sum exactly. */
static inline double add_up(double a, double b)
{
    double sum = a + b, b_part = sum - a;
    double error = (a - (sum - b_part)) + (b - b_part);
    return error > 0 ? next_above(sum) : sum;
}

/* Not below |a|, and above it by less than 12 u |a|; 0 only for the zero vector. Scaling by a power of two first keeps
 * the squares in range; squares, sums and root then err by less than 3 u. */
static inline double length_up(vec3 a)
{
    double norm2 = vec_norm2(a), most;
    if (norm2 > 0x1p-800 && norm2 < 0x1p800) return sqrt(norm2) * (1 + 8 * ROUND_U); /* in range: the same bits */
    most = vec_max_abs(a);
    if (most == 0) return 0;
    int exponent;
    frexp(most, &exponent);
    vec3 scaled = {ldexp(a.x, -exponent), ldexp(a.y, -exponent), ldexp(a.z, -exponent)};
    double length = ldexp(vec_norm(scaled) * (1 + 8 * ROUND_U), exponent);
    return length + DBL_TRUE_MIN; /* the last: ldexp rounds where the result is subnormal */
}

#endif
