/* ray: a shape is where all of a few conditions hold (a box: three slabs; a cylinder: a slab and a circle), and each of
 * these holds during one interval of the ray. Every interval is found twice, in a shape that is larger by what rounding
 * may have done and in one that is smaller by it: so each bound is proven, however the ray lies.
 *
 * Errors are counted as positions. With `blur` = 2^-45 (|from| + reach + arm), which is at least 2^-45 of any length up
 * to where the ray can be in the shape, the computed point at each such length is within a half of it of the true one:
 * 2^-47 for `from`, 2^-48 for the direction, and less than 32 roundoffs (2^-48) of the formulas. The other half is
 * slack. Kay and Kajiya 1986 (slabs); Ericson, "Real-Time Collision Detection", 5.3. */
#include "ray.h"

static const double BLUR = 0x1p-45;

/* A condition: outside of [from, to] it certainly does not hold, within [sure_from, sure_to] it certainly does; that
 * one is empty where the condition is narrower than rounding. If it has not held before sure_from, it has begun by
 * then. Lengths, perhaps infinite. */
typedef struct span {
    double from, to, sure_from, sure_to;
} span;

static const span NEVER = {INFINITY, -INFINITY, INFINITY, -INFINITY};

/* What lies along the ray, when the direction does not change what is `off` by the condition, so much is allowed. */
static span all_along(double off, double most, double blur)
{
    span s = {-INFINITY, INFINITY, -INFINITY, INFINITY};
    if (off > most + blur) return NEVER;
    if (off > most - blur) s.sure_from = INFINITY, s.sure_to = -INFINITY;
    return s;
}

/* |o + t d| <= half. */
static span slab(double o, double d, double half, double blur)
{
    if (fabs(d) < 0x1p-60) return all_along(fabs(o), half, blur); /* less than the direction's own error */
    double ahead = d > 0 ? o : -o, speed = 1 / fabs(d);
    double outer = half + blur, inner = half - blur;
    return (span){(-outer - ahead) * speed, (outer - ahead) * speed, (-inner - ahead) * speed, (inner - ahead) * speed};
}

/* |o + t d| <= radius, of vectors; |d| need not be 1, a plane's is its part of the direction. `blur` in its unit. */
static span ball(vec3 o, vec3 d, double radius, double blur)
{
    double dd = vec_norm2(d);
    if (dd < 0x1p-120) return all_along(vec_norm(o), radius, blur);
    double speed = 1 / sqrt(dd), middle = -vec_dot(o, d) / dd;
    double off = vec_norm(vec_madd(o, middle, d));
    double outer = radius + blur, inner = radius - blur;
    if (off > outer) return NEVER;
    double half = sqrt((outer - off) * (outer + off)) * speed, slack = blur * speed;
    span s = {middle - half - slack, middle + half + slack, INFINITY, -INFINITY};
    if (off < inner) {
        half = sqrt((inner - off) * (inner + off)) * speed;
        s.sure_from = middle - half + slack;
        s.sure_to = middle + half - slack;
    }
    return s;
}

/* All conditions at once. `last`: the one that begins to hold last. */
static ray_verdict meet(const span *s, int count, ray_hit *hit, int *last)
{
    double to = INFINITY, sure_from = -INFINITY, sure_to = INFINITY;
    int entered = 0;
    hit->lo = -INFINITY;
    for (int i = 0; i < count; i++) {
        if (s[i].from > hit->lo) hit->lo = s[i].from, *last = i;
        if (s[i].sure_from > sure_from) sure_from = s[i].sure_from, entered = i;
        to = fmin(to, s[i].to);
        sure_to = fmin(sure_to, s[i].sure_to);
    }
    if (hit->lo > to || to < 0) return RAY_MISSES;
    if (!(hit->lo > 0)) return RAY_UNTOLD;
    hit->hi = sure_from;
    if (sure_from <= sure_to) return RAY_HITS;
    /* Something is as thin as rounding (a flat box), or the ray passes an edge. Where one condition begins to hold
     * while all others do, there is a moment in which all do. */
    for (int i = 0; i < count; i++)
        if (i != entered && (s[i].sure_from > s[entered].from || s[i].sure_to < sure_from)) hit->hi = INFINITY;
    return RAY_HITS;
}

static vec3 along_axis(int axis, vec3 direction)
{
    vec3 n = VEC_ZERO;
    (&n.x)[axis] = (&direction.x)[axis] > 0 ? -1 : 1; /* against the ray */
    return n;
}

static ray_verdict enters_ball(double radius, vec3 from, vec3 d, double blur, ray_hit *hit)
{
    if (radius < 4 * blur) return RAY_UNTOLD; /* a point */
    int last = 0;
    span s = ball(from, d, radius, blur);
    ray_verdict v = meet(&s, 1, hit, &last);
    if (v == RAY_HITS) hit->normal = vec_unit(vec_madd(from, hit->lo, d));
    return v;
}

static ray_verdict enters_box(vec3 half, vec3 from, vec3 d, double blur, ray_hit *hit)
{
    int last = 0;
    const span s[] = {
        slab(from.x, d.x, half.x, blur), slab(from.y, d.y, half.y, blur), slab(from.z, d.z, half.z, blur)};
    ray_verdict v = meet(s, 3, hit, &last);
    if (v == RAY_HITS) hit->normal = along_axis(last, d);
    return v;
}

