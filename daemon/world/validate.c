/* validate: the world's invariants, walked in full. For tests. */
#include "calm.h"
#include "state.h"
#include "subscription.h"

static const char *check_watch(const world *w, uint32_t id)
{
    const watch *v = &w->watches.at[id];
    if (!v->used) return "a dead watch is linked";
    if (!v->touch_id && !v->near_id && !v->predicted_id) return "a watch with nothing to watch";
    if (!w->pairs.at[v->pair].used) return "a watch of a dead pair";
    if (!w->subscriptions.at[v->subscription].used) return "a watch of a dead subscription";
    return NULL;
}

static const char *check_pairs(const world *w, size_t *watches, size_t *contacts)
{
    size_t pairs = 0, lingering = 0;
    for (uint32_t p = 0; p < w->pairs.count; p++) {
        const pair *at = &w->pairs.at[p];
        if (!at->used) continue;
        pairs++;
        lingering += at->lingers;
        if (at->lingers && at->first_watch == WORLD_NONE) return "a pair lingers for nobody";
        if (pair_find(w, at->a, at->b) != p) return "a pair is not in the map";
        if (at->at_origins != (w->colliders.at[at->a].at_origin && w->colliders.at[at->b].at_origin))
            return "a pair is not at its bodies' origins";
        uint32_t last = 0;
        bool reported = false;
        for (uint32_t v = at->first_watch; v != WORLD_NONE; v = w->watches.at[v].pair_next) {
            const char *fault = check_watch(w, v);
            if (fault) return fault;
            if (v != at->first_watch && w->watches.at[v].subscription <= last) return "watches of a pair out of order";
            last = w->watches.at[v].subscription;
            reported |= w->watches.at[v].touch_id || w->watches.at[v].near_id;
            ++*watches;
            *contacts += w->watches.at[v].touch_id != 0;
        }
        if (reported != at->is_reported) return "a pair does not know whether it was reported";
    }
    if (pairs != w->figures.pairs) return "pairs miscounted";
    if (lingering != w->lingers || lingering != w->lingering.count) return "lingering pairs miscounted";
    if (pairs - lingering + w->figures.pairs_left_out != broad_pair_count(w->broad))
        return "pairs differ from the broad phase's";
    const char *charged = payers_validate(w);
    if (charged) return charged;
    if (w->options.max_pairs && pairs - lingering > w->options.max_pairs) return "more pairs than may be";
    return NULL;
}

typedef struct kept_ids {
    const world *w;
    uint32_t collider;
    bool wrong;
} kept_ids;

static void check_kept_id(void *context, uint32_t other, uint32_t *number)
{
    kept_ids *n = context;
    n->wrong |= *number != BROAD_NO_NUMBER && *number != pair_find(n->w, n->collider, other);
}

static const char *check_kept_ids(const world *w)
{
    kept_ids n = {.w = w};
    for (n.collider = 0; n.collider < w->colliders.count; n.collider++)
        if (w->colliders.at[n.collider].used) broad_each_number_of(w->broad, n.collider, check_kept_id, &n);
    return n.wrong ? "the broad phase keeps the id of another pair" : NULL;
}

static bool fits(const world *w, const body *b)
{
    broad_region region;
    for (size_t i = 0; i < b->shape_count; i++) {
        const collider *s = &w->colliders.at[b->shapes[i]];
        aabb box = aabb_grow(shape_bounds(&s->shape, pose_mul(b->pose, s->local)), b->widen);
        if (!broad_region_of(w->broad, b->shapes[i], box, body_margin(w, s), &region)) return false;
    }
    return true;
}

static const char *check_calm(const world *w)
{
    for (uint32_t i = 0; i < w->bodies.count; i++) {
        const body *b = &w->bodies.at[i];
        if (!b->used || b->ghost || b->dirty) continue;
        if ((b->is_calm || b->behind) && b->pair_count) return "a body in a pair is calm, or behind";
        if (b->is_calm && calm_holds(b, &b->pose) && !fits(w, b)) return "a calm body has left its fat boxes";
    }
    return NULL;
}

static const char *check_going(const world *w)
{
    size_t going = 0;
    for (size_t i = 0; i < w->bodies.count; i++) going += w->bodies.at[i].used && w->bodies.at[i].goes;
    return going == w->going ? NULL : "bodies that are to go miscounted";
}

static const char *check_lists(const world *w, uint32_t id, size_t *watches)
{
    const subscription *i = &w->subscriptions.at[id];
    size_t count = 0, olds = 0;
    for (int old = 0; old < 2; old++) {
        uint32_t last = WORLD_NONE;
        for (uint32_t v = old ? i->first_old : i->first_watch; v != WORLD_NONE;
             v = w->watches.at[v].subscription_next) {
            const watch *at = &w->watches.at[v];
            if (at->subscription != id) return "a watch in another subscription's list";
            if (at->subscription_prev != last || watch_is_old(w, at) != old) return "a watch in the wrong list";
            last = v;
            count++;
            olds += (size_t)old;
        }
        if ((old ? i->last_old : i->last_watch) != last) return "a list of watches ends elsewhere";
    }
    *watches += count;
    return count == i->watches && olds == i->olds ? NULL : "watches of a subscription miscounted";
}

const char *world_validate(const world *w)
{
    size_t of_pairs = 0, of_subscriptions = 0, contacts = 0, olds = 0;
    const char *fault = check_pairs(w, &of_pairs, &contacts);
    if (fault) return fault;
    for (uint32_t i = 0; i < w->subscriptions.count; i++) {
        if (!w->subscriptions.at[i].used) continue;
        if (w->subscriptions.at[i].held.count > 2 * w->watches.count + SPARE_HELD)
            return "updates of what has ended pile up";
        const char *wrong = check_lists(w, i, &of_subscriptions);
        if (wrong) return wrong;
        olds += w->subscriptions.at[i].olds;
    }
    if (olds != w->olds) return "old watches miscounted";
    if (of_pairs != of_subscriptions) return "watches of pairs and of subscriptions differ";
    if (contacts != w->figures.contacts) return "contacts miscounted";
    if (w->expiries.count > 2 * w->bodies.count + SPARE_EXPIRIES) return "deadlines of bodies that are gone pile up";
    fault = check_calm(w);
    if (!fault) fault = check_kept_ids(w);
    if (!fault) fault = check_going(w);
    if (!fault) fault = impact_wait_validate(w);
    return fault ? fault : broad_validate(w->broad);
}
