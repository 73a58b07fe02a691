/* ladder: decides the active pairs, cheapest proof first, in parallel. Each pair reads the world, and writes its own
 * cache and its own outcome only; so the result does not depend on who computes it.
 *
 * The cheap rungs may only say "beyond all that anybody asked, proven, and by more than the width of any answer": then
 * a full query would say so too, and no event depends on which one it was. A pair of which somebody has been told
 * something is always asked in full, and from nothing: the cache never enters an answer. */
#include "state.h"

#include "base/array.h"

#include <stdlib.h>

/* No answer is wider than this share of the pair's size (narrow.h): the cheap rungs keep that distance. */
static const double WIDEST_ANSWER = 1e-6;

enum { PAIRS_A_CHUNK = 32 };

demand ladder_demand(const world *w, const body *a, const body *b)
{
    pair_terms terms = pair_terms_of_paired(a, b);
    demand d = {.request = {.tolerance = INFINITY, .range = 0, .threshold = -INFINITY, .engine = w->options.engine},
        .limit = -INFINITY};
    for (size_t word = 0; word < w->words; word++) {
        for (uint64_t bits = interest_word(a, b, word); bits; bits &= bits - 1) {
            const interest *i = &w->interests.at[word * 64 + (size_t)__builtin_ctzll(bits)];
            d.request.tolerance = fmin(d.request.tolerance, i->tolerance);
            if (i->facts & WORLD_DISTANCE) {
                d.request.facts |= NARROW_DISTANCE;
                d.request.range = fmax(d.request.range, i->range + terms.margin);
                d.limit = fmax(d.limit, i->range + terms.margin);
            }
            if (i->facts & (WORLD_TOUCH | WORLD_MANIFOLD)) {
                d.request.facts |= NARROW_VERDICT;
                d.request.threshold = fmax(d.request.threshold, i->threshold + terms.padding);
                d.limit = fmax(d.limit, i->threshold + terms.padding);
            }
            if (i->facts & WORLD_MANIFOLD) d.request.facts |= NARROW_MANIFOLD;
        }
    }
    if (!isfinite(d.request.threshold)) d.request.threshold = 0;
    d.request.range = fmax(d.request.range, d.request.threshold);
    return d;
}

static double pair_size(const solid *a, const solid *b)
{
    return (isfinite(a->reach) ? a->reach : 0) + (isfinite(b->reach) ? b->reach : 0);
}

static bool is_axis(vec3 v)
{
    return v.x != 0 || v.y != 0 || v.z != 0;
}

/* Rung 3: one support query a shape. */
static bool settle_along(const solid *a, const solid *b, narrow_cache *c, vec3 axis, const pose *b_in_a, double limit)
{
    double lower = narrow_separation(&a->shape, &b->shape, b_in_a, axis, &c->hint_a, &c->hint_b);
    if (!(lower > limit)) return false;
    c->axis = axis;
    c->lower = lower;
    c->b_in_a = *b_in_a;
    return true;
}

/* Rungs 2 and 3: settled without looking at the shapes, or along the cached axis. A new pair begins with a guess in its
 * cache, and where the pair has turned away from its axis, the guess is tried before the narrow phase is asked. */
static bool settle_cheaply(const world *w, pair *p, const pose *b_in_a, double limit, outcome *out)
{
    const solid *a = &w->solids.at[p->a], *b = &w->solids.at[p->b];
    narrow_cache *c = &p->cache;
    if (!w->options.caches || pair_is_told(w, p)) return false;
    out->rung = RUNG_MOTION_BOUND;
    if (is_axis(c->axis) && c->lower - narrow_motion_bound(&c->b_in_a, b_in_a, b->reach) > limit) return true;
    out->rung = RUNG_CACHED_AXIS;
    if (is_axis(c->axis) && settle_along(a, b, c, c->axis, b_in_a, limit)) return true;
    vec3 guess = narrow_guess_axis(&a->shape, &b->shape, b_in_a);
    return is_axis(guess) && settle_along(a, b, c, guess, b_in_a, limit);
}

static void decide_cheaply(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)worker;
    world *w = context;
    for (size_t k = begin; k < end; k++) {
        pair *p = &w->pairs.at[w->active_pairs.at[k]];
        const solid *a = &w->solids.at[p->a], *b = &w->solids.at[p->b];
        const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
        outcome *out = &w->outcomes.at[k];
        *out = (outcome){.result = WORLD_NONE};
        if (x->stale || y->stale) {
            *out = (outcome){.rung = RUNG_UNKNOWN, .settled = true, .result = WORLD_NONE};
            continue;
        }
        demand d = ladder_demand(w, x, y);
        if (!(d.limit > -INFINITY)) {
            *out = (outcome){.rung = RUNG_UNASKED, .settled = true, .result = WORLD_NONE};
            continue;
        }
        pose b_in_a = solid_relative(w, a, b);
        double slack = d.request.tolerance + WIDEST_ANSWER * pair_size(a, b);
        out->settled = settle_cheaply(w, p, &b_in_a, d.limit + slack, out);
    }
}

