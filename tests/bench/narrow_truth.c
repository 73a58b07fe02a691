/* narrow_truth: chooses the oracle, and sweeps. A separation along a unit n is
 *     f(n) = min over B of n.x - max over A of n.x,
 * and the signed distance is the greatest f; over overlapping bodies f has a few local maxima, each concave. */
#include "narrow_truth.h"

#include "narrow/narrow.h"

#include <stdlib.h>

enum { SWEEP = 600, SEEDS = 4, POLLS = 1, ROUND = 64, POINTS_FEW = 8, PROVEN_STEPS = 80 };
enum { WALK_MOST = 1000 /* steps of one size: along the ridge of a needle there is no end to them */ };
static const double SEEDS_APART = 0.9; /* cosine: two seeds farther apart than this are not the same maximum */

/* ---- bodies ---- */

static qmat rotation_of(const narrow_place *at)
{
    return oracle_rotation(at->q[0], at->q[1], at->q[2], at->q[3]);
}

typedef struct placed {
    oracle_body body;
    qvec *points;
} placed;

static void add(placed *p, double x, double y, double z)
{
    p->points[p->body.count++] = qv(x, y, z);
}

static void add_points(placed *p, const narrow_body *b)
{
    const double *h = b->half;
    size_t most = b->kind == KIND_HULL ? b->polytope->vertex_count : 8;
    p->points = calloc(most, sizeof *p->points);
    if (!p->points) abort();
    if (b->kind == KIND_SPHERE) add(p, 0, 0, 0);
    if (b->kind == KIND_CAPSULE) add(p, 0, 0, h[2]), add(p, 0, 0, -h[2]);
    for (int i = 0; b->kind == KIND_BOX && i < 8; i++)
        add(p, i & 1 ? h[0] : -h[0], i & 2 ? h[1] : -h[1], i & 4 ? h[2] : -h[2]);
    for (size_t i = 0; b->kind == KIND_HULL && i < most; i++) {
        const double *v = &b->polytope->vertices[3 * i];
        add(p, v[0], v[1], v[2]);
    }
}

/* In world axes, from `origin`: the difference of two doubles is exact in 113 bits unless they are absurdly unlike, and
 * what is far from the world's origin would lose the oracle's last digits. */
static placed place_body(const narrow_body *b, const narrow_place *at, const double origin[3])
{
    static const oracle_core CORES[KIND_COUNT] = {
        ORACLE_POINTS, ORACLE_POINTS, ORACLE_POINTS, ORACLE_CYLINDER, ORACLE_CONE, ORACLE_ELLIPSOID, ORACLE_POINTS};
    placed p = {.body = {.core = CORES[b->kind], .radius = b->radius, .rotation = rotation_of(at)}};
    p.body.position = q_sub(qv(at->p[0], at->p[1], at->p[2]), qv(origin[0], origin[1], origin[2]));
    if (p.body.core == ORACLE_POINTS)
        add_points(&p, b);
    else
        p.body.half = qv(b->half[0], b->half[1], b->half[2]);
    p.body.points = p.points;
    return p;
}

/* ---- the sweep ---- */

typedef struct seed {
    qvec n;
    quad f;
} seed;

/* Eight directions around, turned a little further each time: a maximum on a ridge is missed by fixed ones. */
static bool poll(const oracle_body *a, const oracle_body *b, quad step, double turned, seed *s)
{
    qvec least = q_abs(s->n.x) < 0.5 ? qv(1, 0, 0) : qv(0, 1, 0);
    qvec side = q_unit(q_cross(s->n, least)), other = q_cross(s->n, side);
    seed best = *s;
    for (int i = 0; i < 8; i++) {
        double angle = turned + 0.25 * M_PI * i;
        qvec aside = q_add(q_scale(side, step * cos(angle)), q_scale(other, step * sin(angle)));
        qvec n = q_unit(q_add(s->n, aside));
        quad f = oracle_separation(a, b, n);
        if (f > best.f) best = (seed){n, f};
    }
    bool better = best.f > s->f;
    *s = best;
    return better;
}

static void climb(const oracle_body *a, const oracle_body *b, quad from, quad to, seed *s)
{
    double turned = 0;
    for (quad step = from; step > to; step /= 2)
        for (int i = 0, walked = 0; i < POLLS && walked < WALK_MOST; i++, walked++) {
            turned += 2.4; /* the golden angle: never the same again */
            if (poll(a, b, step, turned, s)) i = -1;
        }
}

