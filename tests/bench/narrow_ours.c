/* narrow_ours: our narrow phase as the daemon calls it: shapes in canonical order, the pose of B in A's frame from the
 * two world poses, as each tick computes it, and narrow_query with the cache of the pair (empty where the pair is new);
 * or narrow_query_world, as shape casts and searches for the nearest do. All of that is timed, but for the order, which
 * a pair has for good. `entry` names the functions; tests/bench/check_shipped.py holds that the world calls them. */
#include "narrow_scene.h"

#include "geom/bounds.h"
#include "narrow/narrow.h"

#include <stdlib.h>
#include <string.h>

typedef struct ours_item {
    shape a, b;
    pose at_a, at_b;
    double reach_b;
    bool begins;
} ours_item;

typedef struct ours {
    ours_item *items;
    double *sizes; /* of each item the greater reach: what a tolerance of a sweep is relative to */
    narrow_request request;
    narrow_scratch *scratch;
    narrow_cache cache;
    double relative; /* tolerance of a sweep, in sizes; 0 = as narrow as arithmetic gives */
    bool keeps;      /* the pair's cache, from frame to frame */
    bool from_world; /* asked about the world poses to the last bit, as the daemon's queries are; exact always is */
    narrow_shell shell;
} ours;

static void *create_asking(const narrow_item *items, size_t count, double tolerance)
{
    ours *o = calloc(1, sizeof *o);
    ours_item *own = calloc(count, sizeof *own);
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    double *sizes = calloc(count, sizeof *sizes);
    if (!o || !own || !scratch || !sizes) abort();
    o->items = own;
    o->sizes = sizes;
    o->scratch = scratch;
    o->request = (narrow_request){.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    for (size_t i = 0; i < count; i++) {
        shape a = narrow_scene_shape(items[i].a), b = narrow_scene_shape(items[i].b);
        bool ordered = narrow_ordered(&a, 0, &b, 1);
        pose at_a = narrow_scene_pose(&items[i].at_a), at_b = narrow_scene_pose(&items[i].at_b);
        own[i].a = ordered ? a : b;
        own[i].b = ordered ? b : a;
        own[i].at_a = ordered ? at_a : at_b;
        own[i].at_b = ordered ? at_b : at_a;
        own[i].reach_b = shape_reach(&own[i].b);
        own[i].begins = items[i].begins;
        sizes[i] = fmax(shape_reach(&a), shape_reach(&b));
    }
    return o;
}

static void *create(const narrow_item *items, size_t count, const narrow_row *row)
{
    return create_asking(items, count, row->tolerance);
}

static void *create_finest(const narrow_item *items, size_t count, const narrow_row *row)
{
    (void)row;
    return create_asking(items, count, 0);
}

static void destroy(void *self)
{
    ours *o = self;
    free(o->items);
    free(o->sizes);
    free(o->scratch);
    free(o);
}

static void tell(const narrow_result *r, narrow_answer *out)
{
    *out = (narrow_answer){.overlap = r->lo <= 0,
        .measured = true,
        .bounded = true,
        .distance = 0.5 * (r->lo + r->hi),
        .lo = r->lo,
        .hi = r->hi};
}

/* As a tick asks: a pair that is new has an empty cache. */
static void ask(ours *o, const ours_item *it, bool keeps, narrow_result *r)
{
    pose b_in_a = pose_relative(it->at_a, it->at_b);
    if (!keeps || it->begins) o->cache = (narrow_cache){.shell = keeps ? &o->shell : NULL};
    narrow_query(&it->a, &it->b, &b_in_a, &o->request, &o->cache, o->scratch, r);
}

static void query(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        narrow_result r;
        ask(o, &o->items[i], false, &r);
        tell(&r, out);
    }
}

/* Judged to the last bit, an answer must be about the world poses, not about the rounded relative one. */
static void query_world(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        narrow_result r;
        narrow_query_world(&it->a, it->at_a, &it->b, it->at_b, &o->request, o->scratch, &r);
        tell(&r, out);
    }
}

/* What the world tries before it asks in full: how far the pair moved since the last proof, and the last axis. */
static bool still_apart(narrow_cache *c, const ours_item *it, const pose *b_in_a, double *lower)
{
    if (!(c->lower > 0)) return false;
    *lower = c->lower - narrow_motion_bound(&c->b_in_a, b_in_a, it->reach_b);
    if (*lower > 0) return true;
    *lower = narrow_separation(&it->a, &it->b, b_in_a, c->axis, &c->hint_a, &c->hint_b);
    if (!(*lower > 0)) return false;
    c->b_in_a = *b_in_a;
    c->lower = *lower;
    return true;
}

