/* news: does an event say anything that the one before has not said, and how old is what was said. Tick thread. */
#include "state.h"

#include <math.h>
#include <string.h>

static bool same_bits(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static bool same_vec_bits(const vec3 *a, const vec3 *b)
{
    return same_bits(a, b, sizeof *a);
}

static bool same_manifold(const manifold *a, const manifold *b)
{
    bool same = a->count == b->count;
    for (uint32_t i = 0; same && i < a->count; i++) {
        const manifold_point *p = &a->points[i], *q = &b->points[i];
        same = p->feature == q->feature && same_vec_bits(&p->point, &q->point) &&
               same_bits(&p->distance, &q->distance, sizeof p->distance);
    }
    return same;
}

bool news_same_impact(const world_impact *a, const world_impact *b)
{
    return same_bits(&a->lo, &b->lo, sizeof a->lo) && same_bits(&a->hi, &b->hi, sizeof a->hi) &&
           a->start_ns == b->start_ns && a->estimated == b->estimated &&
           same_bits(&a->pose_a, &b->pose_a, sizeof(pose)) && same_bits(&a->pose_b, &b->pose_b, sizeof(pose));
}

bool news_same_facts(const world_event *a, const world_event *b)
{
    return same_bits(&a->lo, &b->lo, sizeof a->lo) && same_bits(&a->hi, &b->hi, sizeof a->hi) &&
           same_vec_bits(&a->axis, &b->axis) && same_vec_bits(&a->point_a, &b->point_a) &&
           same_vec_bits(&a->point_b, &b->point_b) && same_bits(&a->closing, &b->closing, sizeof a->closing) &&
           a->achieved == b->achieved && a->shape_a == b->shape_a && a->shape_b == b->shape_b &&
           same_manifold(&a->manifold, &b->manifold) && strcmp(a->name_a, b->name_a) == 0;
}

/* ---- the oldest stamp ---- */

static void take_older(const body *b, int64_t *oldest)
{
    if (!b->fixed && b->stamp_ns && (!*oldest || b->stamp_ns < *oldest)) *oldest = b->stamp_ns;
}

static void take_older_of(const world *w, uint32_t watch_id, int64_t *oldest)
{
    const pair *p = &w->pairs.at[w->watches.at[watch_id].pair];
    take_older(&w->bodies.at[w->colliders.at[p->a].body], oldest);
    take_older(&w->bodies.at[w->colliders.at[p->b].body], oldest);
}

/* Is it its turn to be looked through? Whoever asks no more, as another one finds out that asks twice, has had it. */
static bool stamp_search_goes_on(stamp_search *t, uint32_t id)
{
    bool goes_on = t->on && t->subscription == id, waits = t->on && !goes_on && t->waits != id + 1;
    if (goes_on) t->waits = 0;
    if (waits && !t->waits) t->waits = id + 1;
    if (waits) return false;
    if (!goes_on) *t = (stamp_search){.on = true, .subscription = id};
    return true;
}

/* Of many watches by their places, where none is missed that stays: those that begin behind the place that has been
 * reached, and what their bodies' stamps were, count when they begin. */
bool world_oldest_stamp(world *w, uint32_t id, size_t *looked, int64_t *oldest_ns)
{
    stamp_search *t = &w->stamps;
    const subscription *i = id < w->subscriptions.count ? &w->subscriptions.at[id] : NULL;
    *oldest_ns = 0;
    if (!i || !i->used) return true;
    if (i->watches <= OLDEST_STAMP_PART) {
        *looked += i->watches;
        for (uint32_t v = i->first_watch; v != WORLD_NONE; v = w->watches.at[v].subscription_next)
            take_older_of(w, v, oldest_ns);
        return true;
    }
    if (!stamp_search_goes_on(t, id)) return false;
    size_t left = w->watches.count - t->next, part = left < OLDEST_STAMP_PART ? left : OLDEST_STAMP_PART;
    *looked += part;
    for (size_t end = t->next + part; t->next < end; t->next++) {
        const watch *v = &w->watches.at[t->next];
        if (v->used && v->subscription == id) take_older_of(w, (uint32_t)t->next, &t->oldest_ns);
    }
    if (t->next < w->watches.count) return false;
    *oldest_ns = t->oldest_ns;
    *t = (stamp_search){.on = false};
    return true;
}

void news_begins(world *w, uint32_t watch_id)
{
    stamp_search *t = &w->stamps;
    if (t->on && w->watches.at[watch_id].subscription == t->subscription) take_older_of(w, watch_id, &t->oldest_ns);
}

/* ---- what an operator watches ---- */

bool world_brief_of(const world *w, uint32_t id, size_t most, world_brief *out)
{
    *out = (world_brief){.nearest = INFINITY, .soonest_ns = INT64_MAX};
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used) return true;
    uint32_t v = w->subscriptions.at[id].first_watch;
    for (; v != WORLD_NONE && most; v = w->watches.at[v].subscription_next, most--) {
        const watch *at = &w->watches.at[v];
        take_older_of(w, v, &out->oldest_ns);
        out->pairs++;
        out->unknown += at->unknown;
        if (at->unknown) continue;
        out->contacts += at->touch_id != 0;
        if ((at->touch_id || at->near_id) && w->last_contacts.at[v].lo < out->nearest)
            out->nearest = w->last_contacts.at[v].lo;
        if (!at->predicted_id) continue;
        const world_impact *met = &w->last_predicted.at[v].impact;
        int64_t at_ns = met->start_ns + (int64_t)(1e9 * met->lo);
        if (at_ns < out->soonest_ns) out->soonest_ns = at_ns;
    }
    return v == WORLD_NONE;
}
