/* impact: what pairs did on their way from one tick to the next, and what they will do: searches for a time of impact,
 * one a pair and subscription that asks for it, in parallel. Each reads the world and writes its own result only. */
#include "state.h"
#include "subscription.h"

#include <stdlib.h>

enum { SWEEPS_A_CHUNK = 4 };

/* No search is finer than this share of the pair's size. */
static const double FINEST_SEARCH = 1e-10;

/* ---- which searches ---- */

static bool has_swept_motions(const body *b)
{
    return b->moved || b->past.count;
}

static bool wants_swept_motion(const body *a, const body *b)
{
    return (has_swept_motions(a) || has_swept_motions(b)) && (a->ccd != WORLD_CCD_OFF || b->ccd != WORLD_CCD_OFF);
}

static bool may_do_something(const body *b)
{
    return body_has_predicted_motion(b) || (!b->fixed && (b->acceleration > 0 || b->angular_acceleration > 0));
}

static void add(world *w, uint32_t active, uint32_t id, bool predicts, uint64_t tick)
{
    sweep s = {.active = active, .subscription = id, .predicts = predicts, .tick = tick};
    const sweep *last = w->sweeps.count ? &w->sweeps.at[w->sweeps.count - 1] : NULL;
    if (last && last->active == active && last->predicts == predicts && last->tick == tick) {
        const subscription *i = &w->subscriptions.at[id], *j = &w->subscriptions.at[last->subscription];
        s.again = i->threshold == j->threshold && i->tolerance == j->tolerance &&
                  i->relative_tolerance == j->relative_tolerance && (!predicts || i->horizon == j->horizon);
    }
    array_push(&w->sweeps, s);
}

/* For the subscriptions from that one on. */
static void add_of_pair(world *w, uint32_t active, unsigned fact, uint64_t tick, uint32_t from)
{
    const pair *p = &w->pairs.at[w->active_pairs.at[active]];
    match_list wanted = subscription_list(w, p);
    for (uint32_t k = 0; k < wanted.count; k++)
        if (wanted.at[k] >= from && w->subscriptions.at[wanted.at[k]].facts & fact)
            add(w, active, wanted.at[k], fact == WORLD_PREDICT, tick);
}

static void add_ways_of(world *w, uint32_t active, const pair *p, uint64_t tick)
{
    add_of_pair(
        w, active, WORLD_IMPACT, tick, tick == pair_more_of(w, p)->swept_tick + 1 ? pair_more_of(w, p)->swept_from : 0);
}

/* What both keep since it was decided last, tick by tick, and then how they came in this one. */
static void add_swept_motions(world *w, uint32_t active, const pair *p, const body *a, const body *b)
{
    uint64_t now = w->figures.ticks;
    if (w->past_bodies.count)
        for (uint64_t t = past_next(a, b, past_decided(w, p, a, b)); t < now; t = past_next(a, b, t))
            add_ways_of(w, active, p, t);
    if (a->moved || b->moved) add_ways_of(w, active, p, now);
}

static void collect(world *w)
{
    w->sweeps.count = 0;
    if (!w->sweepers) return;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        const pair *p = &w->pairs.at[w->active_pairs.at[k]];
        const body *a = &w->bodies.at[w->colliders.at[p->a].body], *b = &w->bodies.at[w->colliders.at[p->b].body];
        if (a->soft || b->soft) continue; /* the motions of their steps are reported (soft_results.c) */
        if ((a->stale && !has_swept_motions(a)) || (b->stale && !has_swept_motions(b)))
            continue; /* too late is not too late for what was */
        if (a->impacts && b->impacts && wants_swept_motion(a, b)) add_swept_motions(w, (uint32_t)k, p, a, b);
        if (a->stale || b->stale) continue;
        if (a->horizon > 0 && b->horizon > 0 && (may_do_something(a) || may_do_something(b) || pair_is_predicted(w, p)))
            add_of_pair(w, (uint32_t)k, WORLD_PREDICT, w->figures.ticks, pair_more_of(w, p)->predicted_from);
    }
}

/* ---- the searches ---- */

static double seconds(int64_t ns)
{
    return 1e-9 * (double)ns;
}