static ray_verdict enters_cylinder(double radius, double half, vec3 from, vec3 d, double blur, ray_hit *hit)
{
    if (radius < 4 * blur) return RAY_UNTOLD;
    int last = 0;
    vec3 o = vec(from.x, from.y, 0), across = vec(d.x, d.y, 0);
    const span s[] = {ball(o, across, radius, blur), slab(from.z, d.z, half, blur)};
    ray_verdict v = meet(s, 2, hit, &last);
    if (v == RAY_HITS) hit->normal = last ? along_axis(2, d) : vec_unit(vec_madd(o, hit->lo, across));
    return v;
}

/* Takes the earlier one. Returns false if one of them cannot be decided. */
static bool unite(ray_verdict v, const ray_hit *other, ray_verdict *all, ray_hit *hit)
{
    if (v == RAY_UNTOLD) return false;
    if (v == RAY_MISSES) return true;
    double hi = *all == RAY_HITS ? fmin(hit->hi, other->hi) : other->hi;
    if (*all != RAY_HITS || other->lo < hit->lo) *hit = *other;
    hit->hi = hi;
    *all = RAY_HITS;
    return true;
}

/* A cylinder and two balls. */
static ray_verdict enters_capsule(double radius, double half, vec3 from, vec3 d, double blur, ray_hit *hit)
{
    ray_verdict all = RAY_MISSES;
    ray_hit part;
    for (int side = -1; side <= 1; side += 2) {
        vec3 end = vec(from.x, from.y, from.z - side * half);
        if (!unite(enters_ball(radius, end, d, blur, &part), &part, &all, hit)) return RAY_UNTOLD;
    }
    if (!unite(enters_cylinder(radius, half, from, d, blur, &part), &part, &all, hit)) return RAY_UNTOLD;
    if (all == RAY_HITS) { /* an end of the cylinder is inside */
        vec3 at = vec_madd(from, hit->lo, d);
        at.z -= fmax(-half, fmin(at.z, half));
        hit->normal = vec_unit(at);
    }
    return all;
}

/* In units of its half axes it is a ball. What is as wide as the blur along the shortest axis is a bound for all. */
static ray_verdict enters_ellipsoid(vec3 half, vec3 from, vec3 d, double blur, ray_hit *hit)
{
    double least = fmin(half.x, fmin(half.y, half.z));
    if (least < 0x1p-20 * vec_max_abs(half) || least < 0x1p20 * blur) return RAY_UNTOLD; /* a needle or a disc */
    vec3 scale = vec(1 / half.x, 1 / half.y, 1 / half.z);
    vec3 o = vec(from.x * scale.x, from.y * scale.y, from.z * scale.z);
    vec3 e = vec(d.x * scale.x, d.y * scale.y, d.z * scale.z);
    ray_verdict v = enters_ball(1, o, e, blur / least, hit);
    if (v != RAY_HITS) return v;
    vec3 at = vec_madd(o, hit->lo, e);
    hit->normal = vec_unit(vec(at.x * scale.x, at.y * scale.y, at.z * scale.z));
    return v;
}

/* It has no reach: the error grows along the ray. */
static ray_verdict enters_halfspace(double radius, double arm, vec3 from, vec3 d, ray_hit *hit)
{
    double height = from.z - radius, blur = BLUR * (vec_norm(from) + radius + arm);
    if (height <= blur) return RAY_UNTOLD;
    if (BLUR - d.z <= 0) return RAY_MISSES;
    hit->lo = (height - blur) / (BLUR - d.z);
    hit->hi = -d.z > BLUR ? (height + blur) / (-d.z - BLUR) : INFINITY;
    hit->normal = vec(0, 0, 1);
    return RAY_HITS;
}

ray_verdict ray_enters(const shape *s, double reach, double arm, vec3 from, vec3 direction, ray_hit *hit)
{
    double blur = BLUR * (vec_norm(from) + reach + arm);
    if (s->deviation > 0) return RAY_UNTOLD; /* it is not known where it touches what the shape stands for */
    if (s->type == SHAPE_HALFSPACE) return enters_halfspace(s->radius, arm, from, direction, hit);
    if (!(blur < INFINITY) || blur < 0x1p-500 || !(vec_norm2(direction) > 0.5)) return RAY_UNTOLD;
    switch (s->type) {
    case SHAPE_SPHERE:
        return enters_ball(s->radius, from, direction, blur, hit);
    case SHAPE_CAPSULE:
        return enters_capsule(s->radius, s->half.z, from, direction, blur, hit);
    case SHAPE_BOX:
        return s->radius > 0 ? RAY_UNTOLD : enters_box(s->half, from, direction, blur, hit);
    case SHAPE_CYLINDER:
        return s->radius > 0 ? RAY_UNTOLD : enters_cylinder(s->half.x, s->half.z, from, direction, blur, hit);
    case SHAPE_ELLIPSOID:
        return s->radius > 0 ? RAY_UNTOLD : enters_ellipsoid(s->half, from, direction, blur, hit);
    default:
        return RAY_UNTOLD;
    }
}

double ray_free_before(double reach, double arm, vec3 from, vec3 direction)
{
    double blur = BLUR * (vec_norm(from) + reach + arm);
    if (!(blur < INFINITY) || blur < 0x1p-500 || !(vec_norm2(direction) > 0.5)) return 0;
    span s = ball(from, direction, reach, blur);
    return s.to < 0 ? INFINITY : fmax(s.from, 0);
}
