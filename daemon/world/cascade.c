/* cascade: decides the active pairs, cheapest proof first, in parallel. Each pair reads the world, and writes its own
 * cache and its own outcome only; so the result does not depend on who computes it.
 *
 * The cheap stages may only say "beyond all that anybody asked, proven, and by more than the width of any answer": then
 * a full query would say so too, and no event depends on which one it was. A pair of which somebody has been told
 * something is always asked in full, and from nothing: the cache never enters an answer.
 *
 * Where bounds are all that is asked (bounds.c), bounds are all that is found. With a budget every pair that the cheap
 * stages leave open gets bounds that hold first, and is refined then in the order of need, as far as units of work are
 * granted (work.c). */
#include "cascade.h"
#include "soft_state.h"
#include "state.h"
#include "subscription.h"

#include "base/array.h"

#include <assert.h>
#include <stdlib.h>

/* No answer is wider than this share of the pair's size (narrow.h), unless the effort of its query ended: the cheap
 * proofs keep that distance. */
static const double WIDEST_ANSWER = 1e-6;

enum { PAIRS_A_CHUNK = 32 };

/* A verdict asked for beside something else: to this share of the pair's size. */
static const double TOLERANCE_OF_VERDICTS = 1e-6;

/* Bounds asked for beside something else. */
static const double TOLERANCE_OF_BOXES = 0.5;

enum { NOW = WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD }; /* facts about how a pair stands */

static double tolerance_of(const subscription *i, double size)
{
    if (i->accuracy == WORLD_BY_TOLERANCE) return subscription_tolerance(i, size);
    return (i->accuracy == WORLD_BY_BOXES ? TOLERANCE_OF_BOXES : TOLERANCE_OF_VERDICTS) * size;
}

/* Two that ask with hysteresis may stand at either end of it. */
static void add_demand(demand *d, const subscription *i, const pair_terms *terms, double size, bool reported)
{
    narrow_request *r = &d->request;
    double wider = reported ? i->hysteresis : 0;
    double threshold = i->threshold + terms->padding + wider, range = i->range + terms->margin + wider;
    bool touch = i->facts & (WORLD_TOUCH | WORLD_MANIFOLD);
    d->hysteresis |= touch && i->hysteresis > 0;
    bool other = touch && d->touch && (threshold != r->threshold || d->hysteresis);
    d->touch |= touch;
    bool asks_depth =
        i->facts & (WORLD_DISTANCE | WORLD_MANIFOLD) || (i->accuracy == WORLD_BY_TOLERANCE && i->tolerance > 0);
    d->coarse &= i->accuracy == WORLD_BY_BOXES;
    d->verdict_only &= i->accuracy == WORLD_BY_VERDICT && !other;
    r->tolerance = fmin(r->tolerance, tolerance_of(i, size));
    r->brief &= !asks_depth;
    if (i->facts & WORLD_DISTANCE) {
        r->facts |= NARROW_DISTANCE;
        r->range = fmax(r->range, range);
        d->limit = fmax(d->limit, range);
    }
    if (touch) {
        r->facts |= NARROW_VERDICT;
        r->threshold = fmax(r->threshold, threshold);
        d->limit = fmax(d->limit, threshold);
    }
    if (i->facts & WORLD_MANIFOLD) r->facts |= NARROW_MANIFOLD;
}

demand cascade_demand(const world *w, const pair *p)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    bool reported = pair_is_reported(p);
    pair_terms terms = pair_kept_terms(p);
    double size = pair_size(a, b);
    demand d = {.request = {.tolerance = INFINITY,
                    .range = 0,
                    .threshold = -INFINITY,
                    .engine = w->options.engine,
                    .brief = true},
        .limit = -INFINITY,
        .reported = reported,
        .coarse = true,
        .verdict_only = true};
    match_list wanted = subscription_list(w, p);
    for (uint32_t k = 0; k < wanted.count; k++) {
        const subscription *i = &w->subscriptions.at[wanted.at[k]];
        if (i->facts & NOW) add_demand(&d, i, &terms, size, reported);
    }
    if (!isfinite(d.request.threshold)) d.request.threshold = 0;
    d.request.range = fmax(d.request.range, d.request.threshold);
    return d;
}

/* Does the cascade build on what earlier ticks found? With a budget always: what was left undone is part of the state.
 */
static bool remembers(const world *w)
{
    return w->options.caches || w->grant;
}

