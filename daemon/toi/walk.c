/* toi_walk: boxes of two hierarchies along their motions, the earliest first: directions say from when on their parts
 * can meet (sweep.h), and what cannot meet before the first contact that is found is left out. Triangles that no
 * direction keeps apart are two convex shapes that move, for the search of toi.h. Pure; any thread.
 *
 * Stretch by stretch of the time, each short enough for the boxes to be told apart again where they have parted; what
 * it takes is counted, and where it is too much, the answer is the time up to which they are apart.
 *
 * A solid can be entered only through its surface, so that after the first moment its triangles are all that counts.
 *
 * With a threshold below zero contact is a depth, and no part is ever as deep as the whole: parts are walked until they
 * touch, and from there on the whole shapes are looked at. */
#include "narrow/math/scalar.h"
#include "narrow/narrow.h"
#include "narrow/pair/unit_pair.h"
#include "sweep.h"

/* What the steps of a search count for, besides those of sweep.h, in the units of TOI_WORK_MAX. */
enum {
    WORK_VISIT = 5,          /* a pair of boxes or parts, made ready */
    WORK_QUERY = 60,         /* a distance or verdict of two parts */
    WORK_WHOLE = 50,         /* a distance or verdict of the whole shapes */
    WORK_WHOLE_TRIANGLE = 1, /* more for each triangle that they have */
    WORK_DEPTH_TRIANGLE = 64 /* the same where a depth is asked for */
};

/* A stretch of time that takes more than this share of what is left is given up, and a shorter one begun: most of it at
 * first, so that what can be decided is; then half, so that some of the time is. */
static const double SHARE = 0.95, SHARE_AGAIN = 0.5;
enum { SHORTER = 8, LONGER = 2, GIVEN_UP_MAX = 6 };

static const double BLUR = 0.25; /* of the tolerance */
enum {
    NEARS_MAX = 16
}; /* parts that come near at about one time: whether that is contact is then asked of the whole */

static const double WHOLE_TURNS = 6; /* rad: a shape that turns by more is first tried as what it sweeps */
static const double ROUGHLY = 0.002; /* of its size: how closely that is looked at */

