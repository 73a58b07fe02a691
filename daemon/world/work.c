/* work: the cascade's work in units, by a table of the kinds of pairs; which pair is refined first; and who pays.
 *
 * A unit is about a nanosecond of the machine the table was made on. Only ratios matter: what a unit takes here is
 * measured by whoever grants them. All of it follows from the commands and the grants. Tick thread, but for work_of. */
#include "cascade.h"
#include "geom/compound.h"
#include "geom/hull.h"
#include "geom/mesh.h"
#include "state.h"
#include "subscription.h"

#include "base/sort.h"

#include <string.h>

enum { WAITS_MAX = 32 }; /* ticks; who has waited so long goes first, whatever its need */

typedef struct price { /* units that a shape adds to a refinement of two that are apart, and of two that overlap */
    double apart, overlapping;
} price;

static price price_of(const shape *s)
{
    static const price PRICES[SHAPE_TYPE_COUNT] = {
        [SHAPE_SPHERE] = {20, 20},
        [SHAPE_CAPSULE] = {40, 60},
        [SHAPE_BOX] = {80, 200},
        [SHAPE_CYLINDER] = {300, 7000},
        [SHAPE_CONE] = {300, 5000},
        [SHAPE_ELLIPSOID] = {250, 250},
        [SHAPE_HALFSPACE] = {30, 30},
        [SHAPE_HULL] = {350, 900},
        [SHAPE_MESH] = {15000, 300000},
        [SHAPE_COMPOUND] = {200, 200},
        [SHAPE_SOFT] = {200, 200},
    };
    price p = PRICES[s->type];
    double vertices = s->type == SHAPE_HULL ? s->hull->vertex_count : 0;
    double triangles = s->type == SHAPE_MESH ? s->mesh->triangle_count : 0;
    double children = s->type == SHAPE_COMPOUND ? s->compound->child_count : 0;
    p.apart += 2.5 * vertices + 50 * triangles + 250 * children;
    p.overlapping += 7 * vertices + 500 * triangles + 2200 * children;
    return p;
}

void work_price(collider *s)
{
    price p = price_of(&s->shape);
    s->apart = (float)fmin(p.apart, 1e9);
    s->overlapping = (float)fmin(p.overlapping, 1e9);
}

static uint32_t whole(double work)
{
    return (uint32_t)fmin(work, 1e9);
}

/* Along one axis or two, and what it takes to tell. */
uint32_t work_of_bounds(const collider *a, const collider *b)
{
    const shape *of[2] = {&a->shape, &b->shape};
    double work = 700;
    for (int i = 0; i < 2; i++) {
        if (of[i]->type == SHAPE_COMPOUND) work += 30 * of[i]->compound->child_count;
        if (of[i]->hull) work += of[i]->hull->vertex_count;
    }
    return whole(work);
}

/* By what bounds say of it, and with what it takes to tell. */
uint32_t work_of(const collider *a, const collider *b, const demand *d, double lo)
{
    price x = price_of(&a->shape), y = price_of(&b->shape);
    double work = 500 + (lo > 0 ? x.apart + y.apart : x.overlapping + y.overlapping);
    if (d->request.facts & NARROW_MANIFOLD && lo <= d->request.threshold) work += 700;
    return whole(work);
}

/* ---- the order of need ---- */

static uint64_t ascending(float x) /* bits in the order of numbers */
{
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

static double step_of(const world *w, const collider *s)
{
    return vec_norm(body_step(&w->bodies.at[s->body]));
}

/* Where the lower bound may be in the next tick, if they go on as they came. Who waits goes before who does not. */
static uint64_t need_of(const world *w, uint32_t k)
{
    const pair *p = &w->pairs.at[w->active_pairs.at[k]];
    double next =
        pair_more_of(w, p)->standing.lo - step_of(w, &w->colliders.at[p->a]) - step_of(w, &w->colliders.at[p->b]);
    uint64_t rank = p->waited >= WAITS_MAX ? 0 : p->waited ? 1 : 2;
    return rank << 60 | ascending((float)next) << 28 | k;
}

static bool is_too_much(const world *w, uint64_t k)
{
    return w->outcomes.at[k].work > w->capacity;
}

/* One that a tick cannot do would be in the way of all behind it: it is set aside, behind those that a tick can do. One
 * of those that have waited longest is done in spite of the budget: with UINT8_MAX ticks between, seldom enough. */
static size_t set_aside(world *w)
{
    size_t todo = 0, aside = w->needs.count;
    uint64_t forced = UINT64_MAX;
    for (size_t i = 0; i < w->needs.count; i++) {
        uint64_t k = w->needs.at[i];
        bool overdue = w->pairs.at[w->active_pairs.at[k]].waited == UINT8_MAX;
        if (!is_too_much(w, k))
            w->sort_scratch.at[todo++] = k;
        else if (overdue && forced == UINT64_MAX)
            forced = k;
        else
            w->sort_scratch.at[--aside] = k;
    }
    size_t first = forced != UINT64_MAX;
    if (first) w->needs.at[0] = forced;
    for (size_t i = 0; i < todo; i++) w->needs.at[first + i] = w->sort_scratch.at[i];
    for (size_t i = aside; i < w->needs.count; i++) w->needs.at[i] = w->sort_scratch.at[i];
    return first + todo;
}

size_t work_order(world *w)
{
    w->needs.count = 0;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        const outcome *o = &w->outcomes.at[k];
        if (!o->settled && !o->coarse) array_push(&w->needs, need_of(w, (uint32_t)k));
    }
    if (!w->needs.count) return 0;
    array_reserve(&w->sort_scratch, w->needs.count);
    sort_keys(w->needs.at, w->sort_scratch.at, w->needs.count);
    for (size_t i = 0; i < w->needs.count; i++) w->needs.at[i] &= (1u << 28) - 1;
    return set_aside(w);
}

/* What a tick can do is what ticks did that left something; where all was done but for what was set aside, more is
 * tried. */
void work_learn(world *w, size_t todo, size_t refined, uint64_t done)
{
    uint64_t less = w->capacity - w->capacity / 4, more = w->capacity + w->capacity / 4 + 1;
    if (refined < todo)
        w->capacity = done > less ? done : less;
    else if (todo < w->needs.count && more < UINT32_MAX)
        w->capacity = more;
}

/* ---- who pays ---- */

static bool pays(const subscription *i)
{
    return i->facts & (WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD);
}

static void leave_to_subscription(world *w, uint32_t id)
{
    w->subscriptions.at[id].undone++;
    subscription_wake(w, id);
}

static void charge(world *w, match_list wanted, const outcome *o)
{
    uint32_t payers = 0;
    for (uint32_t k = 0; k < wanted.count; k++) payers += pays(&w->subscriptions.at[wanted.at[k]]);
    for (uint32_t k = 0; k < wanted.count; k++) {
        subscription *i = &w->subscriptions.at[wanted.at[k]];
        if (!pays(i)) continue;
        i->work += o->cost / payers;
        if (o->left && (o->coarse || i->accuracy != WORLD_BY_BOXES)) leave_to_subscription(w, wanted.at[k]);
    }
}

void work_charge(world *w)
{
    bool alone = w->askers == 1;
    for (size_t k = 0; k < w->active_pairs.count; k++) {
        const outcome *o = &w->outcomes.at[k];
        if (!o->cost) continue;
        if (alone) {
            w->subscriptions.at[w->first_asker].work += o->cost;
            if (o->left) leave_to_subscription(w, w->first_asker);
            continue;
        }
        charge(w, subscription_list(w, &w->pairs.at[w->active_pairs.at[k]]), o);
    }
}
