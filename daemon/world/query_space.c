/* query_space: what a probe meets: a shape at a place, or a body's own shapes: along a line (ray, shape cast), where it
 * is (box), or near it (nearest k, all within a distance). About the world as the last tick left it; nothing is changed
 * and no cache is used. Called by the tick thread between ticks. */
#include "geom/ray.h"
#include "soft_state.h"

#include <stdlib.h>

static const double FINEST = 1e-9; /* m, the tolerance where none was asked for */

/* A shape, where it is in a frame, which is in the world, and the body that it belongs to, which it does not meet. */
typedef struct probe {
    const shape *shape;
    pose at, local;
    uint32_t body; /* or WORLD_NONE */
} probe;

typedef struct search {
    const world *w;
    probe probe;
    vec3 direction; /* unit, of casts */
    double tolerance;
    double length; /* nothing beyond is of subscription; with each hit of a cast it shrinks ... */
    double asked;  /* ... from here: how far a hit is looked into depends on none before it */
    bool is_ray;
    uint32_t visits;
    int64_t now_ns;
    world_hits *out;
} search;

static shape box_or_point(vec3 half)
{
    bool point = half.x == 0 && half.y == 0 && half.z == 0;
    return (shape){.type = point ? SHAPE_SPHERE : SHAPE_BOX, .half = half};
}

static bool concerns(const search *q, const collider *s)
{
    return !q->w->bodies.at[s->body].ghost && !collider_is_soft(s) && s->body != q->probe.body;
}

/* The probe when it has gone on by t along the direction, and a shape, in world axes about the probe's frame then: they
 * are as precise as their distance from each other lets them be. */
static void place(const search *q, double t, const collider *s, pose *at, pose *there)
{
    pose body_pose, local, frame = {VEC_ZERO, q->probe.at.q};
    collider_stand(q->w, s, &body_pose, &local);
    body_pose.p = vec_madd(vec_sub(body_pose.p, q->probe.at.p), -t, q->direction);
    *at = pose_mul(frame, q->probe.local);
    *there = pose_mul(body_pose, local);
}

/* About the origin of the probe's frame, when that has gone on by t. */
static narrow_result ask(const search *q, double t, const collider *s, double range)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = q->tolerance, .range = range};
    pose at, there;
    narrow_result r;
    place(q, t, s, &at, &there);
    narrow_query_world(q->probe.shape, at, &s->shape, there, &request, q->w->scratch[0], &r);
    r.point_a = vec_add(r.point_a, at.p);
    r.point_b = vec_add(r.point_b, at.p);
    return r;
}

static world_hit hit_of(const search *q, const collider *s, const narrow_result *r, double t)
{
    vec3 origin = vec_madd(q->probe.at.p, t, q->direction);
    const body *b = &q->w->bodies.at[s->body];
    return (world_hit){.body_a = s->body,
        .body_b = WORLD_NONE,
        .name_a = b->name,
        .shape_a = s->index,
        .lo = r->lo,
        .hi = r->hi,
        .axis = r->axis,
        .point_a = vec_add(r->point_a, origin),
        .point_b = vec_add(r->point_b, origin),
        .age_ns = body_age_at(b, q->now_ns),
        .stale = b->stale};
}

/* Shapes are met in an order that follows from ids. Of hits that are equally near, or shapes of one body, the one stays
 * whose name, or index, comes first. */
static int by_name(const world_hit *x, const world_hit *y)
{
    int c = x->body_a == y->body_a ? 0 : strcmp(x->name_a, y->name_a);
    return c ? c : x->shape_a - y->shape_a;
}

static bool comes_before(const world_hit *x, const world_hit *y)
{
    return x->lo < y->lo || (x->lo == y->lo && by_name(x, y) < 0);
}

/* ---- along a line ---- */

/* A mesh or a compound is passed in steps of the distance to it, so that a long way close to it takes many. */
enum { CAST_STEPS_MAX = 256, CAST_STEPS_MESH_MAX = 4096, TOUCH_STEPS_MAX = 40 };

/* Of a mesh or a compound no plane separates more than what is nearest. */
static bool is_convex(const collider *s)
{
    return s->shape.type < SHAPE_CONVEX_COUNT;
}

/* By what length does it touch for certain? Steps on from `t`, ever farther; infinite if it only grazes. */
static double touches_by(const search *q, const collider *s, double t, double gap)
{
    double step = fmax(gap, q->tolerance);
    for (int i = 0; i < TOUCH_STEPS_MAX && t <= q->asked; i++) {
        narrow_result n = ask(q, t, s, INFINITY);
        if (n.hi <= 0) return t;
        if (is_convex(s) && vec_dot(n.axis, q->direction) <= 0) return INFINITY; /* it goes away again */
        t += step;
        step *= 2;
    }
    return INFINITY;
}