static const uint8_t RUNG_OF_METHOD[NARROW_METHOD_COUNT] = {
    [NARROW_BY_CLOSED_FORM] = RUNG_CLOSED_FORM,
    [NARROW_BY_GJK] = RUNG_GJK,
    [NARROW_BY_EPA] = RUNG_EPA,
    [NARROW_BY_SAT] = RUNG_SAT,
    [NARROW_BY_CCD] = RUNG_CCD,
    [NARROW_BY_MPR] = RUNG_MPR,
};

/* A pair of which nobody has been told anything, and nobody asked the distance, needs only the verdict as long as it is
 * apart. Whatever is told has an interval as narrow as was asked; the verdict is decided alike in both. */
static uint32_t ask(const world *w, pair *p, const demand *d, void *scratch, narrow_result *r)
{
    const solid *a = &w->solids.at[p->a], *b = &w->solids.at[p->b];
    pose b_in_a = solid_relative(w, a, b);
    narrow_request request = d->request;
    narrow_cache none = {.lower = 0}, *cache = w->options.caches ? &p->cache : &none;
    bool told = pair_is_told(w, p);
    uint32_t asked = 0;
    if (!told && !(request.facts & NARROW_DISTANCE)) {
        request.facts = NARROW_VERDICT;
        narrow_query(&a->shape, &b->shape, &b_in_a, &request, cache, scratch, r);
        if (r->lo > request.threshold) return 1;
        request.facts = d->request.facts;
        told = true;
        asked = 1;
    }
    request.facts |= NARROW_DISTANCE;
    if (told) request.range = INFINITY;
    narrow_query(&a->shape, &b->shape, &b_in_a, &request, cache, scratch, r);
    return asked + 1;
}

static void decide_fully(void *context, size_t begin, size_t end, unsigned worker)
{
    world *w = context;
    for (size_t k = begin; k < end; k++) {
        outcome *out = &w->outcomes.at[w->open.at[k]];
        pair *p = &w->pairs.at[w->active_pairs.at[w->open.at[k]]];
        const solid *a = &w->solids.at[p->a], *b = &w->solids.at[p->b];
        demand d = ladder_demand(w, &w->bodies.at[a->body], &w->bodies.at[b->body]);
        narrow_result *r = &w->results.at[k];
        out->asked = (uint8_t)ask(w, p, &d, w->scratch[worker], r);
        p->cache.axis = r->axis;
        p->cache.b_in_a = solid_relative(w, a, b);
        p->cache.lower = r->lo;
        out->rung = RUNG_OF_METHOD[r->method];
        out->result = (uint32_t)k;
    }
}

static void count_outcomes(world *w)
{
    w->figures.pair_ticks += w->active_pairs.count;
    for (size_t i = 0; i < w->active_pairs.count; i++) {
        w->figures.rungs[w->outcomes.at[i].rung]++;
        w->figures.narrow_queries += w->outcomes.at[i].asked;
    }
    for (size_t i = 0; i < w->open.count; i++) {
        const narrow_result *r = &w->results.at[i];
        w->figures.manifolds += r->manifold.count > 0;
        w->figures.wide += r->status == NARROW_WIDE;
        w->figures.refined += r->refined;
        w->figures.peer_failures += r->peer_failures;
    }
}

/* Hulls that overlap remember the surface that proved their depth: from the next tick on, until the pair ends. */
static void lend_shells(world *w)
{
    for (size_t i = 0; i < w->open.count && w->options.caches; i++) {
        pair *p = &w->pairs.at[w->active_pairs.at[w->open.at[i]]];
        bool hulls = w->solids.at[p->a].shape.type == SHAPE_HULL && w->solids.at[p->b].shape.type == SHAPE_HULL;
        if (hulls && w->results.at[i].hi < 0 && !p->cache.shell)
            p->cache.shell = base_zalloc(1, sizeof *p->cache.shell);
    }
}

void ladder_decide(world *w)
{
    array_reserve(&w->outcomes, w->active_pairs.count);
    workers_run(w->workers, w->active_pairs.count, PAIRS_A_CHUNK, decide_cheaply, w);
    w->open.count = 0;
    for (size_t i = 0; i < w->active_pairs.count; i++)
        if (!w->outcomes.at[i].settled) array_push(&w->open, (uint32_t)i);
    array_reserve(&w->results, w->open.count);
    workers_run(w->workers, w->open.count, PAIRS_A_CHUNK, decide_fully, w);
    count_outcomes(w);
    lend_shells(w);
}