/* m: how far any point of the other one may be from this one's origin while a half-space turns towards it. */
static double arm_of_plane(const body *b, const body *other, const collider *s, double span)
{
    motion predicted = body_predicted_motion(b), others = body_predicted_motion(other);
    double line = vec_norm(predicted.linear) + vec_norm(others.linear), accelerations = b->acceleration;
    accelerations += other->fixed ? 0 : other->acceleration;
    return vec_norm(vec_sub(other->pose.p, b->pose.p)) + vec_norm(s->local.p) + s->reach + line * span +
           0.5 * accelerations * span * span;
}

/* m/s^2: by how much the gap may close besides, for what this body may do; `s`, `other`: what it may meet. */
static double wander_of(const body *b, const collider *own, const body *other, const collider *s, double span)
{
    if (b->fixed || (b->acceleration == 0 && b->angular_acceleration == 0)) return 0;
    if (b->angular_acceleration == 0) return b->acceleration;
    double reach =
        isfinite(own->reach) ? own->reach + vec_norm(own->local.p) : arm_of_plane(b, other, s, span) * (1 + 0x1p-40);
    return b->acceleration + b->angular_acceleration * reach;
}

static int64_t newest(const body *a, const body *b)
{
    return a->stamp_ns > b->stamp_ns ? a->stamp_ns : b->stamp_ns;
}

/* s: how long the longer motion takes. */
static double set_swept_motion(const world *w, sweep *s, const body *a, const body *b)
{
    int64_t span_a = body_span_ns(w, a), span_b = body_span_ns(w, b), span = span_a > span_b ? span_a : span_b;
    const body *longer = span_a >= span_b ? a : b;
    s->start_ns = stamps_between(span, longer->stamp_ns ? longer->stamp_ns
                                       : longer->as_of  ? longer->as_of->now_ns
                                                        : w->now_ns);
    return seconds(span);
}

/* s: from the body's pose to the newest of the pair. */
static double lag_of(const body *b, int64_t start_ns)
{
    return b->stamp_ns && may_do_something(b) ? seconds(stamps_between(b->stamp_ns, start_ns)) : 0;
}

/* Both from the newest pose on: an older one is carried on to it. What is predicted ends a horizon after the older one:
 * so far reach the boxes. `known`: where both are then. */
static double set_predicted_motions(
    const world *w, sweep *s, const body *a, const body *b, toi_mover *ma, toi_mover *mb, bool *known)
{
    int64_t stamp_ns = newest(a, b);
    double lag_a = lag_of(a, stamp_ns), lag_b = lag_of(b, stamp_ns);
    ma->motion = body_predicted_motion(a);
    mb->motion = body_predicted_motion(b);
    bool known_a = motion_begin_at(&ma->motion, lag_a), known_b = motion_begin_at(&mb->motion, lag_b);
    *known = known_a && known_b;
    s->start_ns = stamp_ns ? stamp_ns : w->now_ns;
    s->estimated = (body_has_predicted_motion(a) && a->speed == SPEED_ESTIMATED) ||
                   (body_has_predicted_motion(b) && b->speed == SPEED_ESTIMATED);
    return w->subscriptions.at[s->subscription].horizon - fmax(lag_a, lag_b);
}

/* m: by how much more than wander t^2 / 2 one may be elsewhere that has accelerated since it was last seen. */
static double drift_of(const body *b, const sweep *s, double wander, double span)
{
    double lag = lag_of(b, s->start_ns);
    return wander * lag * (0.5 * lag + span) * (1 + 0x1p-40);
}

static bool can_turn(const motion *m, double span)
{
    return vec_norm(m->angular) * span <= MOTION_ANGLE_MAX;
}

/* Were they in contact at the last tick, where the search begins? A swept motion that does not turn begins in the
 * orientation of its end: how the bodies stood is another question then; so it is where the rounding of the motion
 * leaves it open. */
