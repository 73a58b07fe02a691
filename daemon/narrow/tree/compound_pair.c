/* The nearest or deepest pair of parts, and what follows from it for the unions. Pure; any thread. */
#include "compound_pair.h"

#include "mesh_pair.h"
#include "narrow/contact/manifold.h"
#include "narrow/dispatch.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/finish.h"
#include "narrow/pair/unit_pair.h"

/* ---- compound manifold ---- */

/* Up to four contact points over all pairs of parts.
 *
 * The parts that may touch are clipped against each other along the one axis of the answer, so that no pair brings a
 * normal of its own; the best four of all points are kept (manifold.h). Parts that overlap from another side, as
 * the wall beside a floor, would show as points far deeper than the whole: those are left out. */

/* The witness of two parts counts while their own axis is this near to that of the answer (cosine). */
static const double SAME_SIDE = 0.9;

enum { INDEX_BITS = 30 }; /* of manifold.h */

typedef struct point_search {
    const narrow_result *answer;
    narrow_scratch *scratch;
    double threshold;
    effort *effort;
    manifold_choice choice;
} point_search;

/* Two parts in canonical order, and their contact in the frame of the first. */
typedef struct part_pair {
    shape first, second;
    pose second_in_first, frame; /* frame: of the first in A */
    bool turned;                 /* the first is B's */
} part_pair;

static part_pair pair_of(const compound_walk *w, uint32_t part_a, uint32_t part_b)
{
    bool composed;
    pose local_a, local_b, relative = compound_parts_pose(w, part_a, part_b, &composed);
    part_pair out = {.first = compound_part(&w->a, part_a, &local_a),
        .second = compound_part(&w->b, part_b, &local_b),
        .second_in_first = relative,
        .frame = local_a};
    if (order_shapes(&out.first, &out.second) <= 0) return out;
    shape swap = out.first;
    out.first = out.second;
    out.second = swap;
    quat back = quat_conj(relative.q);
    out.second_in_first = (pose){vec_neg(quat_rotate(back, relative.p)), back};
    out.frame = pose_mul(local_a, relative);
    out.turned = true;
    return out;
}

static vec3 compound_pair_into(const transform *t, vec3 point)
{
    return mat_tmul(t->r, vec_sub(point, t->t));
}

static bool is_curved(const shape *s)
{
    return s->type != SHAPE_BOX && s->type != SHAPE_HULL && s->type != SHAPE_HALFSPACE;
}

/* Where clipping polygons does not find the deepest point: the parts' own witnesses, in A's frame. */
static bool own_witness(
    const compound_walk *w, const point_search *q, uint32_t part_a, uint32_t part_b, narrow_result *r)
{
    const narrow_request request = {
        .facts = NARROW_DISTANCE, .range = max_of(q->threshold, 0), .tolerance = 1e-9 * w->size * w->unit};
    compound_parts_query(w, part_a, part_b, &request, q->scratch, r);
    return vec_dot(r->axis, q->answer->axis) >= SAME_SIDE;
}

static void clip_parts(
    const part_pair *pair, const point_search *q, const narrow_result *witness, const transform *frame, manifold *out)
{
    transform t = pose_transform(pair->second_in_first);
    const narrow_result *from = witness ? witness : q->answer;
    narrow_result here = {.axis = direction_again(mat_tmul(frame->r, q->answer->axis))};
    here.point_a = compound_pair_into(frame, pair->turned ? from->point_b : from->point_a);
    here.point_b = compound_pair_into(frame, pair->turned ? from->point_a : from->point_b);
    if (pair->turned) here.axis = vec_neg(here.axis);
    if (!witness) here.point_b = vec_madd(here.point_a, MANIFOLD_NO_WITNESS, here.axis);
    if (pair->second.type == SHAPE_MESH) {
        unit_pair p;
        unit_pair_init(&p, &pair->first, &pair->second, &pair->second_in_first);
        mesh_pair_prepare(&p, &pair->first);
        p.effort = q->effort;
        mesh_pair_manifold(&p, &pair->first, &pair->second, &pair->second_in_first, &here, q->threshold, out);
    } else {
        manifold_build(&pair->first, &pair->second, &t, here.axis, here.point_a, here.point_b, q->threshold, out);
    }
}

/* The child in as many of the high bits of the index as number the children, and its own index, which is of a hull at
 * most and fits below. */
static uint32_t code_in_compound(const compound_side *s, uint32_t part, uint32_t code)
{
    uint32_t bits = 0, count = compound_part_count(s);
    while (count > 1u << bits) bits++;
    uint32_t own = feature_index(code) & ((1u << (INDEX_BITS - bits)) - 1);
    return feature_code(feature_kind(code), bits ? part << (INDEX_BITS - bits) | own : own);
}

