/* Boxes of shapes at poses. Pure; any thread. The box is never smaller than the shape under the exact rotation that the
 * quaternion stands for, and larger by no more than about 1e-14 of its reach. */
#include "bounds.h"

#include "round.h"
#include "simd.h"
#include "support.h"

/* The computed matrix differs from the rotation meant by the quaternion: by rounding (each element by at most 4 u, so a
 * point at distance 1 moves by at most 12 u) and, where |q|^2 = s is not 1, by |s - 1| |R - I| <= 2 |s - 1|. */
static double rotation_slack(quat q, double reach)
{
    double off_unit = fabs(quat_norm2(q) - 1) + 4 * ROUND_U;
    return (16 * ROUND_U + 2 * off_unit) * reach;
}

static aabb halfspace_bounds(const shape *s, pose at)
{
    aabb b = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    vec3 n = quat_matrix(at.q).z;
    if (n.y == 0 && n.z == 0) {
        if (n.x > 0) b.hi.x = add_up(at.p.x, s->radius);
        if (n.x < 0) b.lo.x = -add_up(-at.p.x, s->radius);
    }
    if (n.x == 0 && n.z == 0) {
        if (n.y > 0) b.hi.y = add_up(at.p.y, s->radius);
        if (n.y < 0) b.lo.y = -add_up(-at.p.y, s->radius);
    }
    if (n.x == 0 && n.y == 0) {
        if (n.z > 0) b.hi.z = add_up(at.p.z, s->radius);
        if (n.z < 0) b.lo.z = -add_up(-at.p.z, s->radius);
    }
    return b;
}

/* add_up of two numbers at a time. A sum of zero is exact: it is not stepped. */
static inline two add_up_two(two a, two b)
{
    two sum = a + b, b_part = sum - a, error = (a - (sum - b_part)) + (b - b_part);
    const two zero = {0, 0};
    return (two)((two_masks)sum + ((error > zero) & ((sum < zero) | 1)));
}

aabb shape_bounds(const shape *s, pose at)
{
    if (s->type == SHAPE_HALFSPACE) return halfspace_bounds(s, at);
    if (s->type == SHAPE_SOFT) return s->span ? (aabb){s->span[0], s->span[1]} : (aabb){VEC_ZERO, VEC_ZERO};
    mat3 r = quat_matrix(at.q);
    const vec3 rows[3] = {{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}};
    double margin = add_up(add_up(s->radius, shape_excess(s)), rotation_slack(at.q, shape_reach(s)));
    const two margins = {margin, margin};
    double up[3], down[3];
    support_spans_up(s, rows, up, down);
    two x = add_up_two((two){-at.p.x, at.p.x}, add_up_two((two){down[0], up[0]}, margins));
    two y = add_up_two((two){-at.p.y, at.p.y}, add_up_two((two){down[1], up[1]}, margins));
    two z = add_up_two((two){-at.p.z, at.p.z}, add_up_two((two){down[2], up[2]}, margins));
    return (aabb){{-x[0], -y[0], -z[0]}, {x[1], y[1], z[1]}};
}
