/* past: motions of ticks that are over, kept as long as a slice keeps pairs waiting that may have met on them.
 *
 * A body that is due, or has left a pair to another that is, keeps how it went in each tick until all of its pairs have
 * been decided; its box holds all of that, so that whoever crossed one of these motions is found, however late. A pair
 * is then searched tick by tick, from the one in which it was decided last on, each as it would have been then: what is
 * told is what a world that is not cut tells, only later. Where one of the two has kept nothing it stood, or all that
 * it met before has been decided.
 *
 * Of a body that waits for very long the oldest motions are dropped; each subscription in its impacts is told so: it
 * may have met anything. All of it follows from counts. Tick thread, but for past_body. */
#include "base/sort.h"
#include "events.h"
#include "match.h"

#include <stdlib.h>

enum {
    PAST_MOTIONS_MOST = 16,          /* of a body; as a tick brings one, so many ticks */
    ALL_PAST_MOTIONS_MOST = 1 << 18, /* of all bodies: some 80 MB */
};

/* ---- what is kept ---- */

static uint64_t later(uint64_t a, uint64_t b)
{
    return a > b ? a : b;
}

static void free_past_motions(world *w, body *b)
{
    for (size_t i = 0; i < b->past.count; i++) free(b->past.at[i].passed);
    w->past_motions -= b->past.count;
    array_free(&b->past);
}

/* Of all its motions up to this tick: it may have met anything since the first of them. */
static void report_dropped(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    match_list all = match_of_class(&w->match, b->match);
    const past_motion *first = b->past.count ? &b->past.at[0] : NULL;
    world_event e = events_of_body(w, id);
    b->past_reported = w->figures.ticks;
    w->figures.dropped_motions++;
    e.impact = (world_impact){.lo = 0,
        .hi = INFINITY,
        .start_ns = first ? past_start_ns(first) : w->last_tick_ns,
        .pose_a = first ? first->from : b->pose,
        .pose_b = POSE_IDENTITY};
    for (uint32_t k = 0; k < all.count; k++)
        if (w->subscriptions.at[all.at[k]].facts & WORLD_IMPACT)
            events_emit(w, all.at[k], &e, EVENT_IMPACT, CAUSE_MOTION, 0);
}

static void drop_oldest(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (b->past.at[0].tick > b->past_reported) report_dropped(w, id);
    free(b->past.at[0].passed);
    b->past_since = b->past.at[0].tick;
    memmove(b->past.at, b->past.at + 1, --b->past.count * sizeof *b->past.at);
    w->past_motions--;
}

static void list(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (!b->past_listed) array_push(&w->past_bodies, id);
    b->past_listed = true;
}

/* Most bodies wait for a tick or two: room for eight each, as arrays begin, of all bodies of a step would be memory
 * that nobody uses. */
static void push_motion(body *b, const past_motion *swept)
{
    if (b->past.count == b->past.capacity) {
        b->past.capacity = b->past.capacity ? 2 * b->past.capacity : 1;
        b->past.at = base_realloc(b->past.at, b->past.capacity, sizeof *b->past.at);
    }
    b->past.at[b->past.count++] = *swept;
}

static void add_past_motion(world *w, uint32_t id, const past_motion *swept)
{
    body *b = &w->bodies.at[id];
    list(w, id);
    if (b->past.count && (b->past.count == PAST_MOTIONS_MOST || w->past_motions >= ALL_PAST_MOTIONS_MOST))
        drop_oldest(w, id);
    push_motion(b, swept);
    w->past_motions++;
}

static aabb box_of_swept_motion(const world *w, const body *b)
{
    aabb box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t k = 0; k < b->shape_count; k++) {
        const collider *s = &w->colliders.at[b->shapes[k]];
        box = aabb_union(box, body_motion_bounds(w, b, s, s->box));
    }
    return box;
}

static void keep_past_motion(world *w, uint32_t id)
{
    const body *b = &w->bodies.at[id];
    pose from = body_before(b);
    past_motion swept = {.tick = w->figures.ticks,
        .from = from,
        .to = b->pose,
        .from_ns = b->moved ? b->before_ns : b->stamp_ns,
        .to_ns = b->stamp_ns,
        .span_ns = body_span_ns(w, b),
        .now_ns = w->now_ns,
        .angular = b->angular,
        .box = box_of_swept_motion(w, b),
        .moved = b->moved,
        .speed = b->speed};
    if (b->moved && b->passed.count) {
        swept.passed_count = b->passed.count;
        swept.passed = base_alloc(b->passed.count, sizeof *swept.passed);
        memcpy(swept.passed, b->passed.at, b->passed.count * sizeof *swept.passed);
    }
    add_past_motion(w, id, &swept);
}

