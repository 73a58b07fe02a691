/* Brute force over pairs of triangles. */
#include "brute.h"

typedef struct quad3 {
    quad x, y, z;
} quad3;

static quad3 minus(quad3 a, quad3 b)
{
    return (quad3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static quad3 step(quad3 a, quad s, quad3 b)
{
    return (quad3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}
static quad dot(quad3 a, quad3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static quad3 cross(quad3 a, quad3 b)
{
    return (quad3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static quad clamp(quad x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}
static quad root(quad x) /* Newton from the double's root */
{
    if (!(x > 0)) return 0;
    quad r = (quad)sqrt((double)x);
    if (!(r > 0)) return 0;
    for (int i = 0; i < 3; i++) r = (r + x / r) / 2;
    return r;
}

static quad point_segment2(quad3 p, quad3 a, quad3 b)
{
    quad3 e = minus(b, a);
    quad ee = dot(e, e); /* 0: of a triangle without area */
    quad3 d = minus(p, step(a, ee > 0 ? clamp(dot(minus(p, a), e) / ee) : 0, e));
    return dot(d, d);
}

static quad segments2(quad3 a, quad3 b, quad3 c, quad3 d)
{
    quad3 u = minus(b, a), v = minus(d, c), w = minus(a, c);
    quad least = point_segment2(a, c, d),
         other[3] = {point_segment2(b, c, d), point_segment2(c, a, b), point_segment2(d, a, b)};
    for (int i = 0; i < 3; i++)
        if (other[i] < least) least = other[i];
    quad uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), uw = dot(u, w), vw = dot(v, w), det = uu * vv - uv * uv;
    if (!(det > 0)) return least;
    quad s = (uv * vw - vv * uw) / det, t = (uu * vw - uv * uw) / det;
    if (s < 0 || s > 1 || t < 0 || t > 1) return least;
    quad3 apart = minus(step(a, s, u), step(c, t, v));
    return dot(apart, apart) < least ? dot(apart, apart) : least;
}

/* Over the triangle, or from its sides. */
static quad point_triangle2(quad3 p, const quad3 t[3])
{
    quad3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    quad nn = dot(n, n), least = point_segment2(p, t[0], t[1]);
    bool over = nn > 0;
    for (int k = 0; k < 3; k++) {
        quad side = point_segment2(p, t[k], t[(k + 1) % 3]);
        if (side < least) least = side;
        if (dot(cross(minus(t[(k + 1) % 3], t[k]), minus(p, t[k])), n) < 0) over = false;
    }
    quad height = dot(minus(p, t[0]), n);
    if (over && height * height / nn < least) least = height * height / nn;
    return least;
}

static bool pierces(quad3 a, quad3 b, const quad3 t[3])
{
    quad3 n = cross(minus(t[1], t[0]), minus(t[2], t[0]));
    quad ha = dot(minus(a, t[0]), n), hb = dot(minus(b, t[0]), n);
    if ((ha > 0) == (hb > 0) || ha == hb) return false;
    quad3 p = step(a, ha / (ha - hb), minus(b, a));
    for (int k = 0; k < 3; k++)
        if (dot(cross(minus(t[(k + 1) % 3], t[k]), minus(p, t[k])), n) < 0) return false;
    return true;
}

static quad triangles2(const quad3 a[3], const quad3 b[3])
{
    quad least = point_triangle2(a[0], b);
    for (int i = 0; i < 3; i++) {
        if (pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a)) return 0;
        quad over_b = point_triangle2(a[i], b), over_a = point_triangle2(b[i], a);
        if (over_b < least) least = over_b;
        if (over_a < least) least = over_a;
        for (int k = 0; k < 3; k++) {
            quad sides = segments2(a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]);
            if (sides < least) least = sides;
        }
    }
    return least;
}

static void corners_of(const soup *s, size_t t, quad3 out[3])
{
    for (size_t k = 0; k < 3; k++) {
        const double *p = s->points + 3 * (size_t)s->corners[3 * t + k];
        out[k] = (quad3){p[0], p[1], p[2]};
    }
}

static quad3 place(const pose *at, quad3 v)
{
    quad w = at->q.w, x = at->q.x, y = at->q.y, z = at->q.z, n2 = w * w + x * x + y * y + z * z;
    quad3 u = {x, y, z}, c = cross(u, v), cc = cross(u, c);
    quad3 turned = step(step(v, 2 * w / n2, c), 2 / n2, cc);
    return step(turned, 1, (quad3){at->p.x, at->p.y, at->p.z});
}

/* The square of the distance of the boxes around two triangles: no more than that of the triangles. */
static quad boxes2(const quad3 a[3], const quad3 b[3])
{
    quad sum = 0;
    for (int axis = 0; axis < 3; axis++) {
        quad lo[2], hi[2];
        for (int i = 0; i < 2; i++)
            for (int k = 0; k < 3; k++) {
                const quad3 *p = i ? &b[k] : &a[k];
                quad x = axis == 0 ? p->x : axis == 1 ? p->y : p->z;
                if (k == 0 || x < lo[i]) lo[i] = x;
                if (k == 0 || x > hi[i]) hi[i] = x;
            }
        quad gap = lo[0] > hi[1] ? lo[0] - hi[1] : lo[1] > hi[0] ? lo[1] - hi[0] : 0;
        sum += gap * gap;
    }
    return sum;
}

quad brute_distance(const soup *a, const soup *b, const pose *b_in_a)
{
    quad least = (quad)1e300;
    for (size_t i = 0; i < b->triangle_count; i++) {
        quad3 tb[3], ta[3];
        corners_of(b, i, tb);
        for (int k = 0; k < 3; k++) tb[k] = place(b_in_a, tb[k]);
        for (size_t j = 0; j < a->triangle_count; j++) {
            corners_of(a, j, ta);
            if (boxes2(ta, tb) >= least) continue;
            quad d2 = triangles2(ta, tb);
            if (d2 < least) least = d2;
        }
    }
    return root(least);
}

quad brute_point_distance(const soup *s, vec3 point)
{
    quad least = (quad)1e300;
    quad3 p = {point.x, point.y, point.z}, t[3];
    for (size_t i = 0; i < s->triangle_count; i++) {
        corners_of(s, i, t);
        quad d2 = point_triangle2(p, t);
        if (d2 < least) least = d2;
    }
    return root(least);
}

/* Van Oosterom and Strackee, "The solid angle of a plane triangle", 1983. */
int brute_winding(const soup *s, vec3 point)
{
    double sum = 0;
    for (size_t i = 0; i < s->triangle_count; i++) {
        vec3 v[3];
        for (size_t k = 0; k < 3; k++) {
            const double *p = s->points + 3 * (size_t)s->corners[3 * i + k];
            v[k] = vec_sub(vec(p[0], p[1], p[2]), point);
        }
        double a = vec_norm(v[0]), b = vec_norm(v[1]), c = vec_norm(v[2]);
        double over = vec_dot(v[0], vec_cross(v[1], v[2]));
        double under = a * b * c + vec_dot(v[0], v[1]) * c + vec_dot(v[1], v[2]) * a + vec_dot(v[2], v[0]) * b;
        sum += 2 * atan2(over, under);
    }
    return (int)lround(sum / (4 * M_PI));
}
