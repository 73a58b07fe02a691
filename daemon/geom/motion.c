/* motion: sine, cosine and angle by polynomials; poses along a motion; how far it carries a shape. Pure; any thread. */
#include "motion.h"

#include "round.h"

#include <stdint.h>

/* ---- sine and cosine ---- */

typedef struct wave {
    double sine, cosine;
} wave;

/* Of |x| <= pi/4, to within 1 ulp: the minimax polynomials of fdlibm's k_sin.c and k_cos.c. */
static wave kernel(double x)
{
    double z = x * x;
    double s =
        8.33333333332248946124e-03 +
        z * (-1.98412698298579493134e-04 +
                z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
    double c = 4.16666666666666019037e-02 +
               z * (-1.38888888888741095749e-03 +
                       z * (2.48015872894767294178e-05 +
                               z * (-2.75573143513906633035e-07 +
                                       z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
    return (wave){x + z * x * (-1.66666666666666324348e-01 + z * s), 1 - (0.5 * z - z * z * c)};
}

/* pi/2 in three parts of 33 bits, so that a multiple below 2^20 of the first two is exact (Cody and Waite). */
static const double HALF_PI_1 = 1.57079632673412561417e+00, HALF_PI_2 = 6.07710050630396597660e-11,
                    HALF_PI_3 = 2.02226624879595063154e-21, TWO_OVER_PI = 6.36619772367581382433e-01;

static wave wave_of(double x)
{
    double turns = x * TWO_OVER_PI;
    int64_t n = (int64_t)(turns + (turns < 0 ? -0.5 : 0.5));
    double k = (double)n, rest = ((x - k * HALF_PI_1) - k * HALF_PI_2) - k * HALF_PI_3;
    wave r = kernel(rest);
    switch ((uint64_t)n & 3) {
    case 0:
        return r;
    case 1:
        return (wave){r.cosine, -r.sine};
    case 2:
        return (wave){-r.sine, -r.cosine};
    default:
        return (wave){-r.cosine, r.sine};
    }
}

/* ---- the angle of a rotation ---- */

/* Arc tangent of 0 <= x <= 1, to within 2 ulp: fdlibm's s_atan.c. */
static double arc_tangent(double x)
{
    static const double A[11] = {3.33333333333329318027e-01, -1.99999999998764832476e-01, 1.42857142725034663711e-01,
        -1.11111104054623557880e-01, 9.09088713343650656196e-02, -7.69187620504482999495e-02,
        6.66107313738753120669e-02, -5.83357013379057348645e-02, 4.97687799461593236017e-02,
        -3.65315727442169155270e-02, 1.62858201153657823623e-02};
    double base = 0;
    if (x >= 0.6875) {
        base = 7.85398163397448278999e-01; /* pi/4 */
        x = (x - 1) / (x + 1);
    } else if (x >= 0.4375) {
        base = 4.63647609000806093515e-01; /* atan 1/2 */
        x = (2 * x - 1) / (2 + x);
    }
    double z = x * x, sum = 0;
    for (int i = 10; i >= 0; i--) sum = sum * z + A[i];
    return base + (x - x * z * sum);
}

/* The angle, 0 to pi, of a rotation whose quaternion has that |w| and that length of (x, y, z). */
static double angle_of(double w, double v)
{
    const double half_pi = 1.57079632679489655800e+00;
    return 2 * (v <= w ? arc_tangent(v / w) : half_pi - arc_tangent(w / v));
}

/* ---- poses ---- */

static bool same_quat(quat a, quat b)
{
    return a.w == b.w && a.x == b.x && a.y == b.y && a.z == b.z;
}

motion motion_between(pose from, pose to, double span)
{
    motion m = {.start = from, .linear = vec_scale(vec_sub(to.p, from.p), 1 / span)};
    if (same_quat(from.q, to.q)) return m; /* nor does rounding turn it: straight ways are cheaper */
    quat turn = quat_mul(to.q, quat_conj(from.q));
    vec3 v = turn.w < 0 ? vec(-turn.x, -turn.y, -turn.z) : vec(turn.x, turn.y, turn.z);
    double length = length_up(v);
    if (length > 0) m.angular = vec_scale(vec_unit(v), angle_of(fabs(turn.w), length) / span);
    return m;
}

motion_spin motion_spin_of(vec3 angular)
{
    if (angular.x == 0 && angular.y == 0 && angular.z == 0) return (motion_spin){VEC_ZERO, 0};
    return (motion_spin){vec_unit(angular), length_up(angular)};
}

quat motion_spun(motion_spin spin, quat start, double time)
{
    if (spin.speed == 0 || time == 0) return start;
    wave half = wave_of(0.5 * spin.speed * time);
    vec3 v = vec_scale(spin.axis, half.sine);
    return quat_unit(quat_mul((quat){half.cosine, v.x, v.y, v.z}, start));
}

mat3 motion_turn(motion_spin spin, double time)
{
    wave half = wave_of(0.5 * spin.speed * time);
    vec3 v = vec_scale(spin.axis, half.sine);
    return quat_matrix((quat){half.cosine, v.x, v.y, v.z});
}

pose motion_pose(const motion *m, double time)
{
    return (pose){vec_madd(m->start.p, time, m->linear), motion_spun(motion_spin_of(m->angular), m->start.q, time)};
}

/* Position: one product, one sum. Turning: the speed and the angle's product by 16 u of the angle, sine and cosine, two
 * products of quaternions and a root by 24 u. */
double motion_error(const motion *m, double time, double reach)
{
    double line = 4 * ROUND_U * (length_up(m->start.p) + 2 * time * length_up(m->linear));
    double angle = time * length_up(m->angular);
    return line + (angle > 0 ? (24 + 16 * angle) * ROUND_U * reach : 0);
}

/* ---- how far it carries a shape ---- */

static double off_axis(vec3 point, vec3 axis)
{
    return length_up(vec_cross(axis, point));
}

/* axis x corner is a sum of what the middle and the three sides give; of opposite corners one is farther off. */
static double corners_off_axis(const shape *s, pose local, vec3 axis)
{
    mat3 r = quat_matrix(local.q);
    vec3 middle = vec_cross(axis, local.p), x = vec_cross(axis, vec_scale(r.x, s->half.x)),
         y = vec_cross(axis, vec_scale(r.y, s->half.y)), z = vec_cross(axis, vec_scale(r.z, s->half.z)), off[4];
    double most2 = 0;
    int most = 0;
    for (int k = 0; k < 4; k++) {
        vec3 side = vec_add(k & 1 ? vec_sub(x, y) : vec_add(x, y), k & 2 ? vec_neg(z) : z);
        off[k] = vec_add(vec_dot(middle, side) < 0 ? vec_neg(side) : side, middle);
        double off2 = vec_norm2(off[k]);
        if (off2 > most2) most2 = off2, most = k;
    }
    if (most2 > 0x1p-800 && most2 < 0x1p800) return length_up(off[most]);
    return fmax(fmax(length_up(off[0]), length_up(off[1])), fmax(length_up(off[2]), length_up(off[3])));
}

/* Points of a box, or of a segment with a disc (cylinders, cones) or a ball around each of its ends. */
double motion_radius(const shape *s, pose local, vec3 axis)
{
    if (s->type == SHAPE_HALFSPACE) return INFINITY;
    if (vec_max_abs(axis) == 0) return 0;
    double slack = 64 * ROUND_U * (length_up(local.p) + shape_reach(s));
    if (s->type == SHAPE_BOX) return corners_off_axis(s, local, axis) + slack;
    vec3 half = vec_scale(quat_matrix(local.q).z, s->half.z);
    double ends = fmax(off_axis(vec_add(local.p, half), axis), off_axis(vec_sub(local.p, half), axis));
    if (s->type == SHAPE_SPHERE || s->type == SHAPE_CAPSULE) return ends + slack;
    if (s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE) return ends + s->half.x + slack;
    return off_axis(local.p, axis) + shape_reach(s) + shape_excess(s) + slack;
}

enum { PIECES_MAX = 16 };
static const double PIECE_ANGLE = 0.5; /* rad: the bulge is then 3 % of the radius */

static aabb aabb_meet(aabb a, aabb b)
{
    return (aabb){vec_max(a.lo, b.lo), vec_min(a.hi, b.hi)};
}

/* No point leaves its chord by more than |angular|^2 radius time^2 / 8, so the boxes at the two ends of a piece, grown
 * by that, hold all between; and so does the ball about the body's origin, drawn along its line. */
aabb motion_bounds(const motion *m, const shape *s, pose local, double span)
{
    double speed = length_up(m->angular), angle = speed * span;
    vec3 axis = quat_rotate(quat_conj(m->start.q), vec_unit(m->angular));
    double reach = length_up(local.p) + shape_reach(s) + shape_excess(s);
    double error = motion_error(m, span, reach) * 2;
    aabb first = shape_bounds(s, pose_mul(m->start, local));
    pose end = motion_pose(m, span);
    if (speed == 0 || isinf(reach)) /* a half-space that turns is without bounds, or upright at both ends by chance */
        return speed > 0 ? (aabb){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}}
                         : aabb_grow(aabb_union(first, shape_bounds(s, pose_mul(end, local))), error);
    vec3 from = m->start.p, to = end.p;
    aabb ball = aabb_grow((aabb){vec_min(from, to), vec_max(from, to)}, reach + error);
    if (!(angle < PIECES_MAX * PIECE_ANGLE)) return ball;
    int pieces = 1 + (int)(angle / PIECE_ANGLE);
    double step = span / pieces, bulge = speed * speed * motion_radius(s, local, axis) * step * step / 8;
    aabb all = first;
    for (int k = 1; k <= pieces; k++)
        all = aabb_union(all, shape_bounds(s, pose_mul(motion_pose(m, k < pieces ? k * step : span), local)));
    return aabb_meet(aabb_grow(all, bulge * (1 + 16 * ROUND_U) + error), ball);
}
