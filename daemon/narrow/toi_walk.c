/* toi_walk: boxes of two hierarchies along their motions, the earliest first: each pair of boxes is itself a pair of
 * convex shapes that move, so the same search says from when on their parts can meet, and what cannot meet before the
 * first contact that is found is left out. Pure; any thread.
 *
 * A solid can be entered only through its surface, so that after the first moment its triangles are all that counts.
 *
 * With a threshold below zero contact is a depth, and no part is ever as deep as the whole: parts are walked until they
 * touch, and from there on the whole shapes are looked at. */
#include "toi_walk.h"

#include "scalar.h"
#include "toi_parts.h"
#include "toi_sweep.h"
#include "unit_pair.h"

enum { VISITS_MAX = 1 << 17 };      /* pairs of boxes or parts: beyond it TOI_UNDECIDED */
static const double ROUGHLY = 0.02; /* boxes are told apart to within so much of their size */

typedef struct walk {
    const toi_mover *a, *b;
    const toi_request *request; /* of parts: its threshold is not below zero */
    double threshold;           /* m: that of the whole shapes */
    narrow_scratch *scratch;
    double until;   /* nothing after it matters: the first proven contact, or the span */
    double skipped; /* from here on may be contacts that were not looked for any more */
    uint32_t visits;
    bool sweeps; /* parts are told apart by toi_sweep.h, otherwise as two shapes that move */
    sweep sweep;
    toi_result *out;
} walk;

static toi_mover mover_of(const toi_mover *whole, const toi_part *p)
{
    return (toi_mover){&p->shape, pose_mul(whole->local, p->local), whole->motion};
}

/* Two parts, in whatever order their types are. */
static void ask(
    const walk *w, const toi_part *a, const toi_part *b, double from, double tolerance, bool rough, toi_result *r)
{
    toi_mover ma = mover_of(w->a, a), mb = mover_of(w->b, b);
    toi_request request = *w->request;
    request.span = w->until;
    request.tolerance = tolerance;
    *r = (toi_result){.status = TOI_FREE, .lo = INFINITY, .hi = INFINITY};
    bool turned = a->shape.type > b->shape.type;
    toi_convex(turned ? &mb : &ma, turned ? &ma : &mb, &request, VEC_ZERO, from, rough, w->scratch, r);
    if (!turned) return;
    vec3 point_a = r->point_b;
    r->axis = vec_neg(r->axis);
    r->point_b = r->point_a;
    r->point_a = point_a;
}

static void keep(walk *w, const toi_result *r)
{
    toi_result *out = w->out;
    double hi = min_of(out->hi, r->hi);
    uint32_t queries = out->queries, steps = out->steps;
    if (r->lo < out->lo) *out = *r;
    out->hi = hi;
    out->queries = queries;
    out->steps = steps;
    w->until = min_of(w->until, w->request->wander > 0 ? out->lo : hi);
}

/* Until when two parts that do not meet before `from` are apart, by the search for convex shapes; leaves are kept. */
static double search(walk *w, const toi_part *a, const toi_part *b, double from)
{
    toi_result r;
    bool leaves = a->is_leaf && b->is_leaf;
    double tolerance = w->request->tolerance;
    if (w->until <= 0) return INFINITY; /* nothing comes before the beginning */
    if (!leaves) tolerance = max_of(tolerance, ROUGHLY * (a->size + b->size));
    ask(w, a, b, from, tolerance, !leaves || w->request->wander > 0, &r);
    w->out->queries += r.queries;
    w->out->steps += r.steps;
    if (r.status == TOI_FREE) return INFINITY;
    if (leaves) keep(w, &r);
    return r.lo;
}

/* Until when they are certainly apart. Leaves of which that is not clear enough are searched when it is their turn. */
static double look(walk *w, const toi_part *a, const toi_part *b, double from, vec3 *hint)
{
    w->visits++;
    if (w->until <= 0) return INFINITY;
    if (!w->sweeps) return search(w, a, b, from);
    w->out->steps++;
    return sweep_entry(&w->sweep, a, b, from, w->until, hint);
}

static void descend(walk *w, const toi_part *a, const toi_part *b, double since, vec3 hint)
{
    toi_part children[PART_CHILDREN_MAX];
    double from[PART_CHILDREN_MAX];
    bool of_a = !a->is_leaf && (b->is_leaf || a->size >= b->size);
    int count = toi_part_children(of_a ? a : b, children);
    bool is_last = of_a ? b->is_leaf : a->is_leaf;
    vec3 hints[PART_CHILDREN_MAX];
    for (int k = 0; k < count; k++) {
        hints[k] = hint;
        from[k] = look(w, of_a ? &children[k] : a, of_a ? b : &children[k], since, &hints[k]);
    }
    for (int n = 0; n < count; n++) {
        int first = 0;
        for (int k = 1; k < count; k++)
            if (from[k] < from[first]) first = k;
        double at = from[first];
        const toi_part *part_a = of_a ? &children[first] : a, *part_b = of_a ? b : &children[first];
        from[first] = INFINITY;
        if (at > w->until || at == INFINITY) return;
        if (w->visits > VISITS_MAX)
            w->skipped = min_of(w->skipped, at);
        else if (!is_last || !children[first].is_leaf)
            descend(w, part_a, part_b, at, hints[first]);
        else if (w->sweeps) /* otherwise it was searched when it was looked at */
            (void)search(w, part_a, part_b, at);
    }
}

