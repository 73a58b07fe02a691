/* events: what the outcomes of a tick mean to each interest: begin, update, end, near, far, unknown, known; impacts and
 * what is foretold are told by events_impact.c. Tick thread.
 *
 * Pairs are walked in the order of their solids' ids and interests by theirs, so ids and order of events follow from
 * the commands. A contact id has exactly one begin and one end: it is taken in `begin_or_end_touch` and given up there,
 * or in `end_watch` when the pair or the interest goes. */
#include "events.h"

#include "base/hash.h"
#include "narrow/feature_code.h"

#include <stdlib.h>
#include <string.h>

/* ---- emission ---- */

static uint64_t hash_event(uint64_t h, uint32_t interest, const world_event *e)
{
    h = hash_bytes(h, &interest, sizeof interest);
    h = hash_bytes(h, &e->kind, sizeof e->kind);
    h = hash_bytes(h, &e->cause, sizeof e->cause);
    h = hash_bytes(h, &e->achieved, sizeof e->achieved);
    h = hash_bytes(h, &e->contact, sizeof e->contact);
    h = hash_bytes(h, e->name_a, strlen(e->name_a));
    h = hash_bytes(h, e->name_b, strlen(e->name_b));
    const double numbers[] = {e->lo, e->hi, e->axis.x, e->axis.y, e->axis.z, e->point_a.x, e->point_a.y, e->point_a.z,
        e->point_b.x, e->point_b.y, e->point_b.z, (double)e->age_a_ns, (double)e->age_b_ns, e->closing};
    h = hash_bytes(h, numbers, sizeof numbers);
    for (uint32_t i = 0; i < e->manifold.count; i++) {
        const manifold_point *p = &e->manifold.points[i];
        const double point[] = {p->point.x, p->point.y, p->point.z, p->distance};
        h = hash_bytes(h, point, sizeof point);
        h = hash_bytes(h, &p->feature, sizeof p->feature);
    }
    if (e->kind == EVENT_IMPACT || e->kind == EVENT_FORETOLD) {
        const double times[] = {e->impact.lo, e->impact.hi, (double)e->impact.start_ns};
        h = hash_bytes(h, times, sizeof times);
    }
    return h;
}

/* What is told again in a snapshot does not count for the hash: who asks for one, and when, is no command. */
void events_emit(world *w, uint32_t id, const world_event *e, uint8_t kind, uint8_t cause, int64_t contact)
{
    interest *i = &w->interests.at[id];
    array_push(&i->events, *e);
    world_event *mine = &i->events.at[i->events.count - 1];
    mine->kind = kind;
    mine->cause = cause;
    mine->contact = contact;
    if (kind == EVENT_UNKNOWN) {
        mine->lo = -INFINITY;
        mine->hi = INFINITY;
        mine->achieved = WORLD_WIDE;
    }
    if (cause == CAUSE_SNAPSHOT) return;
    w->hash = hash_event(w->hash, id, mine);
    w->figures.events++;
}

static vec3 to_world(const solid *s, vec3 point_in_s)
{
    return pose_point(s->world, point_in_s);
}

void events_turn_round(world_event *e)
{
    world_event was = *e;
    e->name_a = was.name_b;
    e->name_b = was.name_a;
    e->shape_a = was.shape_b;
    e->shape_b = was.shape_a;
    e->axis = vec_neg(was.axis);
    e->point_a = was.point_b;
    e->point_b = was.point_a;
    e->age_a_ns = was.age_b_ns;
    e->age_b_ns = was.age_a_ns;
    e->impact.pose_a = was.impact.pose_b;
    e->impact.pose_b = was.impact.pose_a;
    for (uint32_t i = 0; i < e->manifold.count; i++)
        e->manifold.points[i].feature = feature_turned(was.manifold.points[i].feature);
}

