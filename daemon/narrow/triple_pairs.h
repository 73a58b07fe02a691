/* triple: a vector in registers, in two of 16 bytes (SSE2, NEON): x and y, z and the number that follows it in memory,
 * which is never asked for. Each operation is rounded like a scalar's: the same bits as triple_wide.h, and as vec.h
 * where that has the function. Plain values. */
#ifndef COLLIDED_NARROW_TRIPLE_PAIRS_H
#define COLLIDED_NARROW_TRIPLE_PAIRS_H

#include "geom/vec.h"

#include <stdint.h>

#define TRIPLE_INLINE __attribute__((always_inline)) static inline

typedef double pair __attribute__((vector_size(16)));
typedef double pair_anywhere __attribute__((vector_size(16), aligned(8), may_alias));
typedef int64_t pair_mask __attribute__((vector_size(16)));

typedef struct triple {
    pair xy, z;
} triple;

#define PAIR_OF(a, b, i, j) __builtin_shufflevector(a, b, i, j)

TRIPLE_INLINE triple triple_load(const vec3 *from)
{
    const double *at = &from->x;
    return (triple){*(const pair_anywhere *)at, *(const pair_anywhere *)(at + 2)};
}

/* The number that follows is written, too. */
TRIPLE_INLINE void triple_store(double *to, triple v)
{
    *(pair_anywhere *)to = v.xy;
    *(pair_anywhere *)(to + 2) = v.z;
}

TRIPLE_INLINE double triple_x(triple v)
{
    return v.xy[0];
}
TRIPLE_INLINE double triple_y(triple v)
{
    return v.xy[1];
}
TRIPLE_INLINE double triple_z(triple v)
{
    return v.z[0];
}

TRIPLE_INLINE triple triple_sub(triple a, triple b)
{
    return (triple){a.xy - b.xy, a.z - b.z};
}

TRIPLE_INLINE triple triple_scale(triple v, double by)
{
    pair factor = {by, by};
    return (triple){v.xy * factor, v.z * factor};
}

TRIPLE_INLINE double triple_norm2(triple v)
{
    pair xy = v.xy * v.xy, z = v.z * v.z;
    return xy[0] + xy[1] + z[0];
}

/* m' v */
TRIPLE_INLINE triple triple_tmul(const mat3 *m, triple v)
{
    triple x = triple_load(&m->x), y = triple_load(&m->y), z = triple_load(&m->z);
    pair x_xy = x.xy * v.xy, y_xy = y.xy * v.xy, z_xy = z.xy * v.xy, z_z = z.z * v.z;
    pair first = PAIR_OF(x_xy, y_xy, 0, 2), second = PAIR_OF(x_xy, y_xy, 1, 3);
    pair third = PAIR_OF(x.z * v.z, y.z * v.z, 0, 2);
    return (triple){first + second + third, z_xy + PAIR_OF(z_xy, z_xy, 1, 1) + z_z};
}

/* m v */
TRIPLE_INLINE triple triple_mul(const mat3 *m, triple v)
{
    triple x = triple_load(&m->x), y = triple_load(&m->y), z = triple_load(&m->z);
    pair vx = PAIR_OF(v.xy, v.xy, 0, 0), vy = PAIR_OF(v.xy, v.xy, 1, 1), vz = PAIR_OF(v.z, v.z, 0, 0);
    return (triple){x.xy * vx + y.xy * vy + z.xy * vz, x.z * vx + y.z * vy + z.z * vz};
}

static const pair_mask PAIR_SIGN = {INT64_MIN, INT64_MIN};

/* The |coordinates|. */
TRIPLE_INLINE triple triple_abs(triple v)
{
    return (triple){(pair)((pair_mask)v.xy & ~PAIR_SIGN), (pair)((pair_mask)v.z & ~PAIR_SIGN)};
}

TRIPLE_INLINE pair pair_signed(pair size, pair sign)
{
    return (pair)(((pair_mask)size & (size > 0)) | ((pair_mask)sign & PAIR_SIGN));
}

/* By coordinates: `size`, or zero where that is not positive, with the sign of the other. */
TRIPLE_INLINE triple triple_signed(triple size, triple sign)
{
    return (triple){pair_signed(size.xy, sign.xy), pair_signed(size.z, sign.z)};
}

#endif