/* B in A's frame, of an active pair: where its shapes have been settled is where their bodies are. */
static inline pose relative_of_active(const world *w, const pair *p, const collider *a, const collider *b)
{
    if (!p->at_origins) return collider_relative(w, a, b);
    assert(pose_same(a->world, w->bodies.at[a->body].pose) && pose_same(b->world, w->bodies.at[b->body].pose));
    pose relative = pose_relative(a->world, b->world);
    relative.q = quat_unit(relative.q);
    return relative;
}

static inline double error_of(const world *w, const pair *p, const collider *a, const collider *b)
{
    return p->at_origins ? 0 : collider_relative_error(w, a, b);
}

/* Stages 2 and 3: settled without looking at the shapes, or along the cached axis. Where there is none, or the pair has
 * turned away from it, a guess and what its support points lead to are tried before the narrow phase is asked. */
static bool settle_cheaply(const world *w, pair *p, const pose *b_in_a, double limit, outcome *out)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    narrow_cache *c = &p->cache;
    out->stage = STAGE_MOTION_BOUND;
    out->cost = WORK_A_MOTION_BOUND;
    if (!vec_equal(c->axis, VEC_ZERO) && c->lower - narrow_motion_bound(&c->b_in_a, b_in_a, b->reach) > limit)
        return true;
    if (w->grant) return false; /* what looks at shapes is granted: bounds_find looks along the same axes */
    out->stage = STAGE_CACHED_AXIS;
    out->cost = WORK_AN_AXIS;
    return narrow_apart(&a->shape, &b->shape, b_in_a, limit, c);
}

static void settle(outcome *out, world_stage stage, uint32_t cost)
{
    *out = (outcome){.stage = (uint8_t)stage, .settled = true, .cost = cost, .result = WORLD_NONE};
}

/* As far as the cheap stages have to prove a pair to be apart, for what is asked; the rounding of its relative pose
 * comes on top. */
static double far_enough(const collider *a, const collider *b, const demand *d)
{
    return d->limit + (d->request.tolerance + WIDEST_ANSWER * pair_size(a, b));
}

/* The same for a pair of which nothing has been reported: kept until a subscription or a rule of its bodies changes.
 */
static double kept_far_enough(const world *w, pair *p)
{
    if (p->asked_epoch == w->epoch) return p->beyond;
    demand d = cascade_demand(w, p);
    p->asked_epoch = w->epoch;
    p->beyond = far_enough(&w->colliders.at[p->a], &w->colliders.at[p->b], &d);
    return p->beyond;
}

/* Without a budget, and where nobody asks for bounds. Whether anything is asked of a pair that somebody was told of,
 * what is kept of it says too: hysteresis changes only how far. */
static void look_for_proof(const world *w, pair *p, outcome *out)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    bool reported = pair_is_reported(p), is_kept = !reported || p->asked_epoch == w->epoch;
    double beyond = is_kept ? kept_far_enough(w, p) : cascade_demand(w, p).limit;
    if (!(beyond > -INFINITY)) {
        settle(out, STAGE_UNASKED, 0);
    } else if (!reported && remembers(w)) {
        pose b_in_a = relative_of_active(w, p, a, b);
        out->settled = settle_cheaply(w, p, &b_in_a, beyond + 2 * error_of(w, p, a, b), out);
    }
}

/* Where bounds are all that is asked, those that stand are enough; otherwise they say where a budget begins. */
static void look_at_bounds(const world *w, pair *p, outcome *out)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    out->stands = bounds_stand(w, p);
    const standing *kept = &pair_more_of(w, p)->standing;
    if (out->stands && kept->enough) { /* and nobody asks for more since */
        settle(out, STAGE_STANDING, WORK_A_MOTION_BOUND);
        return;
    }
    demand d = cascade_demand(w, p);
    if (!(d.limit > -INFINITY)) {
        settle(out, STAGE_UNASKED, 0);
        return;
    }
    out->coarse = d.coarse;
    if (!d.coarse && !out->stands && remembers(w) && !pair_is_reported(p)) {
        pose b_in_a = relative_of_active(w, p, a, b);
        double beyond = far_enough(a, b, &d) + 2 * error_of(w, p, a, b);
        out->settled = settle_cheaply(w, p, &b_in_a, beyond, out);
    }
    out->floor = out->stands && kept->floor;
    if (out->stands) out->work = work_of(a, b, &d, kept->lo);
    if (out->stands) out->stage = STAGE_STANDING, out->cost = WORK_A_MOTION_BOUND;
}

