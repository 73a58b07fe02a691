/* oracle: 113-bit support functions and a compass search over directions. */
#include "oracle.h"

static const real UNBOUNDED = 1e4000Q;

real real_sqrt(real x)
{
    if (!(x > 0)) return 0;
    if (x > UNBOUNDED) return x;
    real scale = 1;
    while (x > 0x1p200Q) x *= 0x1p-200Q, scale *= 0x1p100Q;
    while (x < 0x1p-200Q) x *= 0x1p200Q, scale *= 0x1p-100Q;
    real r = sqrt((double)x);
    r = (r + x / r) / 2;
    r = (r + x / r) / 2;
    return r * scale;
}

real3 real3_of(vec3 v)
{
    return (real3){v.x, v.y, v.z};
}
real real3_dot(real3 a, real3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
real3 real3_sub(real3 a, real3 b)
{
    return (real3){a.x - b.x, a.y - b.y, a.z - b.z};
}
real3 real3_scale(real3 a, real s)
{
    return (real3){a.x * s, a.y * s, a.z * s};
}
real3 real3_cross(real3 a, real3 b)
{
    return (real3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static real3 add(real3 a, real3 b)
{
    return (real3){a.x + b.x, a.y + b.y, a.z + b.z};
}
static real norm(real3 a)
{
    return real_sqrt(real3_dot(a, a));
}
static real magnitude(real x)
{
    return x < 0 ? -x : x;
}

placed oracle_place(const shape *s, pose at, vec3 origin)
{
    real w = at.q.w, x = at.q.x, y = at.q.y, z = at.q.z, n = 2 / (w * w + x * x + y * y + z * z);
    return (placed){s, {1 - n * (y * y + z * z), n * (x * y + w * z), n * (x * z - w * y)},
        {n * (x * y - w * z), 1 - n * (x * x + z * z), n * (y * z + w * x)},
        {n * (x * z + w * y), n * (y * z - w * x), 1 - n * (x * x + y * y)},
        real3_sub(real3_of(at.p), real3_of(origin))};
}

real3 oracle_point(const placed *s, real3 v)
{
    return add(add(real3_scale(s->rx, v.x), real3_scale(s->ry, v.y)), add(real3_scale(s->rz, v.z), s->p));
}

static real3 to_local(const placed *s, real3 n)
{
    return (real3){real3_dot(s->rx, n), real3_dot(s->ry, n), real3_dot(s->rz, n)};
}

static real core_height(const shape *s, real3 n)
{
    real hx = s->half.x, hy = s->half.y, hz = s->half.z, best = -UNBOUNDED;
    real ring = real_sqrt(n.x * n.x + n.y * n.y);
    switch (s->type) {
    case SHAPE_CAPSULE:
        return hz * magnitude(n.z);
    case SHAPE_BOX:
        return hx * magnitude(n.x) + hy * magnitude(n.y) + hz * magnitude(n.z);
    case SHAPE_CYLINDER:
        return hx * ring + hz * magnitude(n.z);
    case SHAPE_CONE:
        return hz * n.z > hx * ring - hz * n.z ? hz * n.z : hx * ring - hz * n.z;
    case SHAPE_ELLIPSOID:
        return norm((real3){hx * n.x, hy * n.y, hz * n.z});
    case SHAPE_HALFSPACE: {
        real tilt = magnitude(n.x) + magnitude(n.y);
        return n.z > 0 && tilt <= 1e-13Q * n.z ? 0 : UNBOUNDED;
    }
    case SHAPE_HULL:
        for (uint32_t i = 0; i < s->hull->vertex_count; i++) {
            real h = real3_dot(n, real3_of(hull_vertex(s->hull, i)));
            best = h > best ? h : best;
        }
        return best;
    default:
        return 0;
    }
}

real oracle_height(const placed *s, real3 n)
{
    return core_height(s->s, to_local(s, n)) + real3_dot(n, s->p) + s->s->radius * norm(n);
}

real oracle_separation(const placed *a, const placed *b, real3 n)
{
    n = real3_scale(n, 1 / norm(n));
    return -oracle_height(b, real3_scale(n, -1)) - oracle_height(a, n);
}

static real3 unit3(real3 n)
{
    return real3_scale(n, 1 / norm(n));
}

enum { CLIMB_STEPS = 160 }; /* on a ridge a climb gains ever less: what it has found by then is still a bound */

/* Steps of shrinking length in four directions of the tangent plane, turned by 45 degrees from one length to the next,
 * for as long as one of them gains. */
static real climb(const placed *a, const placed *b, real3 n)
{
    static const double C[8] = {1, 0, -1, 0, .7, -.7, -.7, .7}, S[8] = {0, 1, 0, -1, .7, .7, -.7, -.7};
    real best = oracle_separation(a, b, n);
    int turned = 0;
    double step = 0.2;
    for (int left = CLIMB_STEPS; left > 0 && step > 1e-6; left--) {
        real3 other = magnitude(n.x) < 0.6Q ? (real3){1, 0, 0} : (real3){0, 1, 0};
        real3 u = unit3(real3_cross(n, other)), v = real3_cross(n, u), top = n;
        bool gained = false;
        for (int k = turned; k < turned + 4; k++) {
            real3 m = unit3(add(n, add(real3_scale(u, C[k] * step), real3_scale(v, S[k] * step))));
            real s = oracle_separation(a, b, m);
            if (s > best) best = s, top = m, gained = true;
        }
        n = top;
        turned = 4 - turned;
        if (!gained && turned == 0) step /= 2.5;
    }
    return best;
}

real oracle_search(const placed *a, const placed *b)
{
    enum { STARTS = 64, CLIMBS = 2 };
    real best = -UNBOUNDED, value[STARTS];
    real3 n[STARTS];
    for (int i = 0; i < STARTS; i++) { /* a Fibonacci lattice on the sphere */
        double z = 1 - (2 * i + 1.0) / STARTS, r = sqrt(1 - z * z), angle = 2.399963229728653 * i;
        n[i] = (real3){r * cos(angle), r * sin(angle), z};
        value[i] = oracle_separation(a, b, n[i]);
    }
    for (int c = 0; c < CLIMBS; c++) {
        int top = 0;
        for (int i = 1; i < STARTS; i++)
            if (value[i] > value[top]) top = i;
        real s = climb(a, b, n[top]);
        best = s > best ? s : best;
        for (int i = 0; i < STARTS; i++) /* the next climb starts elsewhere */
            if (real3_dot(n[i], n[top]) > 0.9Q) value[i] = -UNBOUNDED;
    }
    return best;
}

/* Distance of (r, z), r >= 0, from the hull of {(0, h), (r, h) or nothing, (r, -h), (0, -h)}, from below: by its edges'
 * lines. */
static real outside_profile(const shape *s, real r, real z)
{
    real h = s->half.z, R = s->half.x, side = r - R;
    if (s->type == SHAPE_CONE) {
        real length = real_sqrt(4 * h * h + R * R);
        side = length > 0 ? (2 * h * r + R * (z - h)) / length : r;
    }
    real top = z - h, bottom = -h - z, most = side > top ? side : top;
    return most > bottom ? most : bottom;
}

/* Radially, times the least axis; beside axes of no length as far as the point is off along those. */
static real outside_ellipsoid(vec3 half, real3 x)
{
    const double h[3] = {half.x, half.y, half.z};
    const real at[3] = {x.x, x.y, x.z};
    real least = UNBOUNDED, k2 = 0, off2 = 0;
    for (int i = 0; i < 3; i++) {
        if (h[i] > 0) k2 += (at[i] / h[i]) * (at[i] / h[i]);
        if (h[i] > 0 && h[i] < least) least = h[i];
        if (!(h[i] > 0)) off2 += at[i] * at[i];
    }
    real radial = k2 > 0 ? (real_sqrt(k2) - 1) * least : 0, off = real_sqrt(off2);
    return off > radial ? off : radial;
}

static real outside_core(const shape *s, real3 x)
{
    real ax = magnitude(x.x) - s->half.x, ay = magnitude(x.y) - s->half.y, az = magnitude(x.z) - s->half.z;
    real most = ax > ay ? ax : ay, worst = -UNBOUNDED;
    real3 over = {0, 0, az > 0 ? az : 0};
    switch (s->type) {
    case SHAPE_CAPSULE:
        return norm((real3){x.x, x.y, over.z});
    case SHAPE_BOX:
        return most > az ? most : az;
    case SHAPE_CYLINDER:
    case SHAPE_CONE:
        return outside_profile(s, real_sqrt(x.x * x.x + x.y * x.y), x.z);
    case SHAPE_ELLIPSOID:
        return outside_ellipsoid(s->half, x);
    case SHAPE_HALFSPACE:
        return x.z;
    case SHAPE_HULL:
        for (uint32_t i = 0; i < s->hull->face_count; i++) {
            const hull_face *f = &s->hull->faces[i];
            real out = real3_dot(real3_of(f->normal), x) - f->offset;
            worst = out > worst ? out : worst;
        }
        return worst;
    default:
        return norm(x);
    }
}

real oracle_outside(const placed *s, vec3 point)
{
    real out = outside_core(s->s, to_local(s, real3_sub(real3_of(point), s->p))) - s->s->radius;
    return out > 0 ? out : 0;
}