static void keep_seed(seed *seeds, size_t *count, seed s)
{
    for (size_t i = 0; i < *count; i++)
        if (q_dot(seeds[i].n, s.n) > SEEDS_APART) {
            if (s.f > seeds[i].f) seeds[i] = s;
            return;
        }
    size_t worst = 0;
    for (size_t i = 1; i < *count; i++)
        if (seeds[i].f < seeds[worst].f) worst = i;
    if (*count < SEEDS)
        seeds[(*count)++] = s;
    else if (s.f > seeds[worst].f)
        seeds[worst] = s;
}

/* Directions on a spiral (Fibonacci's sphere), and the best of them climbed: roughly all, to the end the best. */
static seed sweep_sphere(const oracle_body *a, const oracle_body *b)
{
    seed seeds[SEEDS];
    size_t count = 0;
    for (int i = 0; i < SWEEP; i++) {
        double z = 1 - (2 * i + 1) / (double)SWEEP, r = sqrt(1 - z * z), angle = 2.399963229728653 * i;
        qvec n = q_unit(qv(r * cos(angle), r * sin(angle), z));
        keep_seed(seeds, &count, (seed){n, oracle_separation(a, b, n)});
    }
    seed best = {.f = -INFINITY};
    for (size_t i = 0; i < count; i++) {
        climb(a, b, 0x1p-5, 0x1p-14, &seeds[i]);
        if (seeds[i].f > best.f) best = seeds[i];
    }
    climb(a, b, 0x1p-13, 0x1p-50, &best);
    return best;
}

/* ---- the ridges: where a climb in two dimensions stalls, one along them does not ---- */

typedef struct circle { /* of directions: n.axis = height */
    qvec axis, u, v;
    quad height, radius;
} circle;

static circle circle_around(qvec axis, quad height)
{
    circle c = {.axis = axis, .height = height, .radius = q_sqrt(1 - height * height)};
    c.u = q_unit(q_cross(axis, q_abs(axis.x) < 0.5 ? qv(1, 0, 0) : qv(0, 1, 0)));
    c.v = q_cross(axis, c.u);
    return c;
}

static seed on_circle(const oracle_body *a, const oracle_body *b, const circle *c, double angle)
{
    qvec around = q_add(q_scale(c->u, cos(angle)), q_scale(c->v, sin(angle)));
    qvec n = q_unit(q_add(q_scale(c->axis, c->height), q_scale(around, c->radius)));
    return (seed){n, oracle_separation(a, b, n)};
}

static seed climb_circle(const oracle_body *a, const oracle_body *b, const circle *c, double angle, seed s)
{
    for (double step = M_PI / ROUND; step > 0x1p-50;) {
        seed ahead = on_circle(a, b, c, angle + step), back = on_circle(a, b, c, angle - step);
        bool forward = ahead.f >= back.f;
        seed best = forward ? ahead : back;
        if (best.f > s.f)
            s = best, angle += forward ? step : -step;
        else
            step /= 2;
    }
    return s;
}

static void keep_best(seed *best, seed s)
{
    if (s.f > best->f) *best = s;
}

static void sweep_circle(const oracle_body *a, const oracle_body *b, qvec axis, quad height, seed *best)
{
    circle c = circle_around(axis, height);
    seed around[ROUND];
    for (int i = 0; i < ROUND; i++) around[i] = on_circle(a, b, &c, 2 * M_PI * i / ROUND);
    for (int i = 0; i < ROUND; i++) {
        seed before = around[(i + ROUND - 1) % ROUND], after = around[(i + 1) % ROUND];
        if (around[i].f >= before.f && around[i].f >= after.f)
            keep_best(best, climb_circle(a, b, &c, 2 * M_PI * i / ROUND, around[i]));
    }
}

/* The support function of a body has kinks at the normals of its flat faces and on the circles of directions orthogonal
 * to its straight lines: across z (cylinder), the normals of the side (cone), across each edge (box). `sign`: A is
 * asked along n, B along -n. */