static inline void forget_standing(const world *w, pair *p)
{
    if (p->has_more) pair_more_make(w, p)->standing.epoch = 0;
}

/* Mostly no body is stale, and those of the pair need not be looked up. */
static inline bool is_stale(const world *w, const pair *p)
{
    const body *bodies = w->bodies.at;
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    assert(w->figures.stale_bodies || !(bodies[a->body].stale || bodies[b->body].stale));
    if (!w->figures.stale_bodies) return false;
    return bodies[a->body].stale || bodies[b->body].stale;
}

/* What lies beyond the caches in a large world is asked for while other pairs are worked on: a pair, then its two
 * colliders and what was reported of it, then where their bodies are. */
enum { A_LINE = 64, CHEAP_LINES = 2, ALL_LINES = 3 };

static inline void fetch_pair(const world *w, uint32_t id, int lines)
{
    const char *p = (const char *)&w->pairs.at[id];
    for (int k = 0; k < lines; k++) __builtin_prefetch(p + k * A_LINE, 1);
}

static inline void fetch_collider(const collider *s, int lines)
{
    for (int k = 0; k < lines; k++) __builtin_prefetch((const char *)s + k * A_LINE);
}

static inline void fetch_colliders(const world *w, uint32_t id, int lines)
{
    const pair *p = &w->pairs.at[id];
    fetch_collider(&w->colliders.at[p->a], lines);
    fetch_collider(&w->colliders.at[p->b], lines);
}

static inline void fetch_bodies(const world *w, uint32_t id)
{
    const pair *p = &w->pairs.at[id];
    if (p->at_origins) return;
    __builtin_prefetch(&w->bodies.at[w->colliders.at[p->a].body].pose);
    __builtin_prefetch(&w->bodies.at[w->colliders.at[p->b].body].pose);
}

static inline void fetch_active_ahead(const world *w, size_t k)
{
    enum { PAIRS_AHEAD = 24, COLLIDERS_AHEAD = 12, BODIES_AHEAD = 6 };
    if (k + PAIRS_AHEAD >= w->active_pairs.count) return;
    fetch_pair(w, w->active_pairs.at[k + PAIRS_AHEAD], CHEAP_LINES);
    fetch_colliders(w, w->active_pairs.at[k + COLLIDERS_AHEAD], CHEAP_LINES);
    fetch_bodies(w, w->active_pairs.at[k + BODIES_AHEAD]);
}

/* Those that are asked in full, which takes longer. */
static inline void fetch_open_ahead(const world *w, size_t n)
{
    enum { PAIRS_AHEAD = 12, COLLIDERS_AHEAD = 6, BODIES_AHEAD = 3 };
    if (n + PAIRS_AHEAD >= w->open.count) return;
    fetch_pair(w, w->active_pairs.at[w->open.at[n + PAIRS_AHEAD]], ALL_LINES);
    fetch_colliders(w, w->active_pairs.at[w->open.at[n + COLLIDERS_AHEAD]], ALL_LINES);
    fetch_bodies(w, w->active_pairs.at[w->open.at[n + BODIES_AHEAD]]);
}

static void decide_cheaply(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    world *w = context;
    bool bounds = w->bounds_asked || w->grant;
    for (size_t k = begin; k < end; k++) {
        fetch_active_ahead(w, k);
        pair *p = &w->pairs.at[w->active_pairs.at[k]];
        bool stale = is_stale(w, p);
        w->outcomes.at[k] = (outcome){.stage = STAGE_UNKNOWN, .settled = stale, .result = WORLD_NONE};
        if (stale)
            forget_standing(w, p);
        else if (pair_is_soft(w, p))
            w->outcomes.at[k] =
                (outcome){.stage = STAGE_CLOSED_FORM, .settled = !soft_is_decided(w, p), .result = WORLD_NONE};
        else
            (bounds ? look_at_bounds : look_for_proof)(w, p, &w->outcomes.at[k]);
    }
}

static const uint8_t STAGE_OF_METHOD[NARROW_METHOD_COUNT] = {
    [NARROW_BY_CLOSED_FORM] = STAGE_CLOSED_FORM,
    [NARROW_BY_GJK] = STAGE_GJK,
    [NARROW_BY_EPA] = STAGE_EPA,
    [NARROW_BY_SAT] = STAGE_SAT,
    [NARROW_BY_CCD] = STAGE_CCD,
    [NARROW_BY_MPR] = STAGE_MPR,
};

/* The relative pose is rounded. Answers in doubles allow for it, but for the bodies' arms; refined ones are as narrow
 * as the pose is exact. */
