/* vec: vectors, quaternions, rotations and poses in doubles. Plain values, no memory, no state.
 *
 * No libm transcendentals: only + - * / and sqrt, which IEEE 754 rounds correctly, so that every compiler and every
 * worker count gets the same bits (the build sets -ffp-contract=off). Frames are right-handed; a pose maps a point of
 * its own frame to the outer one: x_outer = R(q) x + p. */
#ifndef COLLIDED_GEOM_VEC_H
#define COLLIDED_GEOM_VEC_H

#include <math.h>
#include <stdbool.h>

typedef struct vec3 {
    double x, y, z;
} vec3;

typedef struct quat { /* a rotation when its norm is 1; (w, x, y, z) */
    double w, x, y, z;
} quat;

typedef struct mat3 { /* columns: the images of the unit vectors */
    vec3 x, y, z;
} mat3;

typedef struct pose {
    vec3 p;
    quat q;
} pose;

typedef struct transform { /* a pose, made ready for many points */
    mat3 r;
    vec3 t;
} transform;

static const vec3 VEC_ZERO = {0, 0, 0};
static const pose POSE_IDENTITY = {{0, 0, 0}, {1, 0, 0, 0}};

static inline vec3 vec(double x, double y, double z)
{
    return (vec3){x, y, z};
}
static inline vec3 vec_add(vec3 a, vec3 b)
{
    return (vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static inline vec3 vec_sub(vec3 a, vec3 b)
{
    return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static inline vec3 vec_neg(vec3 a)
{
    return (vec3){-a.x, -a.y, -a.z};
}
static inline vec3 vec_scale(vec3 a, double s)
{
    return (vec3){a.x * s, a.y * s, a.z * s};
}
static inline vec3 vec_madd(vec3 a, double s, vec3 b)
{
    return (vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static inline bool vec_equal(vec3 a, vec3 b) /* -0 and 0 are equal */
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}
static inline double vec_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static inline vec3 vec_cross(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline double vec_norm2(vec3 a)
{
    return vec_dot(a, a);
}
static inline double vec_norm(vec3 a)
{
    return sqrt(vec_dot(a, a));
}
static inline double vec_max_abs(vec3 a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}
static inline bool vec_finite(vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}
static inline vec3 vec_min(vec3 a, vec3 b)
{
    return (vec3){fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z)};
}
static inline vec3 vec_max(vec3 a, vec3 b)
{
    return (vec3){fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z)};
}

/* a / |a|, for |a| anywhere between the least and the greatest double; the zero vector stays zero. */
static inline vec3 vec_unit(vec3 a)
{
    double m = vec_max_abs(a);
    if (!(m > 0)) return VEC_ZERO;
    vec3 s = {a.x / m, a.y / m, a.z / m};
    return vec_scale(s, 1 / vec_norm(s));
}

static inline quat quat_mul(quat a, quat b)
{
    return (quat){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}
static inline quat quat_conj(quat a)
{
    return (quat){a.w, -a.x, -a.y, -a.z};
}
static inline double quat_norm2(quat a)
{
    return a.w * a.w + a.x * a.x + a.y * a.y + a.z * a.z;
}
static inline quat quat_unit(quat a)
{
    double s = 1 / sqrt(quat_norm2(a));
    return (quat){a.w * s, a.x * s, a.y * s, a.z * s};
}

/* As quat_unit, which leaves less than 8 roundoffs of the squared norm; what is within them already stays as it is, so
 * that a pose that was read and is sent back does not change. */
static inline bool quat_is_settled(quat a)
{
    return fabs(quat_norm2(a) - 1) <= 0x1p-50;
}
static inline quat quat_settled(quat a)
{
    return quat_is_settled(a) ? a : quat_unit(a);
}

/* The rotation matrix of a quaternion of about unit length. With |q|^2 = s the factor is 2 / s, or 2 (2 - s) but for
 * 2 (s - 1)^2: a factor of 2 would be off by the s - 1 that quat_settled lets pass, up to 16 roundoffs of the matrix.
 */
static inline mat3 quat_matrix(quat q)
{
    double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z, k = 4 - 2 * (q.w * q.w + xx + (yy + zz));
    return (mat3){{1 - k * (yy + zz), k * (xy + wz), k * (xz - wy)}, {k * (xy - wz), 1 - k * (xx + zz), k * (yz + wx)},
        {k * (xz + wy), k * (yz - wx), 1 - k * (xx + yy)}};
}

static inline vec3 mat_mul(mat3 m, vec3 v) /* m v */
{
    return (vec3){m.x.x * v.x + m.y.x * v.y + m.z.x * v.z, m.x.y * v.x + m.y.y * v.y + m.z.y * v.z,
        m.x.z * v.x + m.y.z * v.y + m.z.z * v.z};
}
static inline vec3 mat_tmul(mat3 m, vec3 v)
{
    return (vec3){vec_dot(m.x, v), vec_dot(m.y, v), vec_dot(m.z, v)};
} /* m^T v */

static inline vec3 quat_rotate(quat q, vec3 v)
{
    return mat_mul(quat_matrix(q), v);
}

static inline transform pose_transform(pose p)
{
    return (transform){quat_matrix(p.q), p.p};
}
static inline vec3 transform_point(const transform *t, vec3 v)
{
    return vec_add(mat_mul(t->r, v), t->t);
}
static inline vec3 pose_point(pose p, vec3 v)
{
    return vec_add(quat_rotate(p.q, v), p.p);
}
static inline pose pose_mul(pose a, pose b)
{
    return (pose){pose_point(a, b.p), quat_mul(a.q, b.q)};
} /* first b, then a */

/* B's pose in A's frame. The difference of the positions is taken first, so precision follows the size of the pair. */
static inline pose pose_relative(pose a, pose b)
{
    quat inverse = quat_conj(a.q);
    return (pose){quat_rotate(inverse, vec_sub(b.p, a.p)), quat_mul(inverse, b.q)};
}

#endif