static void sweep_ridges(const oracle_body *a, const oracle_body *b, const oracle_body *of, int sign, seed *best)
{
    const qvec axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (of->core == ORACLE_ELLIPSOID) return;
    bool box = of->core == ORACLE_POINTS, cone = of->core == ORACLE_CONE;
    for (int i = box ? 0 : 2; i < 3; i++) {
        qvec axis = q_scale(q_mul(of->rotation, axes[i]), sign);
        keep_best(best, (seed){axis, oracle_separation(a, b, axis)});
        keep_best(best, (seed){q_neg(axis), oracle_separation(a, b, q_neg(axis))});
        quad r = of->half.x, h = 2 * of->half.z;
        sweep_circle(a, b, axis, cone ? r / q_sqrt(r * r + h * h) : 0, best);
    }
}

static oracle_truth sweep(const oracle_body *a, const oracle_body *b)
{
    seed best = sweep_sphere(a, b);
    sweep_ridges(a, b, a, 1, &best);
    sweep_ridges(a, b, b, -1, &best);
    quad slack = (quad)1e-13 * oracle_size(a, b);
    return (oracle_truth){.lo = best.f, .hi = best.f + slack, .axis = best.n};
}

/* ---- the choice ---- */

static oracle_truth measure(const oracle_body *a, const oracle_body *b, bool apart)
{
    bool points = a->core == ORACLE_POINTS && b->core == ORACLE_POINTS;
    if (points && a->count <= POINTS_FEW && b->count <= POINTS_FEW) return oracle_distance_features(a, b);
    return points || apart ? oracle_distance_bounds(a, b) : sweep(a, b);
}

/* A separating direction, if the line of centres is one or leads to one. */
static bool are_apart(const oracle_body *a, const oracle_body *b)
{
    seed s = {.n = q_unit(q_sub(b->position, a->position))};
    s.f = oracle_separation(a, b, s.n);
    for (quad step = 0.5; step > 0x1p-12 && s.f <= 0; step /= 2) {
        for (int i = 0; i < WALK_MOST && s.f <= 0 && poll(a, b, step, (double)step, &s);) i++;
    }
    return s.f > 0;
}

/* A direction that the engine found deepest; what the oracle makes of it is a bound like that of any other. */
static seed hinted(const narrow_item *item, const oracle_body *a, const oracle_body *b)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    shape shape_a = narrow_scene_shape(item->a), shape_b = narrow_scene_shape(item->b);
    narrow_request r = {.facts = NARROW_DISTANCE, .range = INFINITY};
    narrow_result found;
    narrow_query_world(
        &shape_a, narrow_scene_pose(&item->at_a), &shape_b, narrow_scene_pose(&item->at_b), &r, scratch, &found);
    seed s = {.n = q_unit(qv(found.axis.x, found.axis.y, found.axis.z))};
    s.f = oracle_separation(a, b, s.n);
    climb(a, b, 0x1p-20, 0x1p-52, &s);
    return s;
}

narrow_truth narrow_truth_proven(const narrow_item *item)
{
    const double *origin = item->at_a.p;
    placed a = place_body(item->a, &item->at_a, origin), b = place_body(item->b, &item->at_b, origin);
    bool apart = are_apart(&a.body, &b.body), curved = a.body.core != ORACLE_POINTS || b.body.core != ORACLE_POINTS;
    oracle_truth t = measure(&a.body, &b.body, apart);
    if (curved && !apart) {
        oracle_truth proven = oracle_distance_bounds_in(&a.body, &b.body, PROVEN_STEPS);
        t.lo = q_max(q_max(t.lo, proven.lo), hinted(item, &a.body, &b.body).f);
        t.hi = q_max(proven.hi, t.lo);
    }
    quad size = oracle_size(&a.body, &b.body);
    narrow_truth out = {.distance = t.lo, .lo = t.lo, .hi = t.hi, .size = (double)size};
    free(a.points);
    free(b.points);
    return out;
}

narrow_truth narrow_truth_of(const narrow_item *item)
{
    const double *origin = item->at_a.p;
    placed a = place_body(item->a, &item->at_a, origin), b = place_body(item->b, &item->at_b, origin);
    oracle_truth t = measure(&a.body, &b.body, are_apart(&a.body, &b.body));
    quad size = oracle_size(&a.body, &b.body);
    narrow_truth out = {.distance = t.lo, .lo = t.lo, .hi = t.hi, .size = (double)size};
    free(a.points);
    free(b.points);
    return out;
}
