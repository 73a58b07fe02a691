/* The nearest or deepest pair of parts, and what follows from it for the unions. Pure; any thread. */
#include "compound_pair.h"

#include "dispatch.h"
#include "scalar.h"

/* With tolerance 0 an interval this narrow (relative to the pair's size) counts as narrow, as in narrow.c. */
#define FINEST 1e-12

typedef struct nearest_search {
    narrow_request request; /* of a pair of parts */
    double far, near;       /* m; a lower bound above, an upper bound at or below them is enough */
    narrow_scratch *scratch;
    narrow_result best; /* of the pair with the least upper bound so far */
    uint32_t parts[2];
    double least; /* m, a lower bound of all parts that were looked at */
    bool found;
    uint32_t iterations, peer_failures;
} nearest_search;

static bool nearer(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context)
{
    nearest_search *q = context;
    narrow_result r;
    compound_parts_query(w, part_a, part_b, &q->request, q->scratch, &r);
    q->least = min_of(q->least, r.lo);
    q->iterations += r.iterations;
    q->peer_failures += r.peer_failures;
    if (!q->found || r.hi < q->best.hi) {
        q->best = r;
        q->parts[0] = part_a;
        q->parts[1] = part_b;
        q->found = true;
        w->within = min_of(r.hi, max_of(q->far, 0)) * w->scale;
        q->request.range = min_of(q->far, max_of(r.hi, 0));
    }
    return q->best.hi > q->near;
}

static bool decides(const narrow_request *r)
{
    return r->facts == 0 || (r->facts & (NARROW_VERDICT | NARROW_MANIFOLD));
}

static nearest_search search_for(const narrow_request *r, narrow_scratch *scratch)
{
    bool measures = r->facts & (NARROW_DISTANCE | NARROW_MANIFOLD);
    nearest_search q = {.request = *r, .scratch = scratch, .least = INFINITY};
    q.far = max_of(decides(r) ? r->threshold : -INFINITY, r->facts & NARROW_DISTANCE ? r->range : -INFINITY);
    q.near = measures ? -INFINITY : r->threshold;
    q.request.facts = measures ? NARROW_DISTANCE : NARROW_VERDICT;
    if (measures && decides(r)) q.request.facts |= NARROW_VERDICT;
    q.request.range = q.far;
    return q;
}

/* ---- overlap ---- */

/* Their convex hulls, along the axis: a lower bound whatever the axis. */
static double hulls_along(const unit_pair *p, vec3 axis)
{
    if (p->a.type == SHAPE_HALFSPACE) return -INFINITY;
    double gap = vec_dot(axis, unit_pair_nearest_along(p, axis).w);
    return gap - p->radius - p->error - p->excess;
}

static void by_hulls(const unit_pair *p, double tolerance, epa_scratch *epa, narrow_result *out)
{
    const narrow_goal measure = {.tolerance = tolerance,
        .finest = FINEST * p->size,
        .far = INFINITY,
        .near = -INFINITY,
        .above = -INFINITY,
        .below = INFINITY};
    span s;
    dispatch_general(p, &measure, true, VEC_ZERO, epa, &s);
    double lo = (s.lo - p->radius - p->error - p->excess) * p->unit;
    if (lo <= out->lo) return;
    out->lo = lo;
    out->axis = direction_again(s.axis);
}

/* The bound by the hulls is worth knowing to this part of the bracket that there is without it. */
static const double HULL_SHARE = 0.01;

static void lower_bound(const unit_pair *p, compound_walk *w, const nearest_search *q, double asked,
    narrow_scratch *scratch, epa_scratch *epa, narrow_result *out)
{
    int64_t kept = effort_keep_back(w->effort, EFFORT_OF_HULLS);
    compound_way way = compound_way_out(w, &q->best, q->parts, scratch);
    out->lo = -way.length * p->unit;
    if (way.length < INFINITY) out->axis = way.axis;
    effort_give_back(w->effort, kept);
    if (out->hi - out->lo <= asked) return;
    double open = min_of((out->hi - out->lo) * p->scale, p->size);
    by_hulls(p, max_of(asked * p->scale, HULL_SHARE * open), epa, out);
}

/* The hull of a mesh stands for it beyond its faces; that of a compound is its own. */
static unit_pair hulls_of(const unit_pair *p)
{
    unit_pair hulls = *p;
    if (hulls.a.type == SHAPE_MESH) hulls.a.type = SHAPE_HULL;
    return hulls;
}

static double asked_width(const unit_pair *p, const narrow_request *r)
{
    return r->tolerance > 0 ? r->tolerance : FINEST * p->size * p->unit;
}

static void settle(const unit_pair *p, const nearest_search *q, const narrow_request *r, narrow_result *out)
{
    bool equal = out->lo == out->hi && (r->tolerance == 0 || isinf(out->hi));
    bool narrow = equal || out->hi - out->lo <= asked_width(p, r);
    bool decided = !(r->facts & NARROW_DISTANCE) && decides(r) && (out->lo > r->threshold || out->hi <= r->threshold);
    bool manifold = r->facts & NARROW_MANIFOLD;
    bool enough = narrow || out->lo > q->far || (decided && !manifold);
    out->status = enough ? NARROW_CERTAIN : NARROW_WIDE;
}

void compound_pair_query(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_request *request, narrow_scratch *scratch, epa_scratch *epa, union_scratch *parts, narrow_result *out)
{
    compound_walk w;
    compound_walk_init(&w, p, a, b, *b_in_a);
    if (compound_part_count(&w.a) == 1 && compound_part_count(&w.b) == 1) {
        compound_parts_query(&w, 0, 0, request, scratch, out);
        return;
    }
    nearest_search q = search_for(request, scratch);
    w.effort->counts = true; /* nothing is remembered */
    int64_t kept = effort_keep_back(w.effort, EFFORT_OF_WAYS_OUT);
    compound_walk_run(&w, INFINITY, nearer, &q);
    effort_give_back(w.effort, kept);
    *out = q.best;
    out->manifold.count = 0;
    bool ended = q.best.hi <= q.near;
    double least = min_of(q.least, w.left_out * p->unit);
    unit_pair hulls = hulls_of(p);
    if (ended)
        out->lo = min_of(hulls_along(&hulls, out->axis) * p->unit, out->hi);
    else if (least > 0 || w.plane)
        out->lo = min_of(least, out->hi);
    else
        lower_bound(&hulls, &w, &q, asked_width(p, request), scratch, epa, out);
    if (!ended && out->hi < 0 && out->hi - out->lo > asked_width(p, request))
        compound_search_depth(p, &w, a, b, asked_width(p, request), scratch, parts, out);
    out->lo = min_of(out->lo, out->hi);
    out->iterations = q.iterations + w.visits;
    out->peer_failures = q.peer_failures;
    settle(p, &q, request, out);
    if (!(request->facts & NARROW_MANIFOLD) || !(out->lo <= request->threshold)) return;
    w.effort->left = EFFORT_OF_POINTS;
    compound_manifold(&w, out, request->threshold, scratch, &out->manifold);
    if (w.effort->left < 0) out->status = NARROW_WIDE;
}