void cascade_allow_for_pose(
    const world *w, const collider *a, const collider *b, const pose *b_in_a, double tolerance, narrow_result *r)
{
    double moved = collider_relative_error(w, a, b);
    bool was_narrow = r->hi - r->lo <= tolerance;
    if (r->refined) moved += 0x1p-49 * (pair_size(a, b) + vec_norm(b_in_a->p));
    r->lo -= moved;
    r->hi += moved;
    if (!r->refined && was_narrow && !(r->hi - r->lo <= tolerance)) r->status = NARROW_WIDE;
}

/* What the arms will add to the answer is left out of what is asked of it, where that leaves the better part. */
static double tolerance_within(double tolerance, double moved)
{
    return 4 * moved < tolerance ? tolerance - 2 * moved : tolerance;
}

/* A pair of which nothing has been reported, and whose distance nobody asks for, needs only the verdict as long as it
 * is apart. Whatever is reported has an interval as narrow as was asked; the verdict is decided alike in both. The
 * cache says where to begin. */
static uint32_t ask_at(const world *w, const pair *p, const pose *b_in_a, const demand *d, narrow_cache *cache,
    void *scratch, narrow_result *r)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    narrow_request request = d->request;
    bool reported = d->reported;
    uint32_t asked = 0;
    request.tolerance = tolerance_within(request.tolerance, error_of(w, p, a, b));
    if (d->verdict_only || (!reported && !(request.facts & NARROW_DISTANCE))) {
        request.facts = NARROW_VERDICT;
        narrow_query(&a->shape, &b->shape, b_in_a, &request, cache, scratch, r);
        cascade_allow_for_pose(w, a, b, b_in_a, d->request.tolerance, r);
        if (d->verdict_only || r->lo > request.threshold) return 1;
        request.facts = d->request.facts;
        reported = true;
        asked = 1;
    }
    request.facts |= NARROW_DISTANCE;
    if (reported) request.range = INFINITY;
    narrow_query(&a->shape, &b->shape, b_in_a, &request, cache, scratch, r);
    cascade_allow_for_pose(w, a, b, b_in_a, d->request.tolerance, r);
    return asked + 1;
}

uint32_t cascade_ask(
    const world *w, const pair *p, const demand *d, narrow_cache *cache, void *scratch, narrow_result *r)
{
    pose b_in_a = collider_relative(w, &w->colliders.at[p->a], &w->colliders.at[p->b]);
    return ask_at(w, p, &b_in_a, d, cache, scratch, r);
}

/* The points are for bounds that remember. */
static void keep(const world *w, pair *p, const pose *b_in_a, const narrow_result *r)
{
    p->cache.axis = r->axis;
    p->cache.b_in_a = *b_in_a;
    p->cache.lower = r->lo;
    forget_standing(w, p);
    p->waited = 0;
    if (!w->grant) return;
    pair_more *more = pair_more_make(w, p);
    more->near_a = r->point_a;
    more->near_b = pose_point(pose_relative(*b_in_a, POSE_IDENTITY), r->point_b);
    more->refined = true;
}

/* Hulls that overlap, or a hull and a box. */
static bool wants_shell(const pair *p, shape_type a, shape_type b, const narrow_result *r)
{
    bool hulls = (a == SHAPE_HULL || a == SHAPE_BOX) && (b == SHAPE_HULL || b == SHAPE_BOX) && a + b != 2 * SHAPE_BOX;
    return hulls && r->hi < 0 && !p->cache.shell;
}

static void refine(world *w, uint32_t k, narrow_result *r, void *scratch)
{
    outcome *out = &w->outcomes.at[k];
    pair *p = &w->pairs.at[w->active_pairs.at[k]];
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    if (pair_is_soft(w, p)) {
        soft_fill(w, p, r);
        return;
    }
    demand d = cascade_demand(w, p);
    pose b_in_a = relative_of_active(w, p, a, b);
    narrow_cache none = {.lower = 0};
    out->asked = (uint8_t)ask_at(w, p, &b_in_a, &d, w->options.caches ? &p->cache : &none, scratch, r);
    out->cost = work_of(a, b, &d, r->lo);
    out->stage = STAGE_OF_METHOD[r->method];
    out->left = false;
    out->wants_shell = wants_shell(p, a->shape.type, b->shape.type, r);
    keep(w, p, &b_in_a, r);
}

