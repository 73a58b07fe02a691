/* verify_shape: support and distance of single shapes. All shapes are a convex core within whose radius all points
 * count; the functions on the core work in its own frame. */
#include "verify_shape.h"

#include <math.h>
#include <string.h>

real length(vec a)
{
    return sqrtl(dot(a, a));
}

static real larger(real a, real b)
{
    return a > b ? a : b;
}
static real outside(real x, real half)
{
    return larger(fabsl(x) - half, 0);
} /* of [-half, half] */

/* ---- placing ---- */

static bool all_finite(const double *x, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

typedef struct quat {
    real w, x, y, z;
} quat;

static bool quat_of(const collided_pose *pose, quat *q)
{
    const double *o = pose->orientation;
    if (!all_finite(pose->position, 3) || !all_finite(o, 4)) return false;
    real norm = sqrtl((real)o[0] * o[0] + (real)o[1] * o[1] + (real)o[2] * o[2] + (real)o[3] * o[3]);
    if (!(fabsl(norm - 1) < 1e-3L)) return false;
    *q = (quat){o[0] / norm, o[1] / norm, o[2] / norm, o[3] / norm};
    return true;
}

/* v + 2 w (q x v) + 2 q x (q x v), q being the vector part. */
static vec turned(quat q, vec v)
{
    vec u = {q.x, q.y, q.z};
    vec t = scale(2, cross(u, v));
    return add(v, add(scale(q.w, t), cross(u, t)));
}

bool placed_make(placed *p, const collided_shape *shape, const collided_pose *body, const double *points, size_t count)
{
    quat world, local;
    bool is_hull = shape->type == COLLIDED_HULL;
    bool sizes = all_finite(shape->half, 3) && isfinite(shape->radius) && shape->radius >= 0 &&
                 isfinite(shape->deviation) && shape->deviation >= 0 && shape->half[0] >= 0 && shape->half[1] >= 0 &&
                 shape->half[2] >= 0;
    if (shape->type == COLLIDED_MESH || !sizes || !quat_of(body, &world) || !quat_of(&shape->pose, &local))
        return false;
    if (is_hull && (!points || !count || !all_finite(points, 3 * count))) return false;
    *p = (placed){.shape = shape, .points = points, .point_count = is_hull ? count : 0, .body = vec_of(body->position)};
    const vec axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; i++) p->columns[i] = turned(world, turned(local, axes[i]));
    p->origin = turned(world, vec_of(shape->pose.position));
    return true;
}

static vec into_shape(const placed *p, vec v)
{
    return (vec){dot(p->columns[0], v), dot(p->columns[1], v), dot(p->columns[2], v)};
}

vec placed_normal(const placed *p)
{
    return p->columns[2];
}

real placed_reach(const placed *p)
{
    real core = length(vec_of(p->shape->half));
    for (size_t i = 0; i < p->point_count; i++) core = larger(core, length(vec_of(p->points + 3 * i)));
    return length(p->origin) + core + p->shape->radius;
}

/* ---- support of the core along a direction in its frame ---- */

static real hull_support(const placed *p, vec d)
{
    real best = -INFINITY;
    for (size_t i = 0; i < p->point_count; i++) best = larger(best, dot(d, vec_of(p->points + 3 * i)));
    return best;
}

static real core_support(const placed *p, vec d)
{
    const double *h = p->shape->half;
    real rho = sqrtl(d.x * d.x + d.y * d.y);
    switch (p->shape->type) {
    case COLLIDED_SPHERE:
        return 0;
    case COLLIDED_CAPSULE:
        return h[2] * fabsl(d.z);
    case COLLIDED_BOX:
        return h[0] * fabsl(d.x) + h[1] * fabsl(d.y) + h[2] * fabsl(d.z);
    case COLLIDED_CYLINDER:
        return h[0] * rho + h[2] * fabsl(d.z);
    case COLLIDED_CONE:
        return larger(h[2] * d.z, h[0] * rho - h[2] * d.z);
    case COLLIDED_ELLIPSOID:
        return length((vec){h[0] * d.x, h[1] * d.y, h[2] * d.z});
    case COLLIDED_HALFSPACE:
        return 0;
    case COLLIDED_HULL:
        return hull_support(p, d);
    case COLLIDED_MESH: /* placed_make takes none */
        break;
    }
    return INFINITY;
}

real placed_support(const placed *p, vec n)
{
    return dot(n, p->origin) + core_support(p, into_shape(p, n)) + p->shape->radius;
}

/* ---- distance of a point from the core, in its frame ---- */

/* In the half plane (distance from the axis, height): the cone is a triangle. */
static real cone_distance(vec q, real r, real h)
{
    real rho = sqrtl(q.x * q.x + q.y * q.y);
    if (q.z >= -h && rho * 2 * h <= r * (h - q.z)) return 0;
    real base = hypotl(larger(rho - r, 0), q.z + h);
    real along = (-r * (rho - r) + 2 * h * (q.z + h)) / (r * r + 4 * h * h); /* on the slant from rim (0) to apex (1) */
    along = along < 0 ? 0 : along > 1 ? 1 : along;
    real slant = hypotl(rho - (1 - along) * r, q.z + h - along * 2 * h);
    return base < slant ? base : slant;
}

/* The closest point of the surface is x_i = a_i^2 q_i / (a_i^2 + t), with t where sum (x_i / a_i)^2 = 1 (Eberly,
 * Distance from a Point to an Ellipsoid). The sum falls with t, so bisection finds it. */