/* All of its pairs have been decided as they are in this tick, or are wanted no more. */
static bool is_waited_for(const world *w, const body *b)
{
    return b->used && !b->ghost && b->impacts && (b->is_due || b->left_tick > w->past_clear || b->swept_left);
}

static void keep_or_not(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (is_waited_for(w, b))
        keep_past_motion(w, id);
    else
        b->past_since = w->figures.ticks;
}

/* Of all that moved, in the order of their ids: which of them had been calm is not the same everywhere. */
static void keep_past_motions(world *w)
{
    size_t count = w->dirty.count + w->glided.count;
    array_reserve(&w->active, count);
    array_reserve(&w->sort_scratch, count);
    uint64_t *ids = w->active.at;
    for (size_t i = 0; i < w->dirty.count; i++) ids[i] = w->dirty.at[i];
    for (size_t i = 0; i < w->glided.count; i++) ids[w->dirty.count + i] = w->glided.at[i];
    sort_keys(ids, w->sort_scratch.at, count);
    for (size_t i = 0; i < count; i++)
        if (!i || ids[i] != ids[i - 1]) keep_or_not(w, (uint32_t)ids[i]);
}

/* Nobody can say yet who wants it. */
static bool is_unknown(const body *b)
{
    return b->used && !b->ghost && !b->matched;
}

static void lose_unknown(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (!is_unknown(b) || !(b->moved || b->leaving)) return;
    b->past_lost = true;
    list(w, id);
}

/* What is removed, or has got other shapes, before it was looked at may have met anything, too. */
static void report_lost(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (b->used && b->past_lost) report_dropped(w, id);
    b->past_lost = false;
}

/* The tick up to which all of its pairs are: one that was waited for because of searches has not been looked at since
 * it was gathered, and may have stood where others, which are still due, have gone in the meantime. */
static uint64_t decided_of(const world *w, const body *b)
{
    bool since_then = b->used && !b->ghost && b->impacts && b->gathered_tick && w->due;
    return since_then ? later(b->gathered_tick, b->past_since) : w->figures.ticks;
}

/* False: it stays on the list until it can be reported. */
static bool forget(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    bool stays = is_unknown(b) && b->past_lost;
    if (!stays) report_lost(w, id);
    free_past_motions(w, b);
    b->past_listed = stays;
    b->past_since = decided_of(w, b);
    return !stays;
}

static int compare_ids(const void *x, const void *y)
{
    uint32_t a = *(const uint32_t *)x, b = *(const uint32_t *)y;
    return (a > b) - (a < b);
}

static bool is_in_order(const world *w)
{
    for (size_t i = 1; i < w->past_bodies.count; i++)
        if (w->past_bodies.at[i - 1] > w->past_bodies.at[i]) return false;
    return true;
}

/* But for those that are `waited` for. In the order of their ids, whichever way they came onto the list: some of them
 * are told. */
static void forget_others(world *w, bool waited)
{
    size_t kept = 0;
    if (!is_in_order(w)) qsort(w->past_bodies.at, w->past_bodies.count, sizeof *w->past_bodies.at, compare_ids);
    for (size_t i = 0; i < w->past_bodies.count; i++) {
        uint32_t id = w->past_bodies.at[i];
        bool stays = waited && is_waited_for(w, &w->bodies.at[id]);
        if (stays && w->bodies.at[id].matched) report_lost(w, id);
        if (stays || !forget(w, id)) w->past_bodies.at[kept++] = id;
    }
    w->past_bodies.count = kept;
}

void past_keep(world *w)
{
    bool wanted = w->sweepers && w->ccds;
    for (size_t i = 0; i < w->dirty.count && wanted && (w->match.unmatched.count || w->leaving.count); i++)
        lose_unknown(w, (uint32_t)w->dirty.at[i]);
    if (!(w->due || w->searching) || !wanted) {
        forget_others(w, false);
        w->past_clear = w->figures.ticks;
        return;
    }
    keep_past_motions(w);
    forget_others(w, true);
}

void past_stands(world *w, uint32_t id)
{
    const body *b = &w->bodies.at[id];
    if (!w->past_bodies.count || b->past.count || !b->impacts || b->past_since >= w->figures.ticks) return;
    body stood = *b;
    stood.pose = body_before(b);
    stood.moved = false;
    past_motion swept = {.tick = w->figures.ticks,
        .from = stood.pose,
        .to = stood.pose,
        .from_ns = b->stamp_ns,
        .to_ns = b->stamp_ns,
        .now_ns = w->now_ns,
        .box = box_of_swept_motion(w, &stood)};
    add_past_motion(w, id, &swept);
}