/* ---- the whole shapes ---- */

/* At a time, certified: in world axes about the origin of A's body then. */
static void look_whole(walk *w, double time, unsigned facts, double range, narrow_result *n)
{
    const motion *a = &w->a->motion, *b = &w->b->motion;
    vec3 apart = vec_madd(vec_sub(b->start.p, a->start.p), time, vec_sub(b->linear, a->linear));
    pose at_a = pose_mul((pose){VEC_ZERO, motion_pose(a, time).q}, w->a->local);
    pose at_b = pose_mul((pose){apart, motion_pose(b, time).q}, w->b->local);
    narrow_request r = {.facts = facts, .tolerance = w->request->tolerance, .range = range, .threshold = w->threshold};
    narrow_query_world(w->a->shape, at_a, w->b->shape, at_b, &r, w->scratch, n);
    w->out->queries++;
    n->lo -= w->sweep.course.slack;
    n->hi += w->sweep.course.slack;
    n->point_a = vec_add(n->point_a, at_a.p);
    n->point_b = vec_add(n->point_b, at_a.p);
}

/* An interval that is wider than asked, because the effort of a query has ended, does not say that they are near. */
static toi_status near_or_undecided(const walk *w, double floor, const narrow_result *n)
{
    bool is_near = n->hi - floor <= 2 * (w->request->tolerance + w->sweep.course.slack);
    return is_near ? TOI_NEAR : TOI_UNDECIDED;
}

/* What is told of the time lo. */
static void describe(walk *w, double time, const narrow_result *n)
{
    toi_result *out = w->out;
    vec3 origin = motion_pose(&w->a->motion, time).p;
    out->lo = time;
    out->gap_lo = n->lo;
    out->gap_hi = n->hi;
    out->axis = n->axis;
    out->point_a = vec_add(origin, n->point_a);
    out->point_b = vec_add(origin, n->point_b);
    out->closing = -vec_dot(n->axis, course_velocity(&w->sweep.course, time, n->point_a, n->point_b));
}

static void tell_contact(walk *w, double time)
{
    w->out->status = TOI_HIT;
    w->out->hi = time;
}

enum { PROOFS_MAX = 24, DEEPER_MAX = 64 };

/* Solids whose faces meet flat overlap without any two triangles that do: the whole shapes prove the contact. */
static void prove_contact(walk *w)
{
    toi_result *out = w->out;
    double gap = max_of(out->gap_hi - w->threshold, 0) + w->request->tolerance, time = out->lo;
    double step = out->closing > 0 ? gap / out->closing : 0x1p-20 * w->request->span;
    for (int k = 0; k < PROOFS_MAX && time < w->request->span; k++, step *= 2) {
        time = min_of(time + step, w->request->span);
        narrow_result n;
        look_whole(w, time, NARROW_VERDICT, INFINITY, &n);
        if (n.hi <= w->threshold) tell_contact(w, time);
        if (n.hi <= w->threshold || n.lo > w->threshold) return;
    }
}

/* m: the least gap of the whole that counts as apart at a time. */
static double floor_at(const walk *w, double time)
{
    return w->threshold + 0.5 * w->request->wander * time * time * (1 + 4 * UNIT_ROUNDOFF);
}

/* m: how far beyond that the convex hulls are along a world direction, proven. */
static double spare_along(const walk *w, double time, vec3 direction)
{
    const course *c = &w->sweep.course;
    course_place at = course_at(c, time);
    return course_separation(c, &at, direction) - c->slack - floor_at(w, time);
}

/* m: what is left of the gap at a time, when two points that approach each other at the course's speed use it up. The
 * gap along a direction does; so does what is left between two that are apart, and of those that do not turn any. */
static double spare_at(const walk *w, double time, const narrow_result *n)
{
    double all = n->lo - floor_at(w, time), hulls = spare_along(w, time, n->axis);
    double whole = w->sweep.course.straight ? all : min_of(all, n->lo);
    return max_of(hulls, whole) * (1 - 64 * UNIT_ROUNDOFF);
}