static bool compound_pair_clip(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context)
{
    point_search *q = context;
    part_pair pair = pair_of(w, part_a, part_b);
    effort_spend(w->effort, EFFORT_CLIP + compound_vertices(&pair.first, &pair.second) * EFFORT_PARTS_VERTICES);
    transform frame = pose_transform(pair.frame);
    manifold points;
    narrow_result own;
    bool curved = is_curved(&pair.first) || is_curved(&pair.second);
    bool witness = curved && own_witness(w, q, part_a, part_b, &own);
    double deepest = q->answer->lo - w->error * w->unit;
    clip_parts(&pair, q, witness ? &own : NULL, &frame, &points);
    for (uint32_t i = 0; i < points.count; i++) {
        manifold_point *p = &points.points[i];
        uint32_t first = feature_code_a(p->feature), second = feature_code_b(p->feature);
        if ((p->feature == feature_witness() && !witness) || p->distance > q->threshold || p->distance < deepest)
            continue;
        p->point = transform_point(&frame, p->point);
        p->feature = feature_id(code_in_compound(&w->a, part_a, pair.turned ? second : first),
            code_in_compound(&w->b, part_b, pair.turned ? first : second));
        manifold_choice_offer(&q->choice, p);
    }
    return true;
}

/* As manifold_build, over all pairs of parts, along the axis of the answer. */
static void compound_manifold(
    compound_walk *w, const narrow_result *answer, double threshold, narrow_scratch *scratch, manifold *out)
{
    point_search q = {.answer = answer, .scratch = scratch, .threshold = threshold, .effort = w->effort};
    double within = max_of(threshold * w->scale, 0) + 2 * w->error;
    manifold_choice_begin(&q.choice, answer->axis, MANIFOLD_SAME_POINT * w->size * w->unit, true);
    int64_t share = w->effort->left / MANIFOLD_POINTS_MAX, left = w->effort->left;
    bool cut = false;
    do { /* each walk sees as much as the others, where the effort does not suffice for all */
        w->effort->left = share;
        compound_walk_run(w, within, compound_pair_clip, &q);
        left -= share - w->effort->left;
        cut |= w->cut || w->effort->left < 0;
    } while (manifold_choice_next(&q.choice));
    w->effort->left = cut ? -1 : left;
    if (q.choice.chosen.count == 0) q.choice.chosen.points[q.choice.chosen.count++] = manifold_witness(answer);
    manifold_choice_write(&q.choice, out);
}

/* ==== depths ==== */

/* A translation that parts two unions.
 *
 * A translation by at least `depth` along the axis n of an overlapping pair of convex parts separates this pair: this
 * is a plane that bounds translations of B. The search tries the shortest translation beyond all known planes; the pair
 * that overlaps most there adds its own plane, and so on, until all pairs are proven apart. So a part that is wedged
 * between two others leaves along the axis of neither. The result need not be the shortest translation, because each
 * pair has other planes to choose from; it is the shortest if only one pair overlaps. If the bracket is wider than
 * asked and all parts are polytopes, rounded or not, the search of union_depth.h narrows it from both sides. */

enum { PLANES_MAX = 12, ROUNDS_MAX = 16, SWEEPS_MAX = 200 };

enum { GO_ON_ROUNDS = 6, SEARCH_WORK = 100000 };

/* Axes nearly orthogonal to the translation hardly bound its length. */
static const double LEAST_SLOPE = 0.05;

/* In errors of a separation: how much longer the translation is made, so that separation can still be proven there. */
static const double CLEARANCE_ERRORS = 4;

typedef struct plane {
    vec3 normal;
    double level; /* dot(normal, translation) >= level */
    uint32_t part_a, part_b;
} plane;

typedef struct planes {
    uint32_t count;
    plane at[PLANES_MAX];
} planes;

/* Where B was moved to, and which pair overlaps most there. */
typedef struct trial {
    const planes *planes;
    narrow_scratch *scratch;
    narrow_result worst; /* lo <= 0 if any pair may overlap */
    uint32_t part_a, part_b;
    bool clear;
} trial;

/* By the only plane, along whose normal B has gone just as far as it asks: parted by construction. */
static bool is_parted(const planes *p, uint32_t part_a, uint32_t part_b)
{
    return p->count == 1 && p->at[0].part_a == part_a && p->at[0].part_b == part_b;
}

static bool still_overlaps(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context)
{
    trial *t = context;
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = 0, .tolerance = 1e-9 * w->size * w->unit};
    narrow_result r;
    if (is_parted(t->planes, part_a, part_b)) return true;
    compound_parts_query(w, part_a, part_b, &request, t->scratch, &r);
    if (r.lo > 0 || r.lo >= t->worst.lo) return true;
    t->clear = false;
    t->worst = r;
    t->part_a = part_a;
    t->part_b = part_b;
    return true;
}