void past_reshape(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (!w->past_bodies.count || !b->impacts) return;
    b->past_lost = true; /* which the next tick tells */
    list(w, id);
    free_past_motions(w, b);
    b->past_since = w->figures.ticks;
}

aabb past_bounds(const body *b, aabb box)
{
    for (size_t i = 0; i < b->past.count; i++) box = aabb_union(box, b->past.at[i].box);
    return box;
}

/* ---- what a pair is searched for ---- */

uint64_t past_decided(const world *w, const pair *p, const body *a, const body *b)
{
    return later(later(w->past_clear, pair_more_of(w, p)->swept_tick), later(a->past_since, b->past_since));
}

static uint64_t next_of(const body *b, uint64_t after)
{
    for (size_t i = 0; i < b->past.count; i++)
        if (b->past.at[i].tick > after) return b->past.at[i].tick;
    return UINT64_MAX;
}

uint64_t past_next(const body *a, const body *b, uint64_t after)
{
    uint64_t x = next_of(a, after), y = next_of(b, after);
    return x < y ? x : y;
}

static size_t first_behind(const body *b, uint64_t tick)
{
    size_t i = b->past.count;
    while (i && b->past.at[i - 1].tick > tick) i--;
    return i;
}

size_t past_waiting(const world *w, const pair *p, const body *a, const body *b)
{
    if (!a->past.count && !b->past.count) return 0;
    uint64_t decided = past_decided(w, p, a, b);
    size_t i = first_behind(a, decided), k = first_behind(b, decided), count = 0;
    for (; i < a->past.count || k < b->past.count; count++) {
        uint64_t x = i < a->past.count ? a->past.at[i].tick : UINT64_MAX;
        uint64_t y = k < b->past.count ? b->past.at[k].tick : UINT64_MAX;
        i += x <= y;
        k += y <= x;
    }
    return count;
}

const body *past_body(const world *w, const body *b, uint64_t tick, body *out)
{
    if (tick == w->figures.ticks) return b;
    size_t i = b->past.count;
    while (i && b->past.at[i - 1].tick > tick) i--;
    *out = *b;
    out->passed.at = NULL;
    out->passed.count = out->passed.capacity = 0;
    out->moved = false;
    out->as_of = i ? &b->past.at[i - 1] : NULL;
    if (!i) { /* it stood, where its first motion begins */
        out->pose = b->past.count ? b->past.at[0].from : body_before(b);
        out->stamp_ns = b->past.count ? b->past.at[0].from_ns : b->moved ? b->before_ns : b->stamp_ns;
        return out;
    }
    const past_motion *p = out->as_of;
    out->pose = p->to;
    out->stamp_ns = p->to_ns;
    if (p->tick != tick || !p->moved) return out;
    out->moved = true;
    out->before = p->from;
    out->before_ns = p->from_ns;
    out->angular = p->angular;
    out->speed = p->speed;
    out->passed.at = p->passed;
    out->passed.count = out->passed.capacity = p->passed_count;
    return out;
}

bool past_apart(const body *a, const body *b, double by)
{
    if (!a->as_of || !b->as_of) return false;
    aabb x = aabb_grow(a->as_of->box, by * (1 + 0x1p-40));
    const aabb *y = &b->as_of->box;
    bool meet = x.lo.x <= y->hi.x && y->lo.x <= x.hi.x && x.lo.y <= y->hi.y && y->lo.y <= x.hi.y && x.lo.z <= y->hi.z &&
                y->lo.z <= x.hi.z;
    return !meet;
}

/* ---- saved ---- */

void past_save(const body *b, bytes_out *to)
{
    bytes_put_count(to, b->past.count);
    for (size_t i = 0; i < b->past.count; i++) {
        past_motion bare = b->past.at[i];
        bare.passed = NULL;
        bytes_put(to, &bare, sizeof bare);
        bytes_put(to, b->past.at[i].passed, bare.passed_count * sizeof *bare.passed);
    }
}

bool past_restore(world *w, uint32_t id, bytes_in *from)
{
    body *b = &w->bodies.at[id];
    size_t count = bytes_get_count(from, sizeof(past_motion));
    if (b->past_listed) array_push(&w->past_bodies, id);
    for (size_t i = 0; i < count; i++) {
        past_motion swept;
        if (!bytes_get(from, &swept, sizeof swept) || swept.passed_count > WAYPOINTS_MAX) return false;
        swept.passed = swept.passed_count ? base_alloc(swept.passed_count, sizeof *swept.passed) : NULL;
        bytes_get(from, swept.passed, swept.passed_count * sizeof *swept.passed);
        add_past_motion(w, id, &swept);
    }
    return !from->broken;
}