bool events_is_turned(const body *a, const body *b, uint32_t id, int looks)
{
    uint64_t mask = (uint64_t)1 << (id & 63);
    size_t word = id >> 6;
    bool straight = a->match_a[word] & mask && b->match_b[word] & mask;
    bool turned = b->match_a[word] & mask && a->match_b[word] & mask;
    return straight && turned ? looks < 0 : turned;
}

static vec3 velocity_at(const body *b, vec3 point)
{
    vec3 linear, angular;
    if (b->fixed || !b->speed) return VEC_ZERO;
    body_velocity(b, &linear, &angular);
    return vec_add(linear, vec_cross(angular, vec_sub(point, b->pose.p)));
}

void events_fill(const world *w, const pair *p, const narrow_result *r, uint32_t interest, int looks, world_event *e)
{
    const solid *a = &w->solids.at[p->a], *b = &w->solids.at[p->b];
    const body *x = &w->bodies.at[a->body], *y = &w->bodies.at[b->body];
    *e = (world_event){.name_a = x->name,
        .name_b = y->name,
        .shape_a = a->index,
        .shape_b = b->index,
        .lo = r->lo,
        .hi = r->hi,
        .axis = quat_rotate(a->world.q, r->axis),
        .point_a = to_world(a, r->point_a),
        .point_b = to_world(a, r->point_b),
        .age_a_ns = body_age_ns(w, x),
        .age_b_ns = body_age_ns(w, y),
        .manifold = r->manifold};
    for (uint32_t i = 0; i < e->manifold.count; i++)
        e->manifold.points[i].point = to_world(a, e->manifold.points[i].point);
    e->closing = vec_dot(e->axis, vec_sub(velocity_at(x, e->point_a), velocity_at(y, e->point_b)));
    if (events_is_turned(x, y, interest, looks)) events_turn_round(e);
}

/* ---- watches ---- */

int64_t watch_id(const watch *v)
{
    return v->touch_id ? v->touch_id : v->near_id ? v->near_id : v->foretold_id;
}

const world_event *watch_last(const watch *v)
{
    return v->touch_id || v->near_id ? &v->last : &v->foretold;
}

uint32_t watch_find(const world *w, const pair *p, uint32_t interest)
{
    uint32_t id = p->first_watch;
    while (id != WORLD_NONE && w->watches.at[id].interest < interest) id = w->watches.at[id].pair_next;
    return id != WORLD_NONE && w->watches.at[id].interest == interest ? id : WORLD_NONE;
}

uint32_t watch_add(world *w, uint32_t pair_id, uint32_t interest_id)
{
    uint32_t id = id_pool_take(&w->watch_ids);
    array_reserve(&w->watches, id + 1);
    if (id >= w->watches.count) w->watches.count = id + 1;
    watch *v = &w->watches.at[id];
    interest *i = &w->interests.at[interest_id];
    *v = (watch){.used = true,
        .pair = pair_id,
        .interest = interest_id,
        .interest_next = i->first_watch,
        .interest_prev = WORLD_NONE};
    if (i->first_watch != WORLD_NONE) w->watches.at[i->first_watch].interest_prev = id;
    i->first_watch = id;
    i->watches++;

    uint32_t *link = &w->pairs.at[pair_id].first_watch;
    while (*link != WORLD_NONE && w->watches.at[*link].interest < interest_id) link = &w->watches.at[*link].pair_next;
    v->pair_next = *link;
    *link = id;
    return id;
}

void watch_drop(world *w, uint32_t id)
{
    watch *v = &w->watches.at[id];
    uint32_t *link = &w->pairs.at[v->pair].first_watch;
    while (*link != id) link = &w->watches.at[*link].pair_next;
    *link = v->pair_next;
    if (v->interest_prev != WORLD_NONE)
        w->watches.at[v->interest_prev].interest_next = v->interest_next;
    else
        w->interests.at[v->interest].first_watch = v->interest_next;
    if (v->interest_next != WORLD_NONE) w->watches.at[v->interest_next].interest_prev = v->interest_prev;
    v->used = false;
    w->interests.at[v->interest].watches--;
    id_pool_give(&w->watch_ids, id);
}

