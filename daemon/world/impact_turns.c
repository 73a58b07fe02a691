/* impact_turns: which searches a tick makes, where a slice bounds what they may take. In batches, each of as many as
 * may take a share of the slice at the most; when what they have taken in truth is as much as there is room for, the
 * others are put off (impact_wait.c). All of it is counted (queries, steps and work, not time), and a batch does not
 * depend on who computes it. Tick thread.
 *
 * A search of shapes of parts may take long, and how long is not known before. It is allowed what the pair's last ones
 * took, several times over; one that comes near to that is made again with more, up to what a tick may spend on one.
 * What is within an eighth of what it was allowed has the same answer as with any greater allowance (toi_walk.c divides
 * it into no smaller parts): so a slice changes no answer but of those that take more than an eighth of the most; and
 * such a tick counts as cut. */
#include "state.h"

#include "base/sort.h"
#include "geom/hull.h"
#include "toi/toi.h"

enum {
    A_SEARCH = 4000, /* units: of convex shapes, as long as nothing is known of it */
    A_BEGIN = 500,   /* of any, ... */
    A_STEP = 100,    /* ... for each step, ... */
    A_QUERY = 300,   /* ... and each distance, besides what the shapes add */
    A_HULL = 350,
    A_VERTEX = 3,
    A_WORK = 17,          /* of TOI_WORK_MAX */
    A_DECISION = 300,     /* of a pair, on the average */
    QUERIES_MOST = 540,   /* of convex shapes, and ... */
    STEPS_MOST = 2000,    /* ... */
    WORK_MOST = 1 << 19,  /* of TOI_WORK_MAX: what one search may take in a slice, about 9 ms; ... */
    WORK_LEAST = 1 << 13, /* ... is allowed at first */
    WITHIN = 8,           /* see above */
    BATCHES = 2,          /* of a slice: one of them at the most, ... */
    PART = 4              /* ... all searches at the least */
};

static pair *pair_of(const world *w, const sweep *s)
{
    return &w->pairs.at[w->active_pairs.at[s->active]];
}

static bool has_parts(const world *w, const pair *p)
{
    return toi_parts_apply(&w->colliders.at[p->a].shape, &w->colliders.at[p->b].shape);
}

/* The first sweep behind those of the same pair. */
static size_t end_of_pair(const world *w, size_t k)
{
    uint32_t active = w->sweeps.at[k].active;
    while (k < w->sweeps.count && w->sweeps.at[k].active == active) k++;
    return k;
}

/* ---- units ---- */

/* A shape in a distance of two that are searched as wholes: a half-space sees of a mesh its convex hull. */
static uint64_t part_in_query(const collider *s)
{
    if (s->shape.type == SHAPE_MESH) return A_HULL + A_VERTEX * (uint64_t)s->shape.hull->vertex_count;
    return (uint64_t)s->apart;
}

static uint64_t query_of(const world *w, const pair *p)
{
    return A_QUERY + part_in_query(&w->colliders.at[p->a]) + part_in_query(&w->colliders.at[p->b]);
}

static uint64_t units_of(const world *w, const sweep *s)
{
    const toi_result *r = &s->result;
    if (r->work) return A_BEGIN + A_WORK * (uint64_t)r->work;
    return A_BEGIN + query_of(w, pair_of(w, s)) * s->queries + A_STEP * (uint64_t)s->steps;
}

static const uint64_t DEAREST = A_BEGIN + (uint64_t)A_WORK * WORK_MOST; /* units: a search of parts */

/* Of one search, by the last one; of parts of which nothing is known yet, by their price. */
static uint64_t expected_of(const world *w, const pair *p)
{
    const collider *a = &w->colliders.at[p->a], *b = &w->colliders.at[p->b];
    const uint32_t last = pair_more_of(w, p)->search_units;
    if (last) return last;
    uint64_t price = A_SEARCH + (has_parts(w, p) ? 4 * (uint64_t)((double)a->apart + b->apart) : 0);
    return price < DEAREST ? price : DEAREST;
}