static void decide_fully(void *context, size_t begin, size_t end, unsigned worker)
{
    world *w = context;
    for (size_t n = begin; n < end; n++) {
        uint32_t k = w->open.at[n];
        w->outcomes.at[k].result = (uint32_t)n;
        fetch_open_ahead(w, n);
        refine(w, k, &w->results.at[n], w->scratch[worker]);
    }
}

/* ---- bounds ---- */

/* Where they are all that is asked, they are as narrow as asked. */
static void decide_by_bounds(void *context, size_t begin, size_t end, unsigned worker)
{
    world *w = context;
    for (size_t n = begin; n < end; n++) {
        uint32_t k = w->open.at[n];
        pair *p = &w->pairs.at[w->active_pairs.at[k]];
        const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
        outcome *out = &w->outcomes.at[k];
        narrow_result *r = &w->results.at[n];
        if (pair_is_soft(w, p)) {
            soft_fill(w, p, r);
            out->result = (uint32_t)n;
            out->settled = true;
            continue;
        }
        if (n >= w->bounded && out->floor) { /* still */
            out->left = true;
            continue;
        }
        demand d = cascade_demand(w, p);
        pose b_in_a = relative_of_active(w, p, a, b);
        if (n < w->bounded)
            bounds_find(w, p, &b_in_a, d.limit, !out->coarse && remembers(w), w->scratch[worker], r);
        else
            bounds_floor(w, p, &b_in_a, r);
        r->status = out->coarse && n < w->bounded ? NARROW_CERTAIN : NARROW_WIDE;
        out->stage = STAGE_BOUNDS;
        out->cost = work_of_bounds(a, b);
        out->result = (uint32_t)n;
        out->left = n >= w->bounded;
        out->work = work_of(a, b, &d, r->lo);
        out->settled = r->lo > d.limit;
        bool enough = pair_more_make(w, p)->standing.enough = r->lo > d.limit || (out->coarse && !out->left);
        out->left &= !enough;
    }
}

/* ---- without a budget ---- */

/* Open pairs: first those of which bounds are asked, then all others. */
static void open_all(world *w, bool coarse)
{
    for (size_t i = 0; i < w->active_pairs.count; i++) {
        const outcome *o = &w->outcomes.at[i];
        if (!o->settled && o->coarse == coarse) array_push(&w->open, (uint32_t)i);
    }
}

typedef struct part {
    world *w;
    size_t from;
    workers_function *decide;
} part;

static void decide_part(void *context, size_t begin, size_t end, unsigned worker)
{
    const part *of = context;
    of->decide(of->w, of->from + begin, of->from + end, worker);
}

/* The open pairs [from, to). */
static void decide_open(world *w, size_t from, size_t to, workers_function *decide)
{
    part of = {w, from, decide};
    workers_run(w->workers, to - from, PAIRS_A_CHUNK, decide_part, &of);
}

static void decide_all(world *w)
{
    open_all(w, true);
    w->bounds = w->bounded = w->open.count;
    open_all(w, false);
    array_reserve(&w->results, w->open.count);
    decide_open(w, 0, w->bounds, decide_by_bounds);
    decide_open(w, w->bounds, w->open.count, decide_fully);
}

/* ---- with a budget ---- */

/* Those without bounds that stand, beginning where the last tick that could not bound all ended. */
static void open_unbounded(world *w)
{
    size_t count = w->active_pairs.count, first = 0;
    while (first < count && w->active.at[first] < w->next_bound) first++;
    for (size_t n = 0; n < count; n++) {
        size_t k = (first + n) % count;
        if (!w->outcomes.at[k].settled && (!w->outcomes.at[k].stands || w->outcomes.at[k].floor))
            array_push(&w->open, (uint32_t)k);
    }
}

/* How many of the open pairs from `from` on can be bounded with what is granted; adds their work to *done. */
static size_t count_possible(const world *w, size_t from, uint64_t granted, uint64_t *done)
{
    for (; from < w->open.count; from++) {
        const pair *p = &w->pairs.at[w->active_pairs.at[w->open.at[from]]];
        uint64_t work = work_of_bounds(&w->colliders.at[p->a], &w->colliders.at[p->b]);
        if (*done + work > granted) break;
        *done += work;
    }
    return from;
}

/* Returns the units done, and *granted of them in all. Of the others, what balls prove is reported.
 */