static void query_cached(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        pose b_in_a = pose_relative(it->at_a, it->at_b);
        double lower;
        if (it->begins) o->cache = (narrow_cache){0};
        if (still_apart(&o->cache, it, &b_in_a, &lower)) {
            *out = (narrow_answer){.bounded = true, .lo = lower, .hi = INFINITY};
            continue;
        }
        narrow_result r;
        narrow_query(&it->a, &it->b, &b_in_a, &o->request, &o->cache, o->scratch, &r);
        tell(&r, out);
    }
}

/* ---- sweeps over tolerances ---- */

static void *create_stage(const narrow_item *items, size_t count, const narrow_row *row)
{
    ours *o = create_asking(items, count, 0);
    o->relative = row->own;
    o->keeps = row->coherent;
    o->request.facts |= NARROW_VERDICT;
    return o;
}

static void *create_world_stage(const narrow_item *items, size_t count, const narrow_row *row)
{
    ours *o = create_stage(items, count, row);
    o->from_world = true;
    return o;
}

static void *create_verdict(const narrow_item *items, size_t count, const narrow_row *row)
{
    ours *o = create_asking(items, count, INFINITY);
    (void)row;
    o->request.facts = NARROW_VERDICT;
    return o;
}

/* The full query each time, helped by what the frame before left behind: the same answers as without. */
static void query_kept(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        narrow_result r;
        ask(o, it, true, &r);
        tell(&r, out);
    }
}

/* By a relative tolerance, with the pair's cache where one is kept. */
static void query_near(ours *o, size_t first, size_t count, narrow_answer *out)
{
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        narrow_result r;
        o->request.tolerance = o->relative * o->sizes[i];
        ask(o, it, o->keeps, &r);
        tell(&r, out);
    }
}

static void query_stage(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    if (!o->from_world) {
        query_near(o, first, count, out);
        return;
    }
    for (size_t i = first; i < first + count; i++) {
        o->request.tolerance = o->relative * o->sizes[i];
        query_world(self, i, 1, out++);
    }
}

static void query_verdict(void *self, size_t first, size_t count, narrow_answer *out)
{
    query(self, first, count, out);
    for (size_t i = 0; i < count; i++) out[i].measured = isfinite(out[i].distance);
}

/* As the world, of a pair that nothing has been told of. */
static bool apart_cheaply(ours *o, const ours_item *it, const pose *b_in_a)
{
    narrow_cache *c = &o->cache;
    if (it->begins) *c = (narrow_cache){0};
    if (c->lower > 0 && c->lower - narrow_motion_bound(&c->b_in_a, b_in_a, it->reach_b) > 0) return true;
    return narrow_apart(&it->a, &it->b, b_in_a, 0, c);
}

/* The world's cheap proofs, then the query. */
static void query_cascade(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        pose b_in_a = pose_relative(it->at_a, it->at_b);
        if (apart_cheaply(o, it, &b_in_a)) {
            *out = (narrow_answer){.bounded = true, .lo = 0, .hi = INFINITY};
            continue;
        }
        narrow_result r;
        narrow_query(&it->a, &it->b, &b_in_a, &o->request, &o->cache, o->scratch, &r);
        tell(&r, out);
        out->measured = isfinite(out->distance);
    }
}

static double gap_of(double lo_a, double hi_a, double lo_b, double hi_b)
{
    return fmax(fmax(lo_b - hi_a, lo_a - hi_b), 0);
}

/* What the broad phase knows: boxes that are apart prove that their shapes are. */
static void query_boxes(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        aabb a = shape_bounds(&it->a, it->at_a), b = shape_bounds(&it->b, it->at_b);
        vec3 gap = {gap_of(a.lo.x, a.hi.x, b.lo.x, b.hi.x), gap_of(a.lo.y, a.hi.y, b.lo.y, b.hi.y),
            gap_of(a.lo.z, a.hi.z, b.lo.z, b.hi.z)};
        bool overlap = aabb_overlap(a, b);
        double lo = overlap ? -INFINITY : (1 - 0x1p-50) * vec_norm(gap);
        *out = (narrow_answer){.overlap = overlap, .bounded = true, .lo = lo, .hi = INFINITY};
    }
}

/* As the world's bounds (daemon/world/bounds.c): along the guessed axis, and along the box axis if that may be better.
 */
