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

static void take_older(const body *b, int64_t *oldest)
{
    if (!b->fixed && b->stamp_ns && (!*oldest || b->stamp_ns < *oldest)) *oldest = b->stamp_ns;
}

int64_t world_oldest_stamp_ns(const world *w, uint32_t id)
{
    int64_t oldest = 0;
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used) return 0;
    for (uint32_t v = w->subscriptions.at[id].first_watch; v != WORLD_NONE; v = w->watches.at[v].subscription_next) {
        const pair *p = &w->pairs.at[w->watches.at[v].pair];
        take_older(&w->bodies.at[w->colliders.at[p->a].body], &oldest);
        take_older(&w->bodies.at[w->colliders.at[p->b].body], &oldest);
    }
    return oldest;
}

bool world_brief_of(const world *w, uint32_t id, size_t most, world_brief *out)
{
    *out = (world_brief){.nearest = INFINITY, .soonest_ns = INT64_MAX};
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used) return true;
    uint32_t v = w->subscriptions.at[id].first_watch;
    for (; v != WORLD_NONE && most; v = w->watches.at[v].subscription_next, most--) {
        const watch *at = &w->watches.at[v];
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