/* Is all of the shape behind the probe? */
static bool has_passed(const search *q, const collider *s, double t)
{
    pose at, there;
    place(q, t, s, &at, &there);
    pose relative = pose_relative(at, there);
    vec3 back = quat_rotate(quat_conj(at.q), vec_neg(q->direction));
    return narrow_separation(q->probe.shape, &s->shape, &relative, back, NULL, NULL) > 0;
}

/* Advances by the certified distance: the plane that separates the probe from the shape still does when the probe has
 * moved on, up to where it meets that plane, and for good if it never does; beside a mesh or a compound, the distance
 * itself. Ends within the tolerance of the surface: it is free up to lo, and touches by hi. (Van den Bergen, "Ray
 * casting against general convex objects", 2004, with certified bounds.) */
static bool cast_shape(const search *q, const collider *s, world_hit *hit)
{
    search fine = *q;
    fine.tolerance = 0.25 * q->tolerance;
    double t = 0;
    int steps = is_convex(s) ? CAST_STEPS_MAX : CAST_STEPS_MESH_MAX;
    for (int step = 0; step < steps && world_may_go_on(q->out); step++) {
        narrow_result n = ask(&fine, t, s, INFINITY);
        double towards = vec_dot(n.axis, q->direction);
        *hit = hit_of(q, s, &n, t);
        hit->axis = vec_neg(n.axis);
        hit->lo = t;
        hit->hi = INFINITY; /* so it stays where the steps run out: free up to lo, and honest beyond */
        if (n.lo <= q->tolerance) {
            hit->hi = touches_by(&fine, s, t, fmax(n.hi, 0));
            return true;
        }
        if (is_convex(s) ? towards <= 0 : has_passed(q, s, t)) return false;
        t += is_convex(s) ? n.lo / towards : n.lo;
        if (t > q->length) return false;
    }
    return true;
}

/* Nobody who is farther from the way can be a hit, in tolerances: cast_shape ends at a bound of the distance that is at
 * most a quarter of one too low. All who are nearer are asked, whatever their fat boxes, which have a history. */
static const double NEAR = 1.5;

static aabb near_by(const search *q, aabb box)
{
    return aabb_grow(box, NEAR * q->tolerance);
}

/* The answers of geom/ray.h, which are as good as rounding allows, in place of a search that ends within a tolerance;
 * it stays for all that has no formula. */
static bool ray_meets_shape(const search *q, const collider *s, world_hit *hit)
{
    pose at, local;
    collider_stand(q->w, s, &at, &local);
    vec3 origin = vec_sub(at.p, q->probe.at.p); /* of the shape's frame, seen from the ray's */
    double arm = 0;
    if (!s->at_origin) {
        arm = vec_norm(origin) + vec_norm(local.p);
        origin = vec_add(origin, quat_rotate(at.q, local.p));
    }
    if (ray_free_before(s->reach + NEAR * q->tolerance, arm, vec_neg(origin), q->direction) > q->length) return false;
    mat3 turned = quat_matrix(s->at_origin ? at.q : quat_mul(at.q, local.q));
    ray_hit found;
    vec3 from = mat_tmul(turned, vec_neg(origin)), direction = mat_tmul(turned, q->direction);
    ray_verdict v = ray_enters(&s->shape, s->reach, arm, from, direction, &found);
    if (v == RAY_UNTOLD) return cast_shape(q, s, hit);
    if (v == RAY_MISSES || found.lo > q->length) return false;
    narrow_result none = {.lo = 0};
    *hit = hit_of(q, s, &none, found.lo);
    hit->lo = found.lo;
    hit->hi = found.hi <= q->asked ? found.hi : INFINITY;
    hit->axis = mat_mul(turned, found.normal);
    return true;
}

/* A clock is read before each step of a search, and for some formulas together. */
enum { VISITS_A_CLOCK = 32 };

static double cast_visit(void *context, uint32_t proxy)
{
    search *q = context;
    const collider *s = &q->w->colliders.at[proxy];
    world_hit hit;
    if (++q->visits % VISITS_A_CLOCK == 0 && !world_may_go_on(q->out)) return -1;
    if (!concerns(q, s)) return q->length;
    bool meets = q->is_ray ? ray_meets_shape(q, s, &hit) : cast_shape(q, s, &hit);
    if (q->out->gave_up) return -1;
    world_hit *best = q->out->count ? &q->out->at[0] : NULL;
    if (!meets || (best && !comes_before(&hit, best))) return q->length;
    q->out->count = 0;
    array_push(q->out, hit);
    q->length = fmin(q->length, hit.lo + q->tolerance);
    return q->length;
}