typedef struct walk {
    const toi_mover *a, *b;
    const toi_request *request; /* of parts: its threshold is not below zero */
    double threshold;           /* m: that of the whole shapes */
    narrow_scratch *scratch;
    double until;     /* nothing after it matters: the time of a contact that was found, or the end of the stretch */
    double skipped;   /* from here on may be contacts that were not looked for any more */
    uint64_t most;    /* work, for all */
    uint64_t allowed; /* work, up to which it goes on */
    double blur;      /* s: contacts closer in time than this are taken as simultaneous; well above rounding */
    uint32_t nears;   /* parts that came within the tolerance */
    bool rough;       /* within the tolerance is as good as contact */
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

static void walk_keep(walk *w, const toi_result *r)
{
    toi_result *out = w->out;
    double hi = min_of(out->hi, r->hi);
    uint32_t queries = out->queries, steps = out->steps;
    if (r->lo < out->lo) *out = *r;
    out->hi = hi;
    out->queries = queries;
    out->steps = steps;
    w->nears += r->status == TOI_NEAR;
    bool settled =
        w->request->wander > 0 || hi < INFINITY || w->nears > NEARS_MAX; /* what comes later does not count */
    if (settled) w->until = min_of(w->until, max_of(out->lo - w->blur, w->sweep.start));
}

/* Two parts that do not meet before `from`, by the search for convex shapes. */
static void walk_search(walk *w, const toi_part *a, const toi_part *b, double from)
{
    toi_result r;
    if (w->until <= 0) return; /* nothing comes before the beginning */
    ask(w, a, b, from, w->request->tolerance, w->rough, &r);
    w->out->queries += r.queries;
    w->out->steps += r.steps;
    w->sweep.work += WORK_QUERY * (uint64_t)r.queries + r.steps;
    if (r.status != TOI_FREE) walk_keep(w, &r);
}

/* Until when they are certainly apart. */
static double walk_look(walk *w, const toi_part *a, const toi_part *b, double from, vec3 *hint)
{
    if (w->until <= 0) return INFINITY;
    w->out->steps++;
    w->sweep.work += WORK_VISIT;
    return sweep_entry(&w->sweep, a, b, from, w->until, hint);
}

/* The earliest of some times that are not beyond `until`; -1: there is none. It is taken out. */
static int take_earliest(double *from, int count, double until, double *at)
{
    int first = 0;
    for (int k = 1; k < count; k++)
        if (from[k] < from[first]) first = k;
    *at = from[first];
    from[first] = INFINITY;
    return *at == INFINITY || *at > until ? -1 : first;
}

/* More than is allowed was done: what is left may meet from then on. */
static bool skips(walk *w, double at)
{
    if (w->sweep.work <= w->allowed) return false;
    w->skipped = min_of(w->skipped, at);
    return true;
}

/* Two leaves of meshes. */
static void meet_leaves(walk *w, const toi_part *a, const toi_part *b, double since, vec3 hint)
{
    double from[LEAF_PAIRS], at;
    toi_part of_a[PART_CHILDREN_MAX], of_b[PART_CHILDREN_MAX];
    bool made = false;
    w->out->steps++;
    toi_leaves_entries(&w->sweep, a, b, since, w->until, from);
    for (int k; (k = take_earliest(from, LEAF_PAIRS, w->until, &at)) >= 0;) {
        if (skips(w, at)) return;
        if (!made) {
            (void)toi_part_children(a, of_a);
            (void)toi_part_children(b, of_b);
            made = true;
        }
        vec3 own = hint;
        const toi_part *x = &of_a[k / MESH_LEAF_MAX], *y = &of_b[k % MESH_LEAF_MAX];
        double entry = walk_look(w, x, y, at, &own);
        if (entry != INFINITY) walk_search(w, x, y, entry);
    }
}

static void walk_descend(walk *w, const toi_part *a, const toi_part *b, double since, vec3 hint)
{
    toi_part children[PART_CHILDREN_MAX];
    double from[PART_CHILDREN_MAX], at;
    bool leaf_a = toi_leaves_apply(a), leaf_b = toi_leaves_apply(b);
    if (leaf_a && leaf_b) {
        meet_leaves(w, a, b, since, hint);
        return;
    }
    bool last_a = a->is_leaf || (leaf_a && !b->is_leaf), last_b = b->is_leaf || (leaf_b && !a->is_leaf);
    bool of_a = !last_a && (last_b || a->size >= b->size);
    int count = toi_part_children(of_a ? a : b, children);
    vec3 hints[PART_CHILDREN_MAX];
    for (int k = 0; k < count; k++) {
        hints[k] = hint;
        from[k] = walk_look(w, of_a ? &children[k] : a, of_a ? b : &children[k], since, &hints[k]);
    }
    for (int k; (k = take_earliest(from, count, w->until, &at)) >= 0;) {
        const toi_part *part_a = of_a ? &children[k] : a, *part_b = of_a ? b : &children[k];
        if (skips(w, at)) return;
        if (part_a->is_leaf && part_b->is_leaf)
            walk_search(w, part_a, part_b, at);
        else
            walk_descend(w, part_a, part_b, at, hints[k]);
    }
}

/* From `from` to the end of the stretch: all that may meet in it. */
static void walk_stretch(walk *w, double from)
{
    toi_part a, b;
    vec3 hint = VEC_ZERO;
    toi_part_root(w->a->shape, &a);
    toi_part_root(w->b->shape, &b);
    w->until = w->sweep.end;
    w->skipped = INFINITY;
    w->nears = 0;
    double at = walk_look(w, &a, &b, from, &hint);
    if (at == INFINITY) return;
    if (a.is_leaf && b.is_leaf)
        walk_search(w, &a, &b, at);
    else
        walk_descend(w, &a, &b, at, hint);
}

/* Nothing was kept, but what it took. */
static void forget(walk *w)
{
    *w->out = (toi_result){
        .status = TOI_FREE, .lo = INFINITY, .hi = INFINITY, .queries = w->out->queries, .steps = w->out->steps};
}

/* Stretch by stretch from `from` on, given that they do not meet before. What one finds is the first of all; one that
 * takes too much is given up for a shorter one, so that what is left is spent on the earliest times. Then, or where
 * parts are left that were not looked at, w->skipped is the time up to which they are apart. */
static void walk_stretches(walk *w, double from)
{
    double span = w->request->span, length = span - from, done = from;
    uint64_t all = w->allowed;
    w->blur = w->sweep.course.speed > 0 ? BLUR * w->request->tolerance / w->sweep.course.speed : 0;
    w->skipped = INFINITY;
    for (int given_up = 0; done < span;) {
        uint64_t left = all > w->sweep.work ? all - w->sweep.work : 0;
        w->allowed = w->sweep.work + (uint64_t)((given_up ? SHARE_AGAIN : SHARE) * (double)left);
        sweep_begin(&w->sweep, done, min_of(done + length, span));
        walk_stretch(w, done);
        toi_result *out = w->out;
        if (out->status != TOI_FREE && out->lo < w->skipped) { /* it comes before all that was not looked at */
            out->lo = min_of(out->lo, w->until);
            w->skipped = INFINITY;
            return;
        }
        double begun = w->sweep.end - done;
        if (w->skipped == INFINITY && begun > 0) {
            done = w->sweep.end;
            length = LONGER * begun;
            continue;
        }
        done = max_of(done, min_of(w->skipped, w->sweep.end));
        forget(w);
        length = begun / SHORTER;
        if (++given_up > GIVEN_UP_MAX || !(done + length > done)) break;
    }
    w->skipped = done < span ? done : INFINITY;
}

/* A time up to which what they sweep, when those that turn much turn for ever, is apart. */
static double walk_free_while_spun(walk *w)
{
    const toi_mover *a = w->a, *b = w->b;
    double span = w->request->span;
    bool spin_a = vec_norm(a->motion.angular) * span > WHOLE_TURNS;
    bool spin_b = vec_norm(b->motion.angular) * span > WHOLE_TURNS;
    if (!spin_a && !spin_b) return 0;
    shape shape_a, shape_b;
    toi_mover spun_a = *a, spun_b = *b;
    if (spin_a && !course_spin(a, &shape_a, &spun_a)) return 0;
    if (spin_b && !course_spin(b, &shape_b, &spun_b)) return 0;
    toi_request request = *w->request;
    toi_result r = {.status = TOI_FREE, .lo = INFINITY, .hi = INFINITY};
    walk v; /* its sweep is large, and makes itself ready */
    v.a = &spun_a;
    v.b = &spun_b;
    v.request = &request;
    v.threshold = request.threshold;
    v.scratch = w->scratch;
    v.rough = true;
    v.out = &r;
    if (!sweep_init(&v.sweep, &spun_a, &spun_b, &request)) return 0;
    request.tolerance = max_of(request.tolerance, ROUGHLY * v.sweep.size);
    v.allowed = w->allowed / 4;
    walk_stretches(&v, 0);
    w->out->queries += r.queries;
    w->out->steps += r.steps;
    w->sweep.work += v.sweep.work;
    return min_of(r.lo, v.skipped);
}

/* ---- the whole shapes ---- */

static uint64_t whole_work(const walk *w, const shape *s, unsigned facts)
{
    bool deep = w->threshold < 0 && facts == NARROW_DISTANCE;
    uint64_t triangles = s->type == SHAPE_MESH ? s->mesh->triangle_count : 0;
    return WORK_WHOLE + (deep ? WORK_DEPTH_TRIANGLE : WORK_WHOLE_TRIANGLE) * triangles;
}

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
    w->sweep.work += whole_work(w, w->a->shape, facts) + whole_work(w, w->b->shape, facts);
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

/* Fills in the answer's fields that describe the time lo. */
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

static void report_contact(walk *w, double time)
{
    w->out->status = TOI_HIT;
    w->out->hi = time;
}

enum { PROOFS_MAX = 24, DEEPER_MAX = 64 };

/* Solids whose faces meet flat overlap without any two triangles that do: the whole shapes prove the contact. */
static void walk_prove_contact(walk *w)
{
    toi_result *out = w->out;
    double gap = max_of(out->gap_hi - w->threshold, 0) + w->request->tolerance, time = out->lo;
    double step = out->closing > 0 ? gap / out->closing : 0x1p-20 * w->request->span;
    for (int k = 0; k < PROOFS_MAX && time < w->request->span; k++, step *= 2) {
        time = min_of(time + step, w->request->span);
        narrow_result n;
        look_whole(w, time, NARROW_VERDICT, INFINITY, &n);
        if (n.hi <= w->threshold) report_contact(w, time);
        if (n.hi <= w->threshold || n.lo > w->threshold) return;
    }
}

/* m: the least gap of the whole that counts as apart at a time. */
static double walk_floor_at(const walk *w, double time)
{
    return w->threshold + 0.5 * w->request->wander * time * time * (1 + 4 * UNIT_ROUNDOFF);
}

/* m: how far beyond that the convex hulls are along a world direction, proven. */
static double spare_along(const walk *w, double time, vec3 direction)
{
    const course *c = &w->sweep.course;
    course_place at = course_at(c, time);
    return course_separation(c, &at, direction) - c->slack - walk_floor_at(w, time);
}

/* m: what is left of the gap at a time, when two points that approach each other at the course's speed use it up. The
 * gap along a direction does; so does what is left between two that are apart, and of those that do not turn any. */
static double spare_at(const walk *w, double time, const narrow_result *n)
{
    double all = n->lo - walk_floor_at(w, time), hulls = spare_along(w, time, n->axis);
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
        if (spare <= w->request->tolerance || !(time + step > time) || k == DEEPER_MAX || w->sweep.work > w->most)
            break;
        time += step;
    }
    describe(w, time, &n);
    out->hi = INFINITY;
    out->status = near_or_undecided(w, walk_floor_at(w, time), &n);
    if (wander > 0) return;
    if (n.hi <= w->threshold)
        report_contact(w, time);
    else
        walk_prove_contact(w);
}