/* Up to `time` they are not as deep as the threshold: goes on by the whole shapes until they may be. */
static void deepen(walk *w, double time)
{
    const course *c = &w->sweep.course;
    double span = w->request->span, wander = w->request->wander, spare = 0;
    toi_result *out = w->out;
    narrow_result n;
    for (int k = 0;; k++) {
        look_whole(w, time, NARROW_DISTANCE, INFINITY, &n);
        spare = spare_at(w, time, &n);
        double last = min_of(spare_along(w, time, n.axis), spare_along(w, span, n.axis));
        double step = course_step_until_used(spare, -(c->speed + wander * time), wander);
        bool is_free = last > course_dip(c, span - time) || (spare > 0 && step >= span - time);
        if (is_free) {
            *out = (toi_result){
                .status = TOI_FREE, .lo = INFINITY, .hi = INFINITY, .queries = out->queries, .steps = out->steps};
            return;
        }
        if (spare <= w->request->tolerance || !(time + step > time) || k == DEEPER_MAX) break;
        time += step;
    }
    describe(w, time, &n);
    out->hi = INFINITY;
    out->status = near_or_undecided(w, floor_at(w, time), &n);
    if (wander > 0) return;
    if (n.hi <= w->threshold)
        tell_contact(w, time);
    else
        prove_contact(w);
}

/* What was kept is of the two parts that meet first; at that time others may be nearer. The whole is no farther apart
 * than any two of its parts, and apart before. */
static void tell_nearest(walk *w)
{
    toi_result *out = w->out;
    narrow_result n;
    look_whole(w, out->lo, NARROW_DISTANCE, out->gap_hi + 4 * w->sweep.course.slack, &n);
    if (n.hi < out->gap_lo) describe(w, out->lo, &n);
    out->gap_lo = min_of(out->gap_lo, max_of(n.lo, w->threshold));
}

/* Do they touch at the beginning? A shape may lie inside of a solid without touching a triangle. */
static bool begins_in_contact(walk *w)
{
    narrow_result n;
    look_whole(w, 0, w->threshold < 0 ? NARROW_DISTANCE : NARROW_VERDICT, INFINITY, &n);
    if (n.lo > w->threshold) {
        if (n.lo <= 0) deepen(w, 0);
        return n.lo <= 0;
    }
    if (n.hi > w->threshold && w->threshold >= 0) /* a verdict stops short of the motion's rounding */
        look_whole(w, 0, NARROW_DISTANCE, INFINITY, &n);
    describe(w, 0, &n);
    w->out->status = near_or_undecided(w, w->threshold, &n);
    w->out->hi = INFINITY;
    if (n.hi <= w->threshold)
        tell_contact(w, 0);
    else if (w->request->wander == 0 && n.hi <= w->threshold + w->request->tolerance)
        prove_contact(w);
    return true;
}

/* The walk ended with parts left that may meet from `skipped` on. */
static void tell_skipped(walk *w)
{
    narrow_result n;
    look_whole(w, w->skipped, NARROW_DISTANCE, INFINITY, &n);
    describe(w, w->skipped, &n);
    if (n.hi <= w->threshold && w->request->wander == 0) w->out->hi = w->skipped;
    w->out->status = w->out->hi == INFINITY ? TOI_UNDECIDED : TOI_HIT;
}

void toi_walk(
    const toi_mover *a, const toi_mover *b, const toi_request *request, narrow_scratch *scratch, toi_result *out)
{
    walk w; /* its sweep is large, and makes itself ready */
    toi_request of_parts = *request;
    of_parts.threshold = max_of(request->threshold, 0);
    w.a = a;
    w.b = b;
    w.request = &of_parts;
    w.threshold = request->threshold;
    w.scratch = scratch;
    w.until = request->span;
    w.skipped = INFINITY;
    w.visits = 0;
    w.out = out;
    toi_part root_a, root_b;
    vec3 hint = VEC_ZERO;
    toi_part_root(a->shape, &root_a);
    toi_part_root(b->shape, &root_b);
    w.sweeps = sweep_init(&w.sweep, a, b, &of_parts);
    double from = w.sweeps ? look(&w, &root_a, &root_b, 0, &hint) : 0;
    if (from == 0 && begins_in_contact(&w)) return;
    if (!w.sweeps) from = look(&w, &root_a, &root_b, 0, &hint);
    if (from == INFINITY) return;
    descend(&w, &root_a, &root_b, from, hint);
    double parts_touch = min_of(out->lo, w.skipped);
    if (w.threshold < 0) {
        if (parts_touch < INFINITY) deepen(&w, parts_touch);
        return;
    }
    if (out->status == TOI_NEAR && out->hi == INFINITY && request->wander == 0) prove_contact(&w);
    if (w.skipped <= out->lo && w.skipped != INFINITY) {
        tell_skipped(&w);
        return;
    }
    if (out->hi != INFINITY) out->status = TOI_HIT;
    if (out->status != TOI_FREE) tell_nearest(&w);
}