void world_query_ray(
    const world *w, vec3 origin, vec3 direction, double length, double tolerance, int64_t now_ns, world_hits *out)
{
    static const shape TIP = {.type = SHAPE_SPHERE};
    search q = {.w = w,
        .probe = {&TIP, {origin, {1, 0, 0, 0}}, POSE_IDENTITY, WORLD_NONE},
        .direction = vec_unit(direction),
        .tolerance = tolerance > 0 ? tolerance : FINEST,
        .length = length,
        .asked = length,
        .is_ray = true,
        .now_ns = now_ns,
        .out = out};
    aabb tip = near_by(&q, (aabb){origin, origin});
    broad_query_cast(w->broad, tip, q.direction, length, cast_visit, &q);
    for (size_t i = 0; i < out->count; i++) out->at[i].point_b = out->at[i].point_a; /* the ray's own tip */
}

void world_query_cast(const world *w, pose at, vec3 half, vec3 direction, double length, double tolerance,
    int64_t now_ns, world_hits *out)
{
    const shape box = box_or_point(half);
    search q = {.w = w,
        .probe = {&box, {at.p, quat_unit(at.q)}, POSE_IDENTITY, WORLD_NONE},
        .direction = vec_unit(direction),
        .tolerance = tolerance > 0 ? tolerance : FINEST,
        .length = length,
        .asked = length,
        .now_ns = now_ns,
        .out = out};
    aabb bounds = near_by(&q, shape_bounds(&box, q.probe.at));
    broad_query_cast(w->broad, bounds, q.direction, length, cast_visit, &q);
}

/* ---- along a motion ---- */

typedef struct moving {
    search q; /* q.length: s, nothing after it is of subscription */
    const collider *of;
    motion motion;
} moving;

static bool sweep_visit(void *context, uint32_t proxy)
{
    moving *m = context;
    const world *w = m->q.w;
    const collider *s = &w->colliders.at[proxy], *x = m->of;
    const body *a = &w->bodies.at[x->body], *b = &w->bodies.at[s->body];
    if (!world_may_go_on(m->q.out)) return false;
    if (!concerns(&m->q, s) || !pair_get_terms(w, a, b).checked) return true;
    toi_mover mover = {&x->shape, x->local, m->motion}, still = {&s->shape, s->local, {.start = b->pose}};
    toi_request request = {.span = m->q.length, .tolerance = m->q.tolerance};
    toi_result t;
    bool in_order = colliders_in_order(w, x, s);
    const toi_mover *first = in_order ? &mover : &still, *second = in_order ? &still : &mover;
    toi_find(first, second, &request, VEC_ZERO, w->scratch[0], &t);
    if (t.status == TOI_FREE) return true;
    if (request.span < m->q.asked) { /* what is reported depends on no hit before it */
        request.span = m->q.asked;
        toi_find(first, second, &request, VEC_ZERO, w->scratch[0], &t);
    }
    world_hit *best = m->q.out->count ? &m->q.out->at[0] : NULL;
    world_hit hit = {.body_a = s->body,
        .body_b = WORLD_NONE,
        .name_a = b->name,
        .shape_a = s->index,
        .lo = t.lo,
        .hi = t.hi,
        .axis = in_order ? t.axis : vec_neg(t.axis),
        .point_a = in_order ? t.point_a : t.point_b,
        .point_b = in_order ? t.point_b : t.point_a,
        .age_ns = body_age_at(b, m->q.now_ns),
        .stale = b->stale};
    if (t.status == TOI_FREE || (best && !comes_before(&hit, best))) return true;
    m->q.out->count = 0;
    array_push(m->q.out, hit);
    m->q.length = fmin(m->q.length, fmax(t.lo * (1 + 1e-12), 1e-300));
    return true;
}

void world_query_sweep(const world *w, uint32_t id, vec3 linear, vec3 angular, double span, double tolerance,
    int64_t now_ns, world_hits *out)
{
    const body *b = &w->bodies.at[id];
    moving m = {.q = {.w = w,
                    .probe.body = id,
                    .tolerance = tolerance > 0 ? tolerance : FINEST,
                    .length = span,
                    .asked = span,
                    .now_ns = now_ns,
                    .out = out},
        .motion = {b->pose, linear, angular}};
    for (size_t k = 0; k < b->shape_count; k++) {
        m.of = &w->colliders.at[b->shapes[k]];
        aabb box = motion_bounds(&m.motion, &m.of->shape, m.of->local, m.q.length);
        broad_query_box(w->broad, aabb_grow(box, m.q.tolerance), sweep_visit, &m);
    }
}

/* ---- where it is, and near it ---- */