/* What was kept is of the two parts that meet first; at that time others may be nearer. The whole is no farther apart
 * than any two of its parts, and apart before. */
static void report_nearest(walk *w)
{
    toi_result *out = w->out;
    narrow_result n;
    double gap_lo = out->gap_lo, blur = w->blur * w->sweep.course.speed;
    look_whole(w, out->lo, NARROW_DISTANCE, out->gap_hi + 4 * w->sweep.course.slack + blur, &n);
    describe(w, out->lo, &n);
    out->gap_lo = min_of(gap_lo, max_of(n.lo, w->threshold));
}

/* May the boxes around them? */
static bool touch_at_first(walk *w)
{
    toi_part a, b;
    vec3 hint = VEC_ZERO;
    toi_part_root(w->a->shape, &a);
    toi_part_root(w->b->shape, &b);
    sweep_begin(&w->sweep, 0, w->request->span);
    w->until = w->sweep.end;
    return walk_look(w, &a, &b, 0, &hint) == 0;
}

enum { HELD_ASKED = 1000 }; /* components of a mesh: of more it is not asked whether one is held */

/* Is a point of each component, or of a convex core, inside of the other, a solid? Where no surface meets another, that
 * shows whether one contains the other. True also if that is not asked. */
static bool may_be_held(const shape *solid, pose at_solid, const shape *other, pose at_other)
{
    pose relative = pose_relative(at_solid, at_other);
    uint32_t count = other->mesh ? other->mesh->component_count : 1;
    if (!solid->mesh || !solid->mesh->solid) return false;
    if (other->type == SHAPE_COMPOUND || count > HELD_ASKED) return true;
    for (uint32_t i = 0; i < count; i++) {
        vec3 own = other->mesh                 ? other->mesh->corners[3 * (size_t)other->mesh->components[i].triangle]
                   : other->type == SHAPE_HULL ? hull_vertex(other->hull, 0)
                                               : VEC_ZERO;
        if (mesh_inside(solid->mesh, pose_point(relative, own))) return true;
    }
    return false;
}