static bool began_in_contact(const sweep *s, const toi_mover *x, const toi_mover *y, const body *a, const body *b,
    const toi_request *request, void *scratch)
{
    const toi_result *r = &s->result;
    if (s->predicts || (r->status != TOI_HIT && r->status != TOI_NEAR) || r->lo > 0) return false;
    bool both_turn = body_motion_turns(a) && body_motion_turns(b), clear = r->gap_lo > request->threshold;
    if (both_turn && (clear || r->gap_hi <= request->threshold)) return !clear;
    narrow_request ask = {.facts = NARROW_VERDICT, .tolerance = request->tolerance, .threshold = request->threshold};
    narrow_result n;
    pose was_a = body_before(a), was_b = body_before(b); /* about the origin of A's body */
    was_b.p = vec_sub(was_b.p, was_a.p);
    was_a.p = VEC_ZERO;
    narrow_query_world(x->shape, pose_mul(was_a, x->local), y->shape, pose_mul(was_b, y->local), &ask, scratch, &n);
    return n.lo <= request->threshold;
}

enum { BARREN_MAX = 6 }; /* after so many searches for an axis in vain, one in 2^6 ticks is left */

/* Along the axis that kept them free last time, if there is one. What that takes is counted, and counts decide what is
 * put off: so it is the same without caches, where the answer is one that was found from nothing. */
static void find_along(const world *w, sweep *s, const pair *p, const toi_mover *a, const toi_mover *b,
    const toi_request *request, void *scratch)
{
    vec3 guess = s->predicts ? pair_more_of(w, p)->free_axis : VEC_ZERO;
    toi_find(a, b, request, guess, scratch, &s->result);
    s->queries = s->result.queries;
    s->steps = s->result.steps;
    if (!w->options.caches && vec_max_abs(guess) > 0) toi_find(a, b, request, VEC_ZERO, scratch, &s->result);
}

/* A pair that took a search to be predicted free is given an axis for the next tick; swept motions are too short to be
 * worth it. Read only: what was found is kept by keep_axis, because several subscriptions may ask for one pair.
 * `known`: where they begin. */
static void find(const world *w, sweep *s, const pair *p, const toi_mover *a, const toi_mover *b, bool known,
    const toi_request *request, void *scratch)
{
    s->queries = s->steps = 0;
    if (known && can_turn(&a->motion, request->span) && can_turn(&b->motion, request->span))
        find_along(w, s, p, a, b, request, scratch);
    else /* service refuses such speeds; a horizon may make too many turns of them yet */
        s->result = (toi_result){.status = TOI_UNDECIDED,
            .hi = INFINITY,
            .gap_lo = -INFINITY,
            .gap_hi = INFINITY,
            .body_a = a->motion.start,
            .body_b = b->motion.start};
    uint64_t often = ((uint64_t)1 << pair_more_of(w, p)->barren) - 1;
    uint32_t looks = 0;
    if (!s->predicts || s->result.status != TOI_FREE || s->queries == 0) return;
    if (w->figures.ticks & often) return;
    s->sought = true;
    s->free_axis = impact_axis(a, b, request, scratch, &looks);
    s->queries += looks;
    s->result.queries += w->options.caches ? looks : 0;
}

/* Both ways take as long as the longer one, so that they are where they are at the same share of it. Leg by leg, the
 * shorter of the two; a hit ends it, or what is not known to be free. What a search may take is for all legs together.
 */
static void search_swept_motions(const world *w, sweep *s, const pair *p, const body *a, const body *b, toi_mover *ma,
    toi_mover *mb, toi_request *request, void *scratch)
{
    double span = fmax(body_span(w, a), body_span(w, b));
    uint32_t queries = 0, steps = 0, work = 0;
    size_t leg_a = 0, leg_b = 0;
    for (double from = 0, to; from < 1; from = to) {
        double end_a = body_leg_begins(a, leg_a + 1), end_b = body_leg_begins(b, leg_b + 1);
        to = fmin(end_a, end_b);
        request->span = (to - from) * span;
        bool known_a = body_leg(w, a, leg_a, from, span, &ma->motion);
        bool known_b = body_leg(w, b, leg_b, from, span, &mb->motion);
        leg_a += end_a <= to, leg_b += end_b <= to;
        if (!(request->span > 0)) continue;
        request->spent = s->spent + work;
        find(w, s, p, ma, mb, known_a && known_b, request, scratch);
        queries += s->result.queries, steps += s->result.steps, work += s->result.work;
        if (s->result.status == TOI_FREE) continue;
        s->result.lo += from * span;
        s->result.hi += from * span;
        break;
    }
    s->queries = s->result.queries = queries;
    s->steps = s->result.steps = steps;
    s->result.work = work;
}