static int by_body(const void *a, const void *b)
{
    const world_hit *x = a, *y = b;
    if (x->body_a != y->body_a) return strcmp(x->name_a, y->name_a);
    return comes_before(y, x) - comes_before(x, y);
}

/* Of several shapes of one body the nearest, or deepest, stays; in the order of names. */
static void one_a_body(world_hits *hits)
{
    size_t kept = 0;
    if (hits->count) qsort(hits->at, hits->count, sizeof *hits->at, by_body);
    for (size_t i = 0; i < hits->count; i++)
        if (kept == 0 || hits->at[i].body_a != hits->at[kept - 1].body_a) hits->at[kept++] = hits->at[i];
    hits->count = kept;
}

static bool overlap_visit(void *context, uint32_t proxy)
{
    search *q = context;
    const collider *s = &q->w->colliders.at[proxy];
    if (!world_may_go_on(q->out)) return false;
    if (!concerns(q, s)) return true;
    narrow_result r = ask(q, 0, s, 0);
    if (r.lo <= 0) array_push(q->out, hit_of(q, s, &r, 0));
    return true;
}

void world_query_box(const world *w, pose at, vec3 half, int64_t now_ns, world_hits *out)
{
    const shape box = box_or_point(half);
    search q = {.w = w,
        .probe = {&box, {at.p, quat_unit(at.q)}, POSE_IDENTITY, WORLD_NONE},
        .tolerance = FINEST,
        .now_ns = now_ns,
        .out = out};
    broad_query_box(w->broad, shape_bounds(&box, q.probe.at), overlap_visit, &q);
    one_a_body(out);
}

/* ---- the nearest ---- */

typedef struct nearest {
    search search;
    size_t most;
    double range;
} nearest;

/* Into the hits, which stand by rising distance, one a body. */
static void insert(world_hits *hits, const world_hit *hit, size_t most)
{
    size_t at = 0;
    while (at < hits->count && hits->at[at].body_a != hit->body_a) at++;
    if (at < hits->count && !comes_before(hit, &hits->at[at])) return; /* another shape of it is nearer */
    if (at == hits->count) array_push(hits, *hit);
    for (; at > 0 && comes_before(hit, &hits->at[at - 1]); at--) hits->at[at] = hits->at[at - 1];
    hits->at[at] = *hit;
    if (hits->count > most) hits->count = most;
}

/* How far to look: whoever has a lower bound below that of the last one is at most a tolerance farther away than it. So
 * the answer does not depend on the order of the visits. */
static double range_left(const nearest *n)
{
    const world_hits *hits = n->search.out;
    if (hits->count < n->most) return n->range;
    return fmin(n->range, fmax(hits->at[n->most - 1].lo, 0) + n->search.tolerance);
}

static double near_visit(void *context, uint32_t proxy, double distance)
{
    nearest *n = context;
    search *q = &n->search;
    const collider *s = &q->w->colliders.at[proxy];
    (void)distance;
    if (!world_may_go_on(q->out)) return -1; /* nothing is so near: it ends */
    if (!concerns(q, s)) return range_left(n);
    narrow_result r = ask(q, 0, s, range_left(n));
    world_hit hit = hit_of(q, s, &r, 0);
    if (r.lo <= range_left(n)) insert(q->out, &hit, n->most);
    return range_left(n);
}

static void look_around(nearest *n, const probe *p)
{
    n->search.probe = *p;
    aabb box = shape_bounds(p->shape, pose_mul(p->at, p->local));
    broad_query_nearest(n->search.w->broad, box, range_left(n), near_visit, n);
}

void world_query_nearest(
    const world *w, pose at, vec3 half, double range, size_t most, double tolerance, int64_t now_ns, world_hits *out)
{
    const shape box = box_or_point(half);
    const probe one = {&box, {at.p, quat_unit(at.q)}, POSE_IDENTITY, WORLD_NONE};
    nearest n = {{.w = w, .tolerance = tolerance > 0 ? tolerance : FINEST, .now_ns = now_ns, .out = out}, most, range};
    if (most) look_around(&n, &one);
}

void world_query_nearest_to(
    const world *w, uint32_t id, double range, size_t most, double tolerance, int64_t now_ns, world_hits *out)
{
    nearest n = {{.w = w, .tolerance = tolerance > 0 ? tolerance : FINEST, .now_ns = now_ns, .out = out}, most, range};
    if (!most || !world_body_name(w, id)) return;
    const body *b = &w->bodies.at[id];
    for (size_t i = 0; i < b->shape_count && !b->soft; i++) {
        const collider *s = &w->colliders.at[b->shapes[i]];
        probe own = {.shape = &s->shape, .body = id};
        collider_stand(w, s, &own.at, &own.local);
        look_around(&n, &own);
    }
}
