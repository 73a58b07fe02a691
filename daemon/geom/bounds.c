/* Boxes of shapes at poses. Pure; any thread. The box is never smaller than the shape under the exact rotation that the
 * quaternion stands for, and larger by no more than about 1e-14 of its reach. */
#include "bounds.h"

#include "round.h"
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

aabb shape_bounds(const shape *s, pose at)
{
    if (s->type == SHAPE_HALFSPACE) return halfspace_bounds(s, at);
    mat3 r = quat_matrix(at.q);
    const vec3 rows[3] = {{r.x.x, r.y.x, r.z.x}, {r.x.y, r.y.y, r.z.y}, {r.x.z, r.y.z, r.z.z}};
    const double centre[3] = {at.p.x, at.p.y, at.p.z};
    double margin = add_up(add_up(s->radius, shape_excess(s)), rotation_slack(at.q, shape_reach(s)));
    double lo[3], hi[3], up[3], down[3];
    support_spans_up(s, rows, up, down);
    for (int k = 0; k < 3; k++) {
        hi[k] = add_up(centre[k], add_up(up[k], margin));
        lo[k] = -add_up(-centre[k], add_up(down[k], margin));
    }
    return (aabb){{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}};
}