/* The shortest vector that satisfies all planes, by coordinate ascent on the dual (Hildreth, "A quadratic programming
 * procedure", 1957). What it leaves open in the last digits, the next round finds. */
static vec3 shortest(const planes *p)
{
    double weight[PLANES_MAX] = {0};
    vec3 sum = VEC_ZERO;
    for (int sweep = 0; sweep < SWEEPS_MAX; sweep++) {
        double changed = 0, largest = 0;
        for (uint32_t i = 0; i < p->count; i++) {
            double short_by = p->at[i].level - vec_dot(p->at[i].normal, sum);
            double next = max_of(weight[i] + short_by, 0), step = next - weight[i];
            weight[i] = next;
            sum = vec_madd(sum, step, p->at[i].normal);
            changed = max_of(changed, fabs(step));
            largest = max_of(largest, next);
        }
        if (changed <= 0x1p-50 * largest) break;
    }
    return sum;
}

/* Of one pair only the newest plane counts: it may have to leave by another side. */
static bool add_plane(planes *p, plane next)
{
    uint32_t place = 0;
    while (place < p->count && (p->at[place].part_a != next.part_a || p->at[place].part_b != next.part_b)) place++;
    if (place == PLANES_MAX) return false;
    p->at[place] = next;
    if (place == p->count) p->count++;
    return true;
}

/* How far B must go to be apart for certain, in units of the pair: a translation, or one of infinite length where none
 * was found. */
typedef struct compound_way {
    vec3 axis; /* unit */
    double length;
} compound_way;

/* `deepest`: what is known of the deepest pair of parts, of those numbers, in metres. */
static compound_way compound_way_out(
    compound_walk *w, const narrow_result *deepest, const uint32_t parts[2], narrow_scratch *scratch)
{
    const vec3 start = w->placed.t;
    const compound_way none = {deepest->axis, INFINITY};
    planes p = {1, {{deepest->axis, max_of(-deepest->lo, 0) * w->scale, parts[0], parts[1]}}};
    vec3 way = vec_scale(deepest->axis, p.at[0].level);
    trial t = {.clear = false};
    for (int round = 0; round < ROUNDS_MAX && !t.clear; round++) {
        if (vec_norm(way) > 4 * w->size) break; /* planes that contradict each other: there is no way beyond all */
        t = (trial){.planes = &p, .scratch = scratch, .worst = {.lo = INFINITY}, .clear = true};
        compound_walk_move(w, vec_add(start, way));
        compound_walk_run(w, 0, still_overlaps, &t);
        t.clear &= !w->cut;
        if (t.clear || w->cut) break;
        double more = (-t.worst.lo * w->scale) + CLEARANCE_ERRORS * w->error;
        plane next = {t.worst.axis, vec_dot(t.worst.axis, way) + more, t.part_a, t.part_b};
        if (!add_plane(&p, next)) break;
        way = shortest(&p);
    }
    compound_walk_move(w, start);
    if (!t.clear) return none;
    if (p.count == 1) return (compound_way){p.at[0].normal, p.at[0].level};
    return (compound_way){direction_of(way), vec_norm(way) + w->error};
}

/* ---- both sides ---- */

typedef struct way_search {
    compound_walk *w;
    narrow_scratch *scratch;
    vec3 start, direction;
    double rounding; /* the least of both sides' parts */
} way_search;

/* Where the search has come to: on from there, until all parts are proven to be apart. */
static double go_on_apart(void *context, vec3 way)
{
    way_search *q = context;
    compound_walk *w = q->w;
    const planes none = {.count = 0};
    double length = vec_norm(way) + q->rounding + CLEARANCE_ERRORS * w->error;
    if (!(vec_norm(way) > 0)) return INFINITY;
    vec3 direction = direction_of(way);
    for (int round = 0; round < GO_ON_ROUNDS && length < w->size; round++) {
        trial t = {.planes = &none, .scratch = q->scratch, .worst = {.lo = INFINITY}, .clear = true};
        compound_walk_move(w, vec_madd(q->start, length, direction));
        compound_walk_run(w, 0, still_overlaps, &t);
        if (t.clear) {
            q->direction = direction;
            return length - q->rounding;
        }
        double slope = max_of(vec_dot(t.worst.axis, direction), LEAST_SLOPE);
        length += (-t.worst.lo * w->scale + CLEARANCE_ERRORS * w->error) / slope;
    }
    return INFINITY;
}

