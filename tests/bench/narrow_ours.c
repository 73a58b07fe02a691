/* narrow_ours: our narrow phase, as the world uses it: shapes in canonical order, the relative pose from two world
 * poses, one query. Timed is all of that but the order, which a pair has for good. */
#include "narrow_scene.h"

#include "narrow/narrow.h"

#include <stdlib.h>

typedef struct ours_item {
    shape a, b;
    pose at_a, at_b;
    double reach_b;
    bool begins;
} ours_item;

typedef struct ours {
    ours_item *items;
    narrow_request request;
    narrow_scratch *scratch;
    narrow_cache cache;
    narrow_shell shell;
} ours;

static void *create_asking(const narrow_item *items, size_t count, double tolerance)
{
    ours *o = calloc(1, sizeof *o);
    ours_item *own = calloc(count, sizeof *own);
    narrow_scratch *scratch = aligned_alloc(64, narrow_scratch_size());
    if (!o || !own || !scratch) abort();
    o->items = own;
    o->scratch = scratch;
    o->request = (narrow_request){.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    for (size_t i = 0; i < count; i++) {
        shape a = narrow_scene_shape(items[i].a), b = narrow_scene_shape(items[i].b);
        pose at_a = narrow_scene_pose(&items[i].at_a), at_b = narrow_scene_pose(&items[i].at_b);
        bool ordered = narrow_ordered(&a, 0, &b, 1);
        own[i] = ordered ? (ours_item){a, b, at_a, at_b, shape_reach(&b), items[i].begins}
                         : (ours_item){b, a, at_b, at_a, shape_reach(&a), items[i].begins};
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

static void query(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        pose b_in_a = pose_relative(it->at_a, it->at_b);
        narrow_result r;
        narrow_query(&it->a, &it->b, &b_in_a, &o->request, NULL, o->scratch, &r);
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

/* The rungs that the world climbs before it asks in full: the way moved since the last proof, and the last axis. */
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

/* The full query each time, helped by what it left behind: the same answers as without. */
static void query_again(void *self, size_t first, size_t count, narrow_answer *out)
{
    ours *o = self;
    for (size_t i = first; i < first + count; i++, out++) {
        const ours_item *it = &o->items[i];
        pose b_in_a = pose_relative(it->at_a, it->at_b);
        if (it->begins) o->cache = (narrow_cache){.shell = &o->shell};
        narrow_result r;
        narrow_query(&it->a, &it->b, &b_in_a, &o->request, &o->cache, o->scratch, &r);
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
    "collided", "tolerance 1e-9 m; of curved pairs 1e-6 m", true, takes_all, create, query, destroy};
const narrow_peer narrow_ours_finest = {
    "collided_finest", "tolerance 0, from world poses", true, takes_all, create_finest, query_world, destroy};
const narrow_peer narrow_ours_cached = {"collided_cached",
    "motion bound, cached axis, then the full query: proves the "
    "gap, measures it only where that fails",
    true, takes_coherent_gaps, create, query_cached, destroy};
const narrow_peer narrow_ours_again = {"collided_again",
    "the full query, with the cache of the frame before: the same bits", true, takes_coherent, create, query_again,
    destroy};