static bool is_held_back(const world *w, uint32_t id, uint32_t interest)
{
    const watch *v = &w->watches.at[id];
    return v->used && v->interest == interest && (v->dirty || v->foretold_dirty);
}

/* Leaves out watches that have ended since, and of one whose id was another's each entry but the first: in the order in
 * which they would have been told, too. */
static void drop_void_held(world *w, uint32_t interest_id)
{
    interest *i = &w->interests.at[interest_id];
    size_t kept = 0;
    for (size_t k = 0; k < i->held.count; k++) w->watches.at[i->held.at[k]].listed = false;
    for (size_t k = 0; k < i->held.count; k++) {
        watch *v = &w->watches.at[i->held.at[k]];
        if (v->listed || !is_held_back(w, i->held.at[k], interest_id)) continue;
        v->listed = true;
        i->held.at[kept++] = i->held.at[k];
    }
    i->held.count = kept;
}

void watch_hold_back(world *w, uint32_t id)
{
    uint32_t interest_id = w->watches.at[id].interest;
    interest *i = &w->interests.at[interest_id];
    if (i->held.count >= 2 * i->watches + SPARE_HELD) drop_void_held(w, interest_id);
    array_push(&i->held, id);
}

/* Boxes of an unknown body that part prove nothing of its motion. */
static void end_watch(world *w, uint32_t id, uint8_t cause)
{
    watch *v = &w->watches.at[id];
    if (v->unknown && cause == CAUSE_MOTION) cause = CAUSE_STALE;
    if (v->touch_id) {
        events_emit(w, v->interest, &v->last, EVENT_END, cause, v->touch_id);
        w->figures.contacts--;
    }
    if (v->near_id) events_emit(w, v->interest, &v->last, EVENT_FAR, cause, v->near_id);
    if (v->foretold_id) events_emit(w, v->interest, &v->foretold, EVENT_AVERTED, cause, v->foretold_id);
    watch_drop(w, id);
}

void events_pair_ended(world *w, uint32_t pair_id, uint8_t cause)
{
    while (w->pairs.at[pair_id].first_watch != WORLD_NONE) end_watch(w, w->pairs.at[pair_id].first_watch, cause);
}

/* Pairs that stay for others, but are none to an interest any more: a body is in another group. */
void events_unmatched(world *w)
{
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        const pair *p = &w->pairs.at[w->active_pairs.at[k]];
        const body *a = &w->bodies.at[w->solids.at[p->a].body], *b = &w->bodies.at[w->solids.at[p->b].body];
        for (uint32_t id = p->first_watch, after; id != WORLD_NONE; id = after) {
            uint32_t interest = w->watches.at[id].interest;
            after = w->watches.at[id].pair_next;
            if (!(interest_word(a, b, interest >> 6) >> (interest & 63) & 1)) end_watch(w, id, CAUSE_INTEREST);
        }
    }
}

/* ---- what an outcome means ---- */

bool events_may_update(const world *w, const interest *i)
{
    return !i->period_ns || w->now_ns >= i->next_update_ns;
}

/* An update that the rate holds back is told when it allows, though the pair may be back by then where it was. */
static void update(world *w, uint32_t id, uint8_t kind, int64_t contact, bool news)
{
    watch *v = &w->watches.at[id];
    interest *i = &w->interests.at[v->interest];
    if (!news && !v->dirty && !i->all) return;
    if (events_may_update(w, i)) {
        v->dirty = false;
        events_emit(w, v->interest, &v->last, kind, CAUSE_MOTION, contact);
    } else if (!v->dirty) {
        v->dirty = true;
        watch_hold_back(w, id);
    }
}