static bool side_of_shape(
    union_side *side, const shape *s, const shape *scaled, double scale, const transform *place, double *rounding)
{
    *rounding = 0;
    if (s->type != SHAPE_COMPOUND) return s->type != SHAPE_MESH && union_side_init(side, scaled, scale, place);
    return union_side_of_children(side, s->compound, scale, place, rounding);
}

/* Narrows both bounds of an overlap by a search over the differences of the parts (union_depth.h), if these are
 * polytopes; `asked`: m. */
static void compound_search_depth(const unit_pair *p, compound_walk *w, const shape *a, const shape *b, double asked,
    narrow_scratch *scratch, union_scratch *parts, narrow_result *out)
{
    double of_a, of_b, radius = p->radius;
    uint32_t work = effort_grant(w->effort, SEARCH_WORK, EFFORT_UNION);
    if (a->deviation + b->deviation > 0 || work == 0) return;
    if (!side_of_shape(&parts->a, a, &p->a, p->scale, NULL, &of_a)) return;
    if (!side_of_shape(&parts->b, b, &p->b, p->scale, &p->b_in_a, &of_b)) return;
    way_search q = {.w = w, .scratch = scratch, .start = w->placed.t, .rounding = radius + of_a + of_b};
    const narrow_goal goal = {.tolerance = asked * p->scale,
        .finest = asked * p->scale,
        .far = INFINITY,
        .near = -INFINITY,
        .above = -INFINITY,
        .below = INFINITY};
    double known = -out->lo * p->scale - q.rounding;
    union_bounds bounds = union_depth(parts, known, &goal, 4 * p->error, work, go_on_apart, &q);
    effort_spend(w->effort, bounds.work * (int64_t)EFFORT_UNION);
    compound_walk_move(w, q.start);
    if (bounds.length < known) {
        out->lo = -(bounds.length + q.rounding + w->error) * p->unit;
        out->axis = q.direction;
    }
    /* the ball of `least` is in the union of the differences of the cores: so is, rounded, one larger by that */
    if (bounds.least > 0) out->hi = min_of(out->hi, -(bounds.least + q.rounding - w->error) * p->unit);
}

/* ==== whole answers ==== */

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

static bool compound_pair_nearer(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context)
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

static void compound_pair_lower_bound(const unit_pair *p, compound_walk *w, const nearest_search *q, double asked,
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

/* Beyond the faces of a mesh its hull represents it; a compound has a hull of its own. */
static unit_pair hulls_of(const unit_pair *p)
{
    unit_pair hulls = *p;
    if (hulls.a.type == SHAPE_MESH) hulls.a.type = SHAPE_HULL;
    return hulls;
}

static void compound_pair_settle(
    const unit_pair *p, const nearest_search *q, const narrow_request *r, narrow_result *out)
{
    bool equal = out->lo == out->hi && (r->tolerance == 0 || isinf(out->hi));
    bool narrow = equal || out->hi - out->lo <= asked_width(p, r);
    bool decided = !(r->facts & NARROW_DISTANCE) && decides(r) && (out->lo > r->threshold || out->hi <= r->threshold);
    bool manifold = r->facts & NARROW_MANIFOLD;
    bool enough = narrow || out->lo > q->far || (decided && !manifold);
    out->status = enough ? NARROW_CERTAIN : NARROW_WIDE;
}

void compound_pair_query(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_request *request, narrow_ask *ask, narrow_scratch *scratch, epa_scratch *epa, union_scratch *parts,
    narrow_result *out)
{
    compound_walk w;
    compound_walk_init(&w, p, a, b, *b_in_a, ask);
    if (compound_part_count(&w.a) == 1 && compound_part_count(&w.b) == 1) {
        compound_parts_query(&w, 0, 0, request, scratch, out);
        return;
    }
    nearest_search q = search_for(request, scratch);
    w.effort->counts = true; /* nothing is remembered */
    int64_t kept = effort_keep_back(w.effort, EFFORT_OF_WAYS_OUT);
    compound_walk_run(&w, INFINITY, compound_pair_nearer, &q);
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
        compound_pair_lower_bound(&hulls, &w, &q, asked_width(p, request), scratch, epa, out);
    if (!ended && out->hi < 0 && out->hi - out->lo > asked_width(p, request))
        compound_search_depth(p, &w, a, b, asked_width(p, request), scratch, parts, out);
    out->lo = min_of(out->lo, out->hi);
    out->iterations = q.iterations + w.visits;
    out->peer_failures = q.peer_failures;
    compound_pair_settle(p, &q, request, out);
    if (!(request->facts & NARROW_MANIFOLD) || !(out->lo <= request->threshold)) return;
    w.effort->left = EFFORT_OF_POINTS;
    compound_manifold(&w, out, request->threshold, scratch, &out->manifold);
    if (w.effort->left < 0) out->status = NARROW_WIDE;
}
