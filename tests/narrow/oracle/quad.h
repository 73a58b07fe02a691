/* quad: vectors in 113-bit arithmetic, for the oracles of the tests. Pure; nothing here is shared with the engine.
 *
 * The exponent reaches 1e+-4932, so no square of a double overflows or underflows. Only + - * / and a square root made
 * from long double's by one Newton step: no libquadmath is needed, with gcc or clang. */
#ifndef COLLIDED_TESTS_ORACLE_QUAD_H
#define COLLIDED_TESTS_ORACLE_QUAD_H

#include <math.h>

#if __LDBL_MANT_DIG__ == 113
typedef long double quad; /* aarch64 */
#else
typedef __float128 quad; /* x86-64 */
#endif

typedef struct qvec {
    quad x, y, z;
} qvec;

typedef struct qmat { /* rows */
    qvec x, y, z;
} qmat;

static inline quad q_abs(quad a)
{
    return a < 0 ? -a : a;
}
static inline quad q_max(quad a, quad b)
{
    return a > b ? a : b;
}
static inline quad q_min(quad a, quad b)
{
    return a < b ? a : b;
}

/* 64 correct bits from sqrtl, doubled by Newton. */
static inline quad q_sqrt(quad a)
{
    if (!(a > 0)) return 0;
    quad root = sqrtl((long double)a);
    return (root + a / root) / 2;
}

static inline qvec qv(quad x, quad y, quad z)
{
    return (qvec){x, y, z};
}
static inline qvec q_add(qvec a, qvec b)
{
    return (qvec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline qvec q_sub(qvec a, qvec b)
{
    return (qvec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline qvec q_neg(qvec a)
{
    return (qvec){-a.x, -a.y, -a.z};
}
static inline qvec q_scale(qvec a, quad s)
{
    return (qvec){a.x * s, a.y * s, a.z * s};
}
static inline quad q_dot(qvec a, qvec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline qvec q_cross(qvec a, qvec b)
{
    return (qvec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline quad q_norm(qvec a)
{
    return q_sqrt(q_dot(a, a));
}
static inline quad q_max_abs(qvec a)
{
    return q_max(q_abs(a.x), q_max(q_abs(a.y), q_abs(a.z)));
}

/* a / |a|; the zero vector stays zero. */
static inline qvec q_unit(qvec a)
{
    quad norm = q_norm(a);
    return norm > 0 ? q_scale(a, 1 / norm) : a;
}

static inline qvec q_mul(qmat m, qvec v)
{
    return (qvec){q_dot(m.x, v), q_dot(m.y, v), q_dot(m.z, v)};
}
static inline qvec q_tmul(qmat m, qvec v) /* transposed(m) v */
{
    return q_add(q_add(q_scale(m.x, v.x), q_scale(m.y, v.y)), q_scale(m.z, v.z));
}

#endif