static void begin_or_end_touch(world *w, watch *v, bool touches, uint8_t cause)
{
    if (touches && !v->touch_id) {
        v->touch_id = ++w->serial;
        w->figures.contacts++;
        events_emit(w, v->interest, &v->last, EVENT_BEGIN, cause, v->touch_id);
    } else if (!touches && v->touch_id) {
        events_emit(w, v->interest, &v->last, EVENT_END, cause, v->touch_id);
        v->touch_id = 0;
        w->figures.contacts--;
    }
}

/* A pair in contact is near as well: both episodes have an id, a begin and an end of their own; while it lasts, the
 * contact alone is updated. */
static void transit(world *w, uint32_t id, bool touches, bool near, bool news, uint8_t cause)
{
    watch *v = &w->watches.at[id];
    bool touched = v->touch_id, was_near = v->near_id;
    if (v->unknown) {
        v->unknown = false;
        news = true;
        events_emit(w, v->interest, watch_last(v), EVENT_KNOWN, CAUSE_MOTION, watch_id(v));
    }
    if (near && !was_near) {
        v->near_id = ++w->serial;
        events_emit(w, v->interest, &v->last, EVENT_NEAR, cause, v->near_id);
    }
    begin_or_end_touch(w, v, touches, cause);
    if (touched && touches)
        update(w, id, EVENT_UPDATE, v->touch_id, news);
    else if (near && was_near && !touches)
        update(w, id, EVENT_NEAR, v->near_id, news || touched);
    if (!near && was_near) {
        events_emit(w, v->interest, &v->last, EVENT_FAR, cause, v->near_id);
        v->near_id = 0;
    }
    if (!watch_id(v)) watch_drop(w, id);
}

typedef struct terms { /* under which a pair is judged in this tick */
    pair_terms distances;
    uint8_t cause; /* of what begins or ends */
} terms;

static terms terms_of(const world *w, const pair *p, const body *a, const body *b)
{
    bool ruled = a->ruled_tick == w->figures.ticks || b->ruled_tick == w->figures.ticks;
    return (terms){pair_kept_terms(p), ruled ? CAUSE_FILTER : CAUSE_MOTION};
}

uint8_t events_achieved(const narrow_result *r, const outcome *o, double limit)
{
    if (o->left) return WORLD_STOPPED;
    if (r->status == NARROW_WIDE) return WORLD_WIDE;
    return r->lo > limit || r->hi <= limit ? WORLD_CERTAIN : WORLD_WITHIN;
}

static void tell(world *w, uint32_t pair_id, const outcome *o, uint32_t interest_id, const terms *t)
{
    const narrow_result *r = &w->results.at[o->result];
    const pair *p = &w->pairs.at[pair_id];
    const interest *i = &w->interests.at[interest_id];
    double threshold = i->threshold + t->distances.padding, range = i->range + t->distances.margin;
    uint32_t id = watch_find(w, p, interest_id);
    if (id != WORLD_NONE && w->watches.at[id].touch_id) threshold += i->hysteresis;
    if (id != WORLD_NONE && w->watches.at[id].near_id) range += i->hysteresis;
    bool touches = i->facts & (WORLD_TOUCH | WORLD_MANIFOLD) && r->lo <= threshold;
    bool near = i->facts & WORLD_DISTANCE && r->lo <= range;
    if (id == WORLD_NONE && !touches && !near) return;
    if (id == WORLD_NONE) id = watch_add(w, pair_id, interest_id);
    watch *v = &w->watches.at[id];
    world_event now;
    events_fill(w, p, r, interest_id, t->distances.looks, &now);
    now.achieved = events_achieved(r, o, touches || !(i->facts & WORLD_DISTANCE) ? threshold : range);
    if (!(i->facts & WORLD_MANIFOLD) || !touches) now.manifold.count = 0;
    bool news = v->recovered || !(v->touch_id || v->near_id) || !news_same_facts(&v->last, &now);
    v->recovered = false;
    v->last = now;
    transit(w, id, touches, near, news, t->cause);
}