/* The effort of one query did not suffice to say whether they touch at the beginning. Triangles that do are found by
 * the walk; what it does not see is a shape that a solid holds. */
static bool is_for_the_walk(const walk *w, const narrow_result *n)
{
    pose at_a = pose_mul(motion_pose(&w->a->motion, 0), w->a->local);
    pose at_b = pose_mul(motion_pose(&w->b->motion, 0), w->b->local);
    const shape *a = w->a->shape, *b = w->b->shape;
    bool open = w->threshold >= 0 && n->lo <= w->threshold && near_or_undecided(w, w->threshold, n) == TOI_UNDECIDED;
    return open && (a->mesh || b->mesh) && !may_be_held(a, at_a, b, at_b) && !may_be_held(b, at_b, a, at_a);
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
    if (is_for_the_walk(w, &n)) return false;
    describe(w, 0, &n);
    w->out->status = near_or_undecided(w, w->threshold, &n);
    w->out->hi = INFINITY;
    if (n.hi <= w->threshold)
        report_contact(w, 0);
    else if (w->request->wander == 0 && n.hi <= w->threshold + w->request->tolerance)
        walk_prove_contact(w);
    return true;
}

/* The walk ended with parts left that may meet from `skipped` on. */
static void report_skipped(walk *w)
{
    narrow_result n;
    look_whole(w, w->skipped, NARROW_DISTANCE, INFINITY, &n);
    describe(w, w->skipped, &n);
    if (n.hi <= w->threshold && w->request->wander == 0) w->out->hi = w->skipped;
    w->out->status = w->out->hi == INFINITY ? TOI_UNDECIDED : TOI_HIT;
}

static void walk_find(walk *w)
{
    const toi_request *request = w->request;
    toi_result *out = w->out;
    if (touch_at_first(w) && begins_in_contact(w)) return;
    walk_stretches(w, walk_free_while_spun(w));
    double parts_touch = min_of(out->lo, w->skipped);
    if (w->threshold < 0) {
        if (parts_touch < INFINITY) deepen(w, parts_touch);
        return;
    }
    if (out->status == TOI_NEAR && out->hi == INFINITY && request->wander == 0) walk_prove_contact(w);
    if (w->skipped <= out->lo && w->skipped != INFINITY) {
        report_skipped(w);
        return;
    }
    if (out->hi != INFINITY) out->status = TOI_HIT;
    if (out->status != TOI_FREE) report_nearest(w);
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
    w.most = w.allowed = request->spent < TOI_WORK_MAX ? TOI_WORK_MAX - request->spent : 0;
    w.rough = request->wander > 0;
    w.out = out;
    if (sweep_init(&w.sweep, a, b, &of_parts)) {
        walk_find(&w);
        out->work = (uint32_t)min_of((double)w.sweep.work, UINT32_MAX);
        return;
    }
    out->status = TOI_UNDECIDED;
    out->lo = 0;
    out->gap_lo = -INFINITY, out->gap_hi = INFINITY;
}