static void keep_axis(world *w, const sweep *s)
{
    pair *p = &w->pairs.at[w->active_pairs.at[s->active]];
    bool found = vec_max_abs(s->free_axis) > 0;
    if (s->sought) {
        pair_more *more = pair_more_make(w, p);
        bool had = vec_max_abs(more->free_axis) > 0; /* one that did not serve */
        if ((had || !found) && more->barren < BARREN_MAX) ++more->barren;
        more->free_axis = s->free_axis;
    } else if (s->predicts && s->result.status == TOI_FREE && s->queries == 0) {
        if (p->has_more) pair_more_make(w, p)->barren = 0;
    }
}

static void search(const world *w, sweep *s, void *scratch)
{
    const pair *p = &w->pairs.at[w->active_pairs.at[s->active]];
    const collider *x = &w->colliders.at[p->a], *y = &w->colliders.at[p->b];
    body then_a, then_b;
    const body *a = past_body(w, &w->bodies.at[x->body], s->tick, &then_a);
    const body *b = past_body(w, &w->bodies.at[y->body], s->tick, &then_b);
    const subscription *i = &w->subscriptions.at[s->subscription];
    toi_mover ma = {&x->shape, x->local, {.start = a->pose}}, mb = {&y->shape, y->local, {.start = b->pose}};
    bool known = true;
    double span = s->predicts ? set_predicted_motions(w, s, a, b, &ma, &mb, &known) : set_swept_motion(w, s, a, b);
    double size = (isfinite(x->reach) ? x->reach : 0) + (isfinite(y->reach) ? y->reach : 0);
    s->result = (toi_result){.status = TOI_FREE, .lo = INFINITY, .hi = INFINITY};
    if (!(span > 0)) return; /* one of them was last seen a horizon ago */
    double wander_a = s->predicts ? wander_of(a, x, b, y, i->horizon) : 0;
    double wander_b = s->predicts ? wander_of(b, y, a, x, i->horizon) : 0;
    double drift = s->predicts ? drift_of(a, s, wander_a, span) + drift_of(b, s, wander_b, span) : 0;
    toi_request request = {.span = span,
        .threshold = i->threshold + pair_kept_terms(p).padding + drift,
        .tolerance = fmax(fmax(subscription_tolerance(i, size), FINEST_SEARCH * size), 1e-300),
        .wander = wander_a + wander_b,
        .spent = s->spent};
    if (past_apart(a, b, fmax(request.threshold + request.tolerance, 0))) return;
    if (s->predicts)
        find(w, s, p, &ma, &mb, known, &request, scratch);
    else
        search_swept_motions(w, s, p, a, b, &ma, &mb, &request, scratch);
    s->began = began_in_contact(s, &ma, &mb, a, b, &request, scratch);
}

typedef struct batch {
    world *w;
    size_t from;
} batch;

static void search_some(void *context, size_t begin, size_t end, unsigned worker)
{
    const batch *all = context;
    world *w = all->w;
    for (size_t i = begin; i < end; i++) search(w, &w->sweeps.at[w->sweep_order.at[all->from + i]], w->scratch[worker]);
}

static void search_batch(world *w, size_t from, size_t to)
{
    batch all = {w, from};
    workers_run(w->workers, to - from, SWEEPS_A_CHUNK, search_some, &all);
}

void impact_decide(world *w)
{
    collect(w);
    impact_search(w, search_batch);
    impact_settle(w);
    for (size_t k = 0; k < w->sweeps.count; k++) {
        sweep *s = &w->sweeps.at[k];
        if (s->put_off) continue;
        if (s->again) {
            s->result = s[-1].result;
            s->start_ns = s[-1].start_ns;
            s->estimated = s[-1].estimated;
            s->began = s[-1].began;
            continue;
        }
        keep_axis(w, s);
        w->figures.sweeps++;
        w->figures.sweeps_by_axis += s->result.status == TOI_FREE && s->result.queries == 0;
        w->figures.sweep_queries += s->result.queries;
        w->figures.undecided += s->result.status == TOI_UNDECIDED;
    }
}
