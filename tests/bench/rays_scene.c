/* rays_scene: see rays_scene.h. */
#include "rays_scene.h"

#include "base/prng.h"

#include <math.h>
#include <stdlib.h>

typedef long double real;

static double random_half(uint64_t *state)
{
    return exp(prng_in(state, log(0.25), log(1)));
}

static void random_unit(uint64_t *state, double *v, int n)
{
    double norm2;
    do {
        norm2 = 0;
        for (int k = 0; k < n; k++) v[k] = prng_in(state, -1, 1), norm2 += v[k] * v[k];
    } while (norm2 > 1 || norm2 < 0.01);
    for (int k = 0; k < n; k++) v[k] /= sqrt(norm2);
}

static rays_body random_body(uint64_t *state, rays_kind kind, double side)
{
    rays_body b = {.kind = kind};
    if (kind != RAYS_BOX) b.radius = random_half(state);
    if (kind == RAYS_BOX)
        for (int k = 0; k < 3; k++) b.half[k] = random_half(state);
    if (kind == RAYS_CAPSULE) b.half[2] = random_half(state);
    for (int k = 0; k < 3; k++) b.at[k] = prng_in(state, 0, side);
    random_unit(state, b.turned, 4);
    return b;
}

/* ---- the truth ---- */

static real dot(const real *a, const real *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Of all points from + t d with t >= 0 the first in a ball about z on the axis. */
static real enter_ball(const real *from, const real *d, real z, real radius)
{
    real o[3] = {from[0], from[1], from[2] - z}, b = dot(o, d), c = dot(o, o) - radius * radius;
    if (c <= 0) return 0;
    real root = b * b - dot(d, d) * c;
    return b >= 0 || root < 0 ? INFINITY : (-b - sqrtl(root)) / dot(d, d);
}

static real enter_side(const real *from, const real *d, real half, real radius)
{
    real a = d[0] * d[0] + d[1] * d[1], b = from[0] * d[0] + from[1] * d[1];
    real c = from[0] * from[0] + from[1] * from[1] - radius * radius;
    if (c <= 0 && fabsl(from[2]) <= half) return 0;
    real root = b * b - a * c, t = root < 0 || a == 0 ? INFINITY : (-b - sqrtl(root)) / a;
    return t >= 0 && fabsl(from[2] + t * d[2]) <= half ? t : INFINITY; /* or it comes in through a ball */
}

static real enter_box(const real *from, const real *d, const double *half)
{
    real enter = 0, leave = INFINITY;
    for (int k = 0; k < 3; k++) {
        real a = (-half[k] - from[k]) / d[k], b = (half[k] - from[k]) / d[k];
        enter = fmaxl(enter, fminl(a, b));
        leave = fminl(leave, fmaxl(a, b));
    }
    return enter <= leave ? enter : INFINITY;
}

static real enter(const rays_body *b, const rays_ray *r)
{
    double axes[3][3];
    real from[3] = {0}, d[3] = {0};
    rays_axes(b, axes);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            from[i] += axes[i][k] * ((real)r->from[k] - b->at[k]);
            d[i] += (real)axes[i][k] * r->direction[k];
        }
    if (b->kind == RAYS_BOX) return enter_box(from, d, b->half);
    real t = enter_ball(from, d, -b->half[2], b->radius);
    if (b->kind == RAYS_BALL) return t;
    t = fminl(t, enter_ball(from, d, b->half[2], b->radius));
    return fminl(t, enter_side(from, d, b->half[2], b->radius));
}

double rays_truth(const rays_scene *s, const rays_ray *r)
{
    real first = INFINITY;
    for (size_t i = 0; i < s->body_count; i++) first = fminl(first, enter(&s->bodies[i], r));
    return (double)first;
}

/* ---- making ---- */

static void random_ray(const rays_scene *s, rays_ray *r, uint64_t *state)
{
    do {
        for (int k = 0; k < 3; k++) r->from[k] = prng_in(state, 0, s->side);
        random_unit(state, r->direction, 3);
    } while (!(rays_truth(s, r) > 1e-3));
}

rays_scene rays_scene_make(size_t bodies, size_t rays, uint64_t seed)
{
    /* Two boxes, about 1.5 m wide on the average, meet with probability (1.5 * 2 / side)^3. */
    rays_scene s = {.body_count = bodies, .ray_count = rays, .side = 3 * cbrt((double)bodies)};
    s.bodies = calloc(bodies, sizeof *s.bodies);
    s.rays = calloc(rays, sizeof *s.rays);
    if (!s.bodies || !s.rays) abort();
    for (size_t i = 0; i < bodies; i++) s.bodies[i] = random_body(&seed, (rays_kind)(i % RAYS_KIND_COUNT), s.side);
    for (size_t i = 0; i < rays; i++) random_ray(&s, &s.rays[i], &seed);
    return s;
}

void rays_scene_free(rays_scene *s)
{
    free(s->bodies);
    free(s->rays);
}

void rays_axes(const rays_body *b, double axes[3][3])
{
    double w = b->turned[0], x = b->turned[1], y = b->turned[2], z = b->turned[3];
    double m[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)},
        {2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)},
        {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)}};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) axes[i][k] = m[i][k];
}