static uint64_t bound_what_is_granted(world *w, uint64_t *granted)
{
    uint64_t done = 0;
    open_unbounded(w);
    size_t count = w->bounds = w->open.count;
    array_reserve(&w->results, count);
    *granted = w->grant(w->grant_context, 0);
    for (;;) {
        size_t from = w->bounded;
        w->bounded = count_possible(w, from, *granted, &done);
        decide_open(w, from, w->bounded, decide_by_bounds);
        if (w->bounded == count) break;
        uint64_t more = w->grant(w->grant_context, done);
        if (more <= *granted) break;
        *granted = more;
    }
    decide_open(w, w->bounded, count, decide_by_bounds);
    w->next_bound = w->bounded < count ? w->active.at[w->open.at[w->bounded]] : 0;
    w->figures.unbounded = count - w->bounded;
    return done;
}

static void leave_for_later(world *w, uint32_t k)
{
    pair *p = &w->pairs.at[w->active_pairs.at[k]];
    w->outcomes.at[k].left = true;
    if (p->waited < UINT8_MAX) p->waited++;
    array_push(&w->unfinished, w->active_pairs.at[k]);
}

/* Of which bounds were asked, and have not been found. */
static void leave_unbounded(world *w)
{
    for (size_t n = w->bounded; n < w->bounds; n++) {
        const outcome *o = &w->outcomes.at[w->open.at[n]];
        if (o->coarse && o->left) leave_for_later(w, w->open.at[n]);
    }
}

/* Refines the first `todo` of those that need it, as far as is granted; returns how many. One that a tick cannot do
 * stands first, or not among them. */
static size_t refine_what_is_granted(world *w, size_t todo, uint64_t granted, uint64_t *done)
{
    for (size_t next = 0;;) {
        size_t from = w->open.count;
        for (; next < todo; next++) {
            uint32_t k = (uint32_t)w->needs.at[next], work = w->outcomes.at[k].work;
            if (*done + work > granted && !(next == 0 && work > w->capacity)) break;
            *done += work;
            array_push(&w->open, k);
        }
        array_reserve(&w->results, w->open.count);
        decide_open(w, from, w->open.count, decide_fully);
        if (next == todo) return next;
        uint64_t more = w->grant(w->grant_context, *done);
        if (more <= granted) return next;
        granted = more;
    }
}

/* Where not all are bounded, that is all that is done: so the units done are what it takes to do the same again. */
static void decide_within_budget(world *w)
{
    uint64_t granted, done = bound_what_is_granted(w, &granted);
    leave_unbounded(w);
    size_t todo = work_order(w), refined = 0;
    if (w->bounded == w->bounds) {
        refined = refine_what_is_granted(w, todo, granted, &done);
        work_learn(w, todo, refined, done);
    }
    for (size_t i = refined; i < w->needs.count; i++) leave_for_later(w, (uint32_t)w->needs.at[i]);
    w->figures.work = done;
    w->figures.undone = w->unfinished.count;
    w->figures.undone_ticks += w->unfinished.count > 0;
}

/* ---- all of it ---- */

static void count_outcomes(world *w)
{
    w->figures.pair_ticks += w->active_pairs.count;
    for (size_t i = 0; i < w->active_pairs.count; i++) {
        w->figures.stages[w->outcomes.at[i].stage]++;
        w->figures.narrow_queries += w->outcomes.at[i].asked;
    }
    for (size_t i = w->bounds; i < w->open.count; i++) {
        const narrow_result *r = &w->results.at[i];
        w->figures.manifolds += r->manifold.count > 0;
        w->figures.wide += r->status == NARROW_WIDE;
        w->figures.refined += r->refined;
        w->figures.peer_failures += r->peer_failures;
    }
}

/* Pairs that want one remember the surface that proved their depth: from the next tick on, until they end. */
static void lend_shells(world *w)
{
    for (size_t i = w->bounds; i < w->open.count && w->options.caches; i++) {
        if (!w->outcomes.at[w->open.at[i]].wants_shell) continue;
        pair *p = &w->pairs.at[w->active_pairs.at[w->open.at[i]]];
        p->cache.shell = base_zalloc(1, sizeof *p->cache.shell);
    }
}

void cascade_decide(world *w)
{
    array_reserve(&w->outcomes, w->active_pairs.count);
    workers_run(w->workers, w->active_pairs.count, PAIRS_A_CHUNK, decide_cheaply, w);
    w->open.count = w->bounds = w->bounded = w->unfinished.count = 0;
    w->figures.unbounded = w->figures.work = w->figures.undone = 0;
    if (w->grant)
        decide_within_budget(w);
    else
        decide_all(w);
    count_outcomes(w);
    work_charge(w);
    lend_shells(w);
}