uint64_t impact_units(const world *w, const pair *p)
{
    const body *x = &w->bodies.at[w->colliders.at[p->a].body], *y = &w->bodies.at[w->colliders.at[p->b].body];
    bool swept_motions = x->impacts && y->impacts, predicted_motions = x->horizon > 0 && y->horizon > 0;
    if (!w->sweepers || !(swept_motions || predicted_motions)) return 0;
    uint64_t searches = 1 + (swept_motions && w->past_bodies.count ? past_waiting(w, p, x, y) : 0);
    return searches * expected_of(w, p);
}

/* What the searches of this tick may take: what the pairs that are decided leave of its slice. By their number, which
 * is the same everywhere: what slices.c counts is not to the last unit, since it depends on who is calm. */
static uint64_t room_of(const world *w)
{
    uint64_t rest = A_DECISION * (uint64_t)w->active_pairs.count, left = w->slice > rest ? w->slice - rest : 0;
    return left > w->slice / PART ? left : w->slice / PART;
}

/* In place of what they were expected to take. */
static void count_units(world *w, uint64_t expected, uint64_t spent)
{
    uint64_t all = w->figures.slice_units;
    w->figures.slice_units = (all > expected ? all - expected : 0) + spent;
}

/* ---- the order ---- */

static uint32_t allowed_at_first(const world *w, const pair *p)
{
    uint64_t last = pair_more_of(w, p)->search_units / A_WORK, allowed = WORK_LEAST;
    while (allowed < WORK_MOST && allowed < WITHIN * last) allowed *= WITHIN;
    return (uint32_t)(allowed < WORK_MOST ? allowed : WORK_MOST);
}

static void allow(sweep *s, uint32_t work)
{
    s->spent = TOI_WORK_MAX - work;
    s->most = A_BEGIN + A_WORK * (uint64_t)work;
}

typedef struct total { /* units, of all */
    uint64_t most, expected;
} total;

static total allow_all(world *w)
{
    total t = {0};
    for (size_t k = 0, end; k < w->sweeps.count; k = end) {
        const pair *p = pair_of(w, &w->sweeps.at[k]);
        bool parts = has_parts(w, p);
        uint64_t expected = expected_of(w, p), most = A_BEGIN + QUERIES_MOST * query_of(w, p) + STEPS_MOST * A_STEP;
        end = end_of_pair(w, k);
        for (size_t i = k; i < end; i++) {
            sweep *s = &w->sweeps.at[i];
            s->most = most;
            if (parts) allow(s, allowed_at_first(w, p));
            if (s->again) continue;
            t.most += s->most;
            t.expected += expected;
        }
    }
    return t;
}

static void order_as_they_are(world *w)
{
    array_reserve(&w->sweep_order, w->sweeps.count);
    w->sweep_order.count = 0;
    for (size_t k = 0; k < w->sweeps.count; k++)
        if (!w->sweeps.at[k].again) w->sweep_order.at[w->sweep_order.count++] = (uint32_t)k;
}

/* Each list of owners gets as much as the others, and of its own those that have waited go first. */
static void order_by_turns(world *w)
{
    uint64_t before[SEARCH_LISTS] = {0};
    size_t count = 0;
    array_reserve(&w->sweep_keys, w->sweeps.count);
    array_reserve(&w->sort_scratch, w->sweeps.count);
    for (int fresh = 0; fresh < 2; fresh++) {
        for (size_t k = 0, end; k < w->sweeps.count; k = end) {
            const pair *p = pair_of(w, &w->sweeps.at[k]);
            uint64_t expected = expected_of(w, p), *own = &before[impact_list_of(w, p)];
            end = end_of_pair(w, k);
            if (p->search_waits == fresh) continue;
            for (size_t i = k; i < end; i++) {
                if (w->sweeps.at[i].again) continue;
                uint64_t place = *own >> 10 < UINT32_MAX ? *own >> 10 : UINT32_MAX;
                w->sweep_keys.at[count++] = place << 32 | i;
                *own += expected;
            }
        }
    }
    sort_keys(w->sweep_keys.at, w->sort_scratch.at, count);
    for (size_t i = 0; i < count; i++) w->sweep_order.at[i] = (uint32_t)w->sweep_keys.at[i];
    w->sweep_order.count = count;
}