void events_of_active(world *w)
{
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        if (w->outcomes.at[k].result == WORLD_NONE) continue;
        uint32_t id = w->active_pairs.at[k];
        const pair *p = &w->pairs.at[id];
        const body *a = &w->bodies.at[w->solids.at[p->a].body], *b = &w->bodies.at[w->solids.at[p->b].body];
        terms t = terms_of(w, p, a, b);
        for (size_t word = 0; word < w->words; word++)
            for (uint64_t bits = interest_word(a, b, word); bits; bits &= bits - 1)
                tell(w, id, &w->outcomes.at[k], (uint32_t)(word * 64) + (uint32_t)__builtin_ctzll(bits), &t);
    }
}

/* ---- stale bodies ---- */

static void emit_whole_body(world *w, uint32_t body_id, uint32_t interest, uint8_t kind, uint8_t cause)
{
    const body *b = &w->bodies.at[body_id];
    world_event e = {.name_a = b->name,
        .name_b = "*",
        .shape_a = -1,
        .shape_b = -1,
        .achieved = WORLD_WIDE,
        .lo = -INFINITY,
        .hi = INFINITY,
        .age_a_ns = body_age_ns(w, b),
        .age_b_ns = -1};
    events_emit(w, interest, &e, kind, cause, 0);
}

static void tell_whole_body(world *w, uint32_t body_id, uint8_t kind, uint8_t cause)
{
    const body *b = &w->bodies.at[body_id];
    for (size_t word = 0; word < w->words; word++)
        for (uint64_t bits = b->match_a[word] | b->match_b[word]; bits; bits &= bits - 1)
            emit_whole_body(w, body_id, (uint32_t)(word * 64) + (uint32_t)__builtin_ctzll(bits), kind, cause);
}

typedef struct pair_list {
    const world *w;
    uint32_t proxy;
    ARRAY(uint32_t) pairs;
} pair_list;

static void list_pair(void *context, uint32_t other)
{
    pair_list *l = context;
    uint32_t id = pair_find(l->w, l->proxy, other);
    if (id != PAIR_MAP_NONE && l->w->pairs.at[id].first_watch != WORLD_NONE) array_push(&l->pairs, id);
}

