/* triple: a vector in one register of 32 bytes (lanes.h): x, y, z, and the number that follows it in memory, which is
 * never asked for. The same functions, and bits, as triple_pairs.h: a file takes one of the two. For functions of
 * LANES_WIDE. Plain values. */
#ifndef COLLIDED_NARROW_TRIPLE_WIDE_H
#define COLLIDED_NARROW_TRIPLE_WIDE_H

#include "geom/vec.h"
#include "lanes.h"

typedef lanes triple;

LANES_INLINE triple triple_load(const vec3 *from)
{
    return lanes_load(&from->x);
}

/* The number that follows is written, too. */
LANES_INLINE void triple_store(double *to, triple v)
{
    lanes_store(to, v);
}

LANES_INLINE double triple_x(triple v)
{
    return v[0];
}
LANES_INLINE double triple_y(triple v)
{
    return v[1];
}
LANES_INLINE double triple_z(triple v)
{
    return v[2];
}

LANES_INLINE triple triple_sub(triple a, triple b)
{
    return a - b;
}

LANES_INLINE triple triple_scale(triple v, double by)
{
    lanes factor = {by, by, by, by};
    return v * LANES_ALL(factor, 0); /* as one instruction, which the compiler does not find in lanes_of */
}

LANES_INLINE double triple_norm2(triple v)
{
    lanes squares = v * v;
    return squares[0] + squares[1] + squares[2];
}

/* Of each of the three the sum of its coordinates. */
LANES_INLINE triple triple_sums(triple x, triple y, triple z)
{
    lanes first = __builtin_shufflevector(x, y, 0, 4, 2, 6), second = __builtin_shufflevector(x, y, 1, 5, 3, 7);
    return __builtin_shufflevector(first, z, 0, 1, 4, 5) + __builtin_shufflevector(second, z, 0, 1, 5, 4) +
           __builtin_shufflevector(first, z, 2, 3, 6, 7);
}

/* m' v */
LANES_INLINE triple triple_tmul(const mat3 *m, triple v)
{
    return triple_sums(triple_load(&m->x) * v, triple_load(&m->y) * v, triple_load(&m->z) * v);
}

/* m v */
LANES_INLINE triple triple_mul(const mat3 *m, triple v)
{
    return triple_load(&m->x) * LANES_ALL(v, 0) + triple_load(&m->y) * LANES_ALL(v, 1) +
           triple_load(&m->z) * LANES_ALL(v, 2);
}

static const lane_mask LANES_SIGN = {INT64_MIN, INT64_MIN, INT64_MIN, INT64_MIN};

/* The |coordinates|. */
LANES_INLINE triple triple_abs(triple v)
{
    return (triple)((lane_mask)v & ~LANES_SIGN);
}

/* By coordinates: `size`, or zero where that is not positive, with the sign of the other. */
LANES_INLINE triple triple_signed(triple size, triple sign)
{
    return (triple)(((lane_mask)size & (size > 0)) | ((lane_mask)sign & LANES_SIGN));
}

#endif