static void raise_bounds(const ours_item *it, const pose *b_in_a, vec3 axis, narrow_result *best)
{
    narrow_result r;
    if (vec_norm2(axis) == 0) return;
    narrow_bounds(&it->a, &it->b, b_in_a, axis, &r);
    best->lo = fmax(best->lo, r.lo);
    best->hi = fmin(best->hi, r.hi);
}

static double apart_by_boxes(const ours_item *it, vec3 *axis)
{
    aabb a = shape_bounds(&it->a, it->at_a), b = shape_bounds(&it->b, it->at_b);
    const double up[3] = {b.lo.x - a.hi.x, b.lo.y - a.hi.y, b.lo.z - a.hi.z};
    const double down[3] = {a.lo.x - b.hi.x, a.lo.y - b.hi.y, a.lo.z - b.hi.z};
    double most = -INFINITY, n[3] = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        double apart = fmax(up[i], down[i]);
        if (!(apart > most)) continue;
        most = apart;
        n[0] = n[1] = n[2] = 0;
        n[i] = down[i] > up[i] ? -1 : 1;
    }
    *axis = quat_rotate(quat_conj(it->at_a.q), vec(n[0], n[1], n[2]));
    return most;
}

static void query_bounds(void *self, size_t first, size_t count, narrow_answer *out)
{
    const ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        pose b_in_a = pose_relative(it->at_a, it->at_b);
        narrow_result r = {.lo = -INFINITY, .hi = INFINITY};
        vec3 by_boxes;
        double boxes = apart_by_boxes(it, &by_boxes);
        raise_bounds(it, &b_in_a, narrow_guess_axis(&it->a, &it->b, &b_in_a), &r);
        if (boxes > r.lo) raise_bounds(it, &b_in_a, vec_unit(by_boxes), &r);
        r.lo = fmax(r.lo, boxes);
        tell(&r, out);
    }
}

static bool takes_all(const narrow_row *row)
{
    (void)row;
    return true;
}

/* A cache proves separation, never contact. */
static bool takes_coherent_gaps(const narrow_row *row)
{
    return row->coherent && row->regime == REGIME_SEPARATED;
}

static bool takes_coherent(const narrow_row *row)
{
    return row->coherent;
}

const narrow_peer narrow_ours = {
    "collided", "tolerance 1e-9 m; of curved pairs 1e-6 m", true, takes_all, create, query, destroy, "narrow_query"};
const narrow_peer narrow_ours_finest = {"collided_finest", "tolerance 0, from world poses", true, takes_all,
    create_finest, query_world, destroy, "narrow_query_world"};
const narrow_peer narrow_ours_cached = {"collided_cached",
    "motion bound, cached axis, then the full query: proves the "
    "gap, measures it only where that fails",
    true, takes_coherent_gaps, create, query_cached, destroy, "narrow_motion_bound, narrow_separation, narrow_query"};

const narrow_peer narrow_dial = {"collided",
    "verdict and distance, interval no wider than the tolerance times the size", true, takes_all, create_stage,
    query_stage, destroy, "narrow_query"};
const narrow_peer narrow_dial_world = {"collided",
    "verdict and distance from world poses, as shape casts ask; exact: as narrow as arithmetic gives", true, takes_all,
    create_world_stage, query_stage, destroy, "narrow_query_world"};
const narrow_peer narrow_dial_verdict = {"collided",
    "the verdict alone, exact; the distance is the middle of the interval that it left", true, takes_all,
    create_verdict, query_verdict, destroy, "narrow_query"};
const narrow_peer narrow_dial_cascade = {"collided",
    "the verdict alone, as the world finds it: motion bound, last axis, a guess, narrow phase", true, takes_all,
    create_verdict, query_cascade, destroy, "narrow_motion_bound, narrow_apart, narrow_query"};
const narrow_peer narrow_dial_boxes = {"collided", "the two boxes alone: apart, or perhaps not", true, takes_all,
    create_stage, query_boxes, destroy, "shape_bounds"};
const narrow_peer narrow_dial_bounds = {"collided",
    "an interval without a search, as the world tells it who asks for no more: one axis or two; a verdict where that "
    "decides",
    true, takes_all, create_stage, query_bounds, destroy, "narrow_guess_axis, narrow_bounds"};
const narrow_peer narrow_ours_again = {"collided_again",
    "the full query, with the cache of the frame before: the same bits", true, takes_coherent, create, query_kept,
    destroy, "narrow_query"};