static int compare_u32(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static void tell_watches_unknown(world *w, uint32_t solid_id)
{
    pair_list list = {.w = w, .proxy = solid_id};
    broad_each_pair_of(w->broad, solid_id, list_pair, &list);
    if (list.pairs.count) qsort(list.pairs.at, list.pairs.count, sizeof *list.pairs.at, compare_u32);
    for (size_t i = 0; i < list.pairs.count; i++) {
        for (uint32_t id = w->pairs.at[list.pairs.at[i]].first_watch; id != WORLD_NONE;
             id = w->watches.at[id].pair_next) {
            watch *v = &w->watches.at[id];
            if (v->unknown) continue;
            v->unknown = true;
            events_emit(w, v->interest, watch_last(v), EVENT_UNKNOWN, CAUSE_STALE, watch_id(v));
        }
    }
    array_free(&list.pairs);
}

/* What they were to each other ends where they were. */
void events_teleported(world *w)
{
    if (w->teleported.count) qsort(w->teleported.at, w->teleported.count, sizeof *w->teleported.at, compare_u32);
    for (size_t i = 0; i < w->teleported.count; i++) {
        const body *b = &w->bodies.at[w->teleported.at[i]];
        if (!b->used || b->ghost || !b->teleported) continue;
        for (size_t k = 0; k < b->shape_count; k++) {
            pair_list list = {.w = w, .proxy = b->shapes[k]};
            broad_each_pair_of(w->broad, b->shapes[k], list_pair, &list);
            if (list.pairs.count) qsort(list.pairs.at, list.pairs.count, sizeof *list.pairs.at, compare_u32);
            for (size_t n = 0; n < list.pairs.count; n++) events_pair_ended(w, list.pairs.at[n], CAUSE_TELEPORT);
            array_free(&list.pairs);
        }
    }
    w->teleported.count = 0;
}

void events_unknown(world *w)
{
    for (size_t i = 0; i < w->stale_now.count; i++) {
        const body *b = &w->bodies.at[w->stale_now.at[i]];
        tell_whole_body(w, w->stale_now.at[i], EVENT_UNKNOWN, CAUSE_STALE);
        for (size_t k = 0; k < b->shape_count; k++) tell_watches_unknown(w, b->shapes[k]);
    }
}

/* A stale body that was removed is not unknown any more either: it is gone. */
void events_known(world *w)
{
    for (size_t i = 0; i < w->fresh_now.count; i++) tell_whole_body(w, w->fresh_now.at[i], EVENT_KNOWN, CAUSE_MOTION);
    for (size_t i = 0; i < w->reap.count; i++) {
        const body *b = &w->bodies.at[w->reap.at[i]];
        if (b->stale) tell_whole_body(w, w->reap.at[i], EVENT_KNOWN, b->ghost_cause);
    }
}

/* ---- updates that the rate held back, snapshots, closing ---- */

static void refresh_ages(const world *w, const watch *v, world_event *e)
{
    const pair *p = &w->pairs.at[v->pair];
    const body *a = &w->bodies.at[w->solids.at[p->a].body], *b = &w->bodies.at[w->solids.at[p->b].body];
    bool turned = strcmp(e->name_a, a->name) != 0;
    e->age_a_ns = body_age_ns(w, turned ? b : a);
    e->age_b_ns = body_age_ns(w, turned ? a : b);
}

static void release_held(world *w, uint32_t interest_id)
{
    interest *i = &w->interests.at[interest_id];
    for (size_t k = 0; k < i->held.count; k++) {
        watch *v = &w->watches.at[i->held.at[k]];
        if (!is_held_back(w, i->held.at[k], interest_id)) continue;
        bool dirty = v->dirty, foretold = v->foretold_dirty;
        v->dirty = v->foretold_dirty = false;
        if (v->unknown) continue;
        if (foretold) {
            refresh_ages(w, v, &v->foretold);
            events_emit(w, interest_id, &v->foretold, EVENT_FORETOLD, CAUSE_MOTION, v->foretold_id);
        }
        if (!dirty || !(v->touch_id || v->near_id)) continue; /* what was held back has ended */
        refresh_ages(w, v, &v->last);
        if (v->touch_id)
            events_emit(w, interest_id, &v->last, EVENT_UPDATE, CAUSE_MOTION, v->touch_id);
        else
            events_emit(w, interest_id, &v->last, EVENT_NEAR, CAUSE_MOTION, v->near_id);
    }
    i->held.count = 0;
}

void events_held_back(world *w)
{
    for (uint32_t id = 0; id < w->interests.count; id++) {
        interest *i = &w->interests.at[id];
        if (!i->used || !i->period_ns || !events_may_update(w, i)) continue;
        release_held(w, id);
        if (i->events.count) i->next_update_ns = w->now_ns + i->period_ns;
    }
}

static int compare_events(const void *a, const void *b)
{
    const world_event *x = a, *y = b;
    return (x->contact > y->contact) - (x->contact < y->contact);
}

/* Everything that is, as if it began now, in a batch of its own behind the events of this tick: who was in step needs
 * those, who was not needs only this. */
static void snapshot(world *w, uint32_t id)
{
    interest *i = &w->interests.at[id];
    size_t kept = i->snapshot_first = i->events.count;
    for (uint32_t v = i->first_watch; v != WORLD_NONE; v = w->watches.at[v].interest_next) {
        const watch *at = &w->watches.at[v];
        world_event now =
            *watch_last(at); /* a copy: what later events tell may not depend on who asked for a snapshot */
        refresh_ages(w, at, &now);
        if (at->touch_id) events_emit(w, id, &now, EVENT_BEGIN, CAUSE_SNAPSHOT, at->touch_id);
        if (at->near_id) events_emit(w, id, &now, EVENT_NEAR, CAUSE_SNAPSHOT, at->near_id);
        if (!at->foretold_id) continue;
        now = at->foretold;
        refresh_ages(w, at, &now);
        events_emit(w, id, &now, EVENT_FORETOLD, CAUSE_SNAPSHOT, at->foretold_id);
    }
    i = &w->interests.at[id];
    if (i->events.count > kept)
        qsort(i->events.at + kept, i->events.count - kept, sizeof *i->events.at, compare_events);
    for (uint32_t v = i->first_watch; v != WORLD_NONE; v = w->watches.at[v].interest_next) {
        const watch *at = &w->watches.at[v];
        if (at->unknown) events_emit(w, id, watch_last(at), EVENT_UNKNOWN, CAUSE_SNAPSHOT, watch_id(at));
    }
    if (!w->figures.stale_bodies) return;
    uint64_t mask = (uint64_t)1 << (id & 63);
    for (uint32_t b = 0; b < w->bodies.count; b++) {
        const body *at = &w->bodies.at[b];
        if (at->used && !at->ghost && at->stale && (at->match_a[id >> 6] | at->match_b[id >> 6]) & mask)
            emit_whole_body(w, b, id, EVENT_UNKNOWN, CAUSE_SNAPSHOT);
    }
}

void events_snapshots(world *w)
{
    for (uint32_t id = 0; id < w->interests.count; id++)
        if (w->interests.at[id].used && w->interests.at[id].snapshot && !w->interests.at[id].closing) snapshot(w, id);
}

typedef struct told {
    int64_t id;
    uint32_t watch;
} told;

static int compare_told(const void *a, const void *b)
{
    int64_t x = ((const told *)a)->id, y = ((const told *)b)->id;
    return (x > y) - (x < y);
}

/* Ends all that the interest was told, in the order of contact ids. */
void events_close(world *w, uint32_t id, uint8_t cause)
{
    ARRAY(told) order = {0};
    for (uint32_t v = w->interests.at[id].first_watch; v != WORLD_NONE; v = w->watches.at[v].interest_next) {
        const watch *at = &w->watches.at[v];
        array_push(&order, ((told){watch_id(at), v}));
    }
    if (order.count) qsort(order.at, order.count, sizeof *order.at, compare_told);
    for (size_t i = 0; i < order.count; i++) end_watch(w, order.at[i].watch, cause);
    w->interests.at[id].held.count = 0; /* of watches that are gone: nothing is due for them */
    array_free(&order);
}

void events_collect(world *w, world_batches *out)
{
    w->batches.count = 0;
    for (uint32_t id = 0; id < w->interests.count; id++) {
        interest *i = &w->interests.at[id];
        i->undone += w->figures.pairs_left_out;
        bool more_or_less = i->undone != i->told; /* left undone than was told last */
        if (!i->used || !(i->events.count || i->snapshot || i->closing || more_or_less)) continue;
        bool told = i->snapshot && !i->closing;
        size_t news = told ? i->snapshot_first : i->events.count;
        i->told = i->undone;
        if (news || i->closing || more_or_less)
            array_push(&w->batches, ((world_batch){.interest = id,
                                        .closing = i->closing,
                                        .undone = i->undone,
                                        .events = i->events.at,
                                        .count = news}));
        if (told)
            array_push(&w->batches, ((world_batch){.interest = id,
                                        .snapshot = true,
                                        .undone = i->undone,
                                        .events = i->events.at ? i->events.at + news : NULL,
                                        .count = i->events.count - news}));
        i->snapshot = false;
    }
    *out = (world_batches){.at = w->batches.at, .count = w->batches.count, .hash = w->hash};
}