static real ellipsoid_distance(vec q, const double a[3])
{
    const real p[] = {q.x, q.y, q.z};
    real low = 0, high = 0;
    for (int i = 0; i < 3; i++) high += a[i] * fabsl(p[i]);
    for (int step = 0; step < 160; step++) {
        real t = (low + high) / 2, sum = 0;
        for (int i = 0; i < 3; i++) {
            real x = a[i] * p[i] / (a[i] * (real)a[i] + t);
            sum += p[i] != 0 ? x * x : 0;
        }
        if (sum > 1)
            low = t;
        else
            high = t;
    }
    real square = 0;
    for (int i = 0; i < 3; i++) {
        real away = p[i] != 0 ? p[i] * high / (a[i] * (real)a[i] + high) : 0;
        square += away * away;
    }
    return sqrtl(square);
}

/* ---- hulls: the point of a hull that is nearest to the origin, by GJK over all sub-simplices ---- */

typedef struct simplex {
    vec at[4];
    int count;
} simplex;

static real det3(vec a, vec b, vec c)
{
    return dot(a, cross(b, c));
}

/* Nearest point to the origin of the plane, line or point through the vertices chosen by `mask`; false unless it lies
 * within them. The normal equations of at most three unknowns, by Cramer's rule. */
static bool nearest_inside(const simplex *s, unsigned mask, vec *nearest)
{
    vec y[4];
    int n = 0;
    for (int i = 0; i < s->count; i++)
        if (mask >> i & 1) y[n++] = s->at[i];
    vec e[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    for (int i = 1; i < n; i++) e[i - 1] = sub(y[i], y[0]);
    /* Unused unknowns get the identity, so that one formula serves all. */
    vec row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    real right[3] = {0, 0, 0};
    for (int i = 0; i < n - 1; i++) {
        row[i] = (vec){dot(e[i], e[0]), dot(e[i], e[1]), dot(e[i], e[2])};
        right[i] = -dot(e[i], y[0]);
    }
    vec b = {right[0], right[1], right[2]};
    vec c0 = {row[0].x, row[1].x, row[2].x}, c1 = {row[0].y, row[1].y, row[2].y}, c2 = {row[0].z, row[1].z, row[2].z};
    real det = det3(c0, c1, c2);
    if (!(det > 0)) return false; /* Gram determinants are positive; zero: the vertices are degenerate */
    real w[] = {det3(b, c1, c2) / det, det3(c0, b, c2) / det, det3(c0, c1, b) / det};
    real first = 1;
    *nearest = y[0];
    for (int i = 0; i < n - 1; i++) {
        if (w[i] < 0) return false;
        first -= w[i];
        *nearest = add(*nearest, scale(w[i], e[i]));
    }
    return first >= 0;
}

/* The simplex shrinks to the vertices that carry its nearest point. */
static vec shrink(simplex *s)
{
    vec best = s->at[s->count - 1], v;
    unsigned kept = 1u << (s->count - 1);
    for (unsigned mask = 1; mask < 1u << s->count; mask++) {
        if (!nearest_inside(s, mask, &v) || !(dot(v, v) < dot(best, best))) continue;
        best = v;
        kept = mask;
    }
    simplex smaller = {.count = 0};
    for (int i = 0; i < s->count; i++)
        if (kept >> i & 1) smaller.at[smaller.count++] = s->at[i];
    *s = smaller;
    return best;
}

static vec hull_point(const placed *p, vec q, vec d)
{
    vec best = {0, 0, 0};
    real most = -INFINITY;
    for (size_t i = 0; i < p->point_count; i++) {
        vec v = sub(vec_of(p->points + 3 * i), q);
        if (dot(v, d) <= most) continue;
        most = dot(v, d);
        best = v;
    }
    return best;
}

/* Each step's point is in the hull, so that stopping early gives a distance that is too large, never one too small. */
static real hull_distance(const placed *p, vec q)
{
    enum { STEPS = 256 };
    simplex s = {.at = {sub(vec_of(p->points), q)}, .count = 1};
    vec v = s.at[0];
    for (int step = 0; step < STEPS && s.count < 4; step++) {
        vec w = hull_point(p, q, scale(-1, v));
        real gain = dot(v, v) - dot(v, w);
        if (!(gain > 4 * (real)0x1p-64 * dot(v, v))) break;
        s.at[s.count++] = w;
        vec closer = shrink(&s);
        if (!(dot(closer, closer) < dot(v, v))) break;
        v = closer;
    }
    return length(v);
}

real placed_distance(const placed *p, vec world)
{
    const double *h = p->shape->half;
    vec q = into_shape(p, sub(sub(world, p->body), p->origin));
    real rho = sqrtl(q.x * q.x + q.y * q.y), core = INFINITY;
    switch (p->shape->type) {
    case COLLIDED_SPHERE:
        core = length(q);
        break;
    case COLLIDED_CAPSULE:
        core = hypotl(rho, outside(q.z, h[2]));
        break;
    case COLLIDED_BOX:
        core = length((vec){outside(q.x, h[0]), outside(q.y, h[1]), outside(q.z, h[2])});
        break;
    case COLLIDED_CYLINDER:
        core = hypotl(outside(rho, h[0]), outside(q.z, h[2]));
        break;
    case COLLIDED_CONE:
        core = cone_distance(q, h[0], h[2]);
        break;
    case COLLIDED_ELLIPSOID:
        core = ellipsoid_distance(q, h);
        break;
    case COLLIDED_HALFSPACE:
        core = larger(q.z, 0);
        break;
    case COLLIDED_HULL:
        core = hull_distance(p, q);
        break;
    case COLLIDED_MESH:
        break;
    }
    return larger(core - p->shape->radius, 0);
}
