/* query_space: what a probe meets: a shape at a place, or a body's own shapes: along a line (ray, shape cast), where it
 * is (box), or near it (nearest k, all within a distance). About the world as the last tick left it; nothing is changed
 * and no cache is used. Called by the tick thread between ticks. */
#include "state.h"

#include <stdlib.h>

static const double FINEST = 1e-9; /* m, the tolerance where none was asked for */

/* A shape in the world's frame, and the body that it belongs to, which it does not meet. */
typedef struct probe {
    const shape *shape;
    pose at;
    uint32_t body; /* or WORLD_NONE */
} probe;

typedef struct search {
    const world *w;
    probe probe;
    vec3 direction; /* unit, of casts */
    double tolerance;
    double length; /* nothing beyond is of interest; with each hit of a cast it shrinks */
    int64_t now_ns;
    world_hits *out;
} search;

static shape box_or_point(vec3 half)
{
    bool point = half.x == 0 && half.y == 0 && half.z == 0;
    return (shape){.type = point ? SHAPE_SPHERE : SHAPE_BOX, .half = half};
}

static bool concerns(const search *q, const solid *s)
{
    return !q->w->bodies.at[s->body].ghost && s->body != q->probe.body;
}

static narrow_result ask(const search *q, pose at, const solid *s, double range)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = q->tolerance, .range = range};
    narrow_result r;
    narrow_query_world(q->probe.shape, at, &s->shape, s->world, &request, q->w->scratch[0], &r);
    return r;
}

static world_hit hit_of(const search *q, const solid *s, const narrow_result *r, pose at)
{
    const body *b = &q->w->bodies.at[s->body];
    return (world_hit){.body_a = s->body,
        .body_b = WORLD_NONE,
        .lo = r->lo,
        .hi = r->hi,
        .axis = r->axis,
        .point_a = vec_add(r->point_a, at.p),
        .point_b = vec_add(r->point_b, at.p),
        .age_ns = body_age_at(b, q->now_ns),
        .stale = b->stale};
}

/* ---- along a line ---- */

enum { CAST_STEPS_MAX = 256, TOUCH_STEPS_MAX = 40 };

static pose along(const search *q, double t)
{
    return (pose){vec_madd(q->probe.at.p, t, q->direction), q->probe.at.q};
}

/* By what length does it touch for certain? Steps on from `t`, ever farther; infinite if it only grazes. */
static double touches_by(const search *q, const solid *s, double t, double gap)
{
    double step = fmax(gap, q->tolerance);
    for (int i = 0; i < TOUCH_STEPS_MAX && t <= q->length; i++) {
        narrow_result n = ask(q, along(q, t), s, INFINITY);
        if (n.hi <= 0) return t;
        if (vec_dot(n.axis, q->direction) <= 0) return INFINITY; /* it goes away again */
        t += step;
        step *= 2;
    }
    return INFINITY;
}

/* Advances by the certified distance: the plane that separates the probe from the shape still does when the probe has
 * moved on, up to where it meets that plane, and for good if it never does. Ends within the tolerance of the surface:
 * it is free up to lo, and touches by hi. (Van den Bergen, "Ray casting against general convex objects", 2004, with
 * certified bounds.) */
static bool cast_shape(const search *q, const solid *s, world_hit *hit)
{
    search fine = *q;
    fine.tolerance = 0.25 * q->tolerance;
    double t = 0;
    for (int step = 0; step < CAST_STEPS_MAX; step++) {
        narrow_result n = ask(&fine, along(q, t), s, INFINITY);
        double towards = vec_dot(n.axis, q->direction);
        *hit = hit_of(q, s, &n, along(q, t));
        hit->axis = vec_neg(n.axis);
        hit->lo = t;
        hit->hi = INFINITY; /* so it stays where the steps run out: free up to lo, and honest beyond */
        if (n.lo <= q->tolerance) {
            hit->hi = touches_by(&fine, s, t, fmax(n.hi, 0));
            return true;
        }
        if (towards <= 0) return false;
        t += n.lo / towards;
        if (t > q->length) return false;
    }
    return true;
}

static bool cast_visit(void *context, uint32_t proxy)
{
    search *q = context;
    const solid *s = &q->w->solids.at[proxy];
    world_hit hit;
    if (!concerns(q, s) || !cast_shape(q, s, &hit)) return true;
    world_hit *best = q->out->count ? &q->out->at[0] : NULL;
    if (best && !(hit.lo < best->lo || (hit.lo == best->lo && hit.body_a < best->body_a))) return true;
    q->out->count = 0;
    array_push(q->out, hit);
    q->length = fmin(q->length, hit.lo + q->tolerance);
    return true;
}

void world_query_ray(
    const world *w, vec3 origin, vec3 direction, double length, double tolerance, int64_t now_ns, world_hits *out)
{
    static const shape TIP = {.type = SHAPE_SPHERE};
    search q = {.w = w,
        .probe = {&TIP, {origin, {1, 0, 0, 0}}, WORLD_NONE},
        .direction = vec_unit(direction),
        .tolerance = tolerance > 0 ? tolerance : FINEST,
        .length = length,
        .now_ns = now_ns,
        .out = out};
    broad_query_ray(w->broad, origin, q.direction, length, cast_visit, &q);
    for (size_t i = 0; i < out->count; i++) out->at[i].point_b = out->at[i].point_a; /* the ray's own tip */
}