/* ---- batches ---- */

/* The place behind those that are searched next: one at least. */
static size_t end_of_batch(const world *w, size_t from, uint64_t units)
{
    uint64_t most = 0;
    size_t to = from;
    while (to < w->sweep_order.count) {
        most += w->sweeps.at[w->sweep_order.at[to]].most;
        if (to > from && most > units) break;
        to++;
    }
    return to;
}

/* With what it was allowed, is the answer the same as with more, or is there no more? */
static bool is_enough(world *w, sweep *s)
{
    uint32_t allowed = TOI_WORK_MAX - s->spent;
    if (s->result.work <= allowed / WITHIN) return true;
    if (allowed < WORK_MOST) {
        allow(s, allowed < WORK_MOST / WITHIN ? allowed * WITHIN : WORK_MOST);
        return false;
    }
    w->sliced = true;
    return true;
}

/* Those that need more come last, in their order; returns the first of them. */
static size_t settle_batch(world *w, size_t from, size_t to, uint64_t *spent)
{
    uint32_t *order = w->sweep_order.at;
    size_t done = from;
    w->search_again.count = 0;
    for (size_t i = from; i < to; i++) {
        sweep *s = &w->sweeps.at[order[i]];
        *spent += units_of(w, s);
        s->tried = true;
        s->done = is_enough(w, s);
        if (!s->done) array_push(&w->search_again, order[i]);
        if (s->done) order[done++] = order[i];
    }
    for (size_t i = 0; i < w->search_again.count; i++) order[done + i] = w->search_again.at[i];
    return done;
}

/* ---- all of it ---- */

/* What was dear is believed to be so for a while. In the order of the searches, and of each that is done what it takes
 * without a slice: a tick that is not cut leaves the same behind with one and without. */
static void learn(world *w)
{
    for (size_t k = 0; k < w->sweeps.count; k++) {
        const sweep *s = &w->sweeps.at[k];
        pair *p = pair_of(w, s);
        if (s->again || !s->tried) continue;
        pair_more *more = pair_more_make(w, p);
        uint64_t was = more->search_units - more->search_units / 4, units = units_of(w, s),
                 is = units > was ? units : was;
        more->search_units = (uint32_t)(is < UINT32_MAX ? is : UINT32_MAX);
    }
}

static void search_all(world *w, impact_batch *search)
{
    order_as_they_are(w);
    search(w, 0, w->sweep_order.count);
    for (size_t k = 0; k < w->sweeps.count; k++) w->sweeps.at[k].tried = w->sweeps.at[k].done = true;
}

/* Where all are expected to fit nobody has to wait for his turn. */
static void search_in_slice(world *w, impact_batch *search)
{
    uint64_t spent = 0, room = room_of(w);
    size_t at = 0;
    total all = allow_all(w);
    order_as_they_are(w);
    if (w->searching || all.expected > room / 2) order_by_turns(w);
    while (at < w->sweep_order.count && (at == 0 || spent < room)) {
        size_t end = end_of_batch(w, at, all.most <= room ? room : room / BATCHES);
        search(w, at, end);
        at = settle_batch(w, at, end, &spent);
    }
    for (size_t k = 0; k < w->sweeps.count; k++)
        if (w->sweeps.at[k].again) w->sweeps.at[k].done = w->sweeps.at[k - 1].done;
    count_units(w, all.expected, spent);
}

void impact_search(world *w, impact_batch *search)
{
    (w->slice == UINT64_MAX ? search_all : search_in_slice)(w, search);
    learn(w);
}