/* What the box sweeps over; without an end it is all that lies ahead. */
static aabb swept(aabb box, vec3 direction, double length)
{
    double ahead = fmin(length, 1e15); /* m, farther than any position that is accepted */
    vec3 by = vec_scale(direction, ahead);
    return (aabb){vec_min(box.lo, vec_add(box.lo, by)), vec_max(box.hi, vec_add(box.hi, by))};
}

void world_query_cast(const world *w, pose at, vec3 half, vec3 direction, double length, double tolerance,
    int64_t now_ns, world_hits *out)
{
    const shape box = box_or_point(half);
    search q = {.w = w,
        .probe = {&box, {at.p, quat_unit(at.q)}, WORLD_NONE},
        .direction = vec_unit(direction),
        .tolerance = tolerance > 0 ? tolerance : FINEST,
        .length = length,
        .now_ns = now_ns,
        .out = out};
    broad_query_box(w->broad, swept(shape_bounds(&box, q.probe.at), q.direction, length), cast_visit, &q);
}

/* ---- where it is, and near it ---- */

static int by_body(const void *a, const void *b)
{
    const world_hit *x = a, *y = b;
    if (x->body_a != y->body_a) return x->body_a < y->body_a ? -1 : 1;
    return (x->lo > y->lo) - (x->lo < y->lo);
}

static int by_distance(const void *a, const void *b)
{
    const world_hit *x = a, *y = b;
    if (x->lo != y->lo) return x->lo < y->lo ? -1 : 1;
    return (x->body_a > y->body_a) - (x->body_a < y->body_a);
}

static void sort(world_hits *hits, int (*compare)(const void *, const void *))
{
    if (hits->count) qsort(hits->at, hits->count, sizeof *hits->at, compare);
}

/* Of several shapes of one body the nearest, or deepest, stays; in the order of ids. */
static void one_a_body(world_hits *hits)
{
    size_t kept = 0;
    sort(hits, by_body);
    for (size_t i = 0; i < hits->count; i++)
        if (kept == 0 || hits->at[i].body_a != hits->at[kept - 1].body_a) hits->at[kept++] = hits->at[i];
    hits->count = kept;
}

static bool near_visit(void *context, uint32_t proxy)
{
    search *q = context;
    const solid *s = &q->w->solids.at[proxy];
    if (!concerns(q, s)) return true;
    narrow_result r = ask(q, q->probe.at, s, q->length);
    if (r.lo <= q->length) array_push(q->out, hit_of(q, s, &r, q->probe.at));
    return true;
}

static void collect_within(search *q)
{
    broad_query_box(q->w->broad, aabb_grow(shape_bounds(q->probe.shape, q->probe.at), q->length), near_visit, q);
}

void world_query_box(const world *w, pose at, vec3 half, int64_t now_ns, world_hits *out)
{
    const shape box = box_or_point(half);
    search q = {.w = w,
        .probe = {&box, {at.p, quat_unit(at.q)}, WORLD_NONE},
        .tolerance = FINEST,
        .now_ns = now_ns,
        .out = out};
    collect_within(&q);
    one_a_body(out);
}

/* All bodies within `range` of the probes. */
static void collect_near(search *q, const probe *probes, size_t count, double range)
{
    q->out->count = 0;
    q->length = range;
    for (size_t i = 0; i < count; i++) {
        q->probe = probes[i];
        collect_within(q);
    }
    one_a_body(q->out);
}

/* Looks ever farther out until as many are found as were asked for: all that is nearer has then been seen. */
static void nearest(search *q, const probe *probes, size_t count, double range, size_t most)
{
    static const double FARTHER = 4, EVERYWHERE = 1e16; /* m, beyond all positions */
    double near = 0.5;                                  /* m */
    for (size_t i = 0; i < count; i++) near = fmax(near, vec_max_abs(probes[i].shape->half));
    while (near < range && near < EVERYWHERE) {
        collect_near(q, probes, count, near);
        if (q->out->count >= most) break;
        near *= FARTHER;
    }
    if (!(near < range && near < EVERYWHERE)) collect_near(q, probes, count, fmin(range, EVERYWHERE));
    sort(q->out, by_distance);
    if (q->out->count > most) q->out->count = most;
}

void world_query_nearest(
    const world *w, pose at, vec3 half, double range, size_t most, double tolerance, int64_t now_ns, world_hits *out)
{
    const shape box = box_or_point(half);
    probe one = {&box, {at.p, quat_unit(at.q)}, WORLD_NONE};
    search q = {.w = w, .tolerance = tolerance > 0 ? tolerance : FINEST, .now_ns = now_ns, .out = out};
    nearest(&q, &one, 1, range, most);
}

void world_query_nearest_to(
    const world *w, uint32_t id, double range, size_t most, double tolerance, int64_t now_ns, world_hits *out)
{
    if (!world_body_name(w, id)) return;
    const body *b = &w->bodies.at[id];
    probe *probes = base_alloc(b->shape_count + 1, sizeof *probes);
    for (size_t i = 0; i < b->shape_count; i++) {
        const solid *s = &w->solids.at[b->shapes[i]];
        probes[i] = (probe){&s->shape, s->world, id};
    }
    search q = {.w = w, .tolerance = tolerance > 0 ? tolerance : FINEST, .now_ns = now_ns, .out = out};
    nearest(&q, probes, b->shape_count, range, most);
    free(probes);
}
