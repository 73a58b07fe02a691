/* world: its life, and the tick as the sequence of its phases. Tick thread. */
#include "cascade.h"
#include "match.h"
#include "soft_state.h"
#include "state.h"
#include "subscription.h"

#include "base/hash.h"
#include "base/whole.h"

#include <stdlib.h>

world_options world_options_default(void)
{
    return (world_options){
        .workers = 1, .engine = NARROW_ENGINE_AUTO, .broad = BROAD_AUTO, .caches = true, .margin = 0.1};
}

world *world_create(const world_options *options)
{
    world *w = base_zalloc(1, sizeof *w);
    w->options = *options;
    w->workers = workers_create(options->workers);
    size_t bytes = (narrow_scratch_size() + 63) / 64 * 64;
    for (unsigned i = 0; i < workers_count(w->workers); i++) {
        w->scratch[i] = aligned_alloc(64, bytes);
        if (!w->scratch[i]) abort();
    }
    w->broad = broad_create(options->broad, pair_accept, w);
    id_pool_init(&w->body_ids);
    id_pool_init(&w->collider_ids);
    id_pool_init(&w->subscription_ids);
    id_pool_init(&w->pair_ids);
    id_pool_init(&w->watch_ids);
    id_pool_init(&w->payer_ids);
    pair_map_init(&w->payer_of);
    pair_map_init(&w->pair_of);
    pair_map_init(&w->names);
    pair_map_init(&w->leaving_names);
    match_init(&w->match);
    rules_init(&w->rules);
    impact_wait_init(w);
    w->soft = base_zalloc(1, sizeof *w->soft);
    pair_map_init(&w->soft->result_of);
    w->slice = UINT64_MAX;
    w->epoch = 1;
    w->round = 1;
    w->hash = HASH_START;
    return w;
}

broad_kind world_broad_kind(const world *w)
{
    return broad_index_kind(w->broad);
}

void world_report_broad(const world *w, char text[96])
{
    broad_report_index(w->broad, text);
}

static void free_bodies(world *w)
{
    for (size_t i = 0; i < w->bodies.count; i++) {
        body *b = &w->bodies.at[i];
        for (size_t k = 0; k < b->rule_count; k++) {
            free((char *)b->rules[k].pattern);
            free((char *)b->rules[k].reason);
        }
        free(b->rules);
        free(b->name);
        body_free_group(b);
        body_free_shapes(b);
        array_free(&b->passed);
        for (size_t k = 0; k < b->past.count; k++) free(b->past.at[k].passed);
        array_free(&b->past);
    }
    array_free_in_place(&w->bodies);
}

static void free_subscriptions(world *w)
{
    for (size_t i = 0; i < w->subscriptions.count; i++) {
        subscription *x = &w->subscriptions.at[i];
        free(x->select_a);
        free(x->select_b);
        array_free(&x->held);
        array_free(&x->events);
        array_free(&x->images);
    }
    array_free(&w->subscriptions);
}

void world_destroy(world *w)
{
    if (!w) return;
    soft_results_free(w);
    soft_jobs_free(w);
    soft_bodies_free(w);
    free(w->soft);
    for (unsigned i = 0; i < workers_count(w->workers); i++) free(w->scratch[i]);
    workers_destroy(w->workers);
    broad_destroy(w->broad);
    checks_free(w);
    free_bodies(w);
    free_subscriptions(w);
    match_free(&w->match);
    rules_free(&w->rules);
    array_free(&w->unsettled);
    array_free(&w->lively);
    id_pool_free(&w->body_ids);
    id_pool_free(&w->collider_ids);
    id_pool_free(&w->subscription_ids);
    id_pool_free(&w->pair_ids);
    id_pool_free(&w->watch_ids);
    id_pool_free(&w->payer_ids);
    pair_map_free(&w->payer_of);
    array_free(&w->payers);
    pair_map_free(&w->pair_of);
    pair_map_free(&w->names);
    for (size_t i = 0; i < w->colliders.count; i++) collider_free(&w->colliders.at[i]);
    array_free_in_place(&w->colliders);
    for (size_t i = 0; i < w->pairs.count; i++) free(w->pairs.at[i].cache.shell);
    array_free_in_place(&w->pairs);
    array_free_in_place(&w->pairs_more);
    free(w->rulings);
    array_free_in_place(&w->watches);
    array_free_in_place(&w->last_contacts);
    array_free_in_place(&w->last_points);
    array_free_in_place(&w->last_predicted);
    array_free(&w->dirty);
    array_free(&w->left);
    array_free(&w->movers);
    array_free(&w->mover_at);
    array_free(&w->awake);
    array_free(&w->awake_bits);
    array_free(&w->glided);
    array_free(&w->past_bodies);
    array_free(&w->sort_scratch);
    array_free(&w->queue);
    array_free(&w->changed_subscriptions);
    array_free(&w->ghosts);
    array_free(&w->reap);
    array_free(&w->ghost_colliders);
    array_free(&w->reap_colliders);
    array_free(&w->expiries);
    array_free(&w->held_now);
    array_free(&w->unknown_due);
    array_free(&w->stale_now);
    array_free(&w->fresh_now);
    array_free(&w->active);
    array_free(&w->active_pairs);
    array_free(&w->outcomes);
    array_free(&w->told);
    array_free(&w->open);
    array_free(&w->needs);
    array_free(&w->unfinished);
    array_free(&w->lingering);
    array_free(&w->purses);
    array_free(&w->leaving);
    array_free(&w->leavers);
    removal_free(w);
    pair_map_free(&w->leaving_names);
    array_free(&w->concerned);
    array_free(&w->concerned_found);
    array_free(&w->results);
    array_free(&w->sweeps);
    array_free(&w->sweep_order);
    array_free(&w->sweep_keys);
    array_free(&w->search_again);
    array_free(&w->searchers);
    array_free(&w->batches);
    free(w);
}

static void begin_tick(world *w, int64_t now_ns)
{
    w->now_ns = now_ns;
    w->figures.ticks++;
    w->round++;
    subscription_begin_tick(w);
    removal_go_on(w);
    body_reap(w);
    slices_begin(w);
    leaving_begin(w);
}

/* What was put or moved stands where it is from here on. */
static void end_tick(world *w)
{
    pair_end_unwatched(w);
    for (size_t i = 0; i < w->dirty.count; i++) body_arrive(w, (uint32_t)w->dirty.at[i]);
    for (size_t i = 0; i < w->glided.count; i++) body_arrive(w, w->glided.at[i]);
    subscription_end_tick(w);
    w->last_tick_ns = w->now_ns;
    w->glided.count = 0;
    settling_end(w);
    w->changed = w->some_glided = w->rematched = false;
    ASSERT_WHOLE(whole_is_due(w->figures.ticks, w->bodies.count + w->pairs.count), world_validate(w));
}

void world_tick(world *w, int64_t now_ns, world_batches *out)
{
    broad_changes changes;
    begin_tick(w, now_ns);

    /* what was commanded */
    subscription_settle_changes(w);
    soft_go_on(w);
    body_settle_dirty(w);
    expiry_find(w);

    /* which pairs it concerns */
    broad_update(w->broad, &changes);
    w->sliced |= broad_was_put_off(w->broad);
    pair_apply_changes(w, &changes);
    pair_collect_active(w);

    /* what they are to each other, were on their way, and will be */
    soft_decide(w);
    cascade_decide(w);
    impact_decide(w);

    /* who is told */
    events_known(w); /* first: a name that is free again may be unknown under its next bearer */
    events_unknown(w);
    events_teleported(w);
    events_unmatched(w);
    events_of_sweeps(w);
    events_of_active(w);
    past_keep(w);
    events_held_back(w);
    soft_tell(w);
    events_snapshots(w);
    slices_report(w);
    events_collect(w, out);
    end_tick(w);
}

void world_set_budget(world *w, world_grant *grant, void *context)
{
    w->grant = grant;
    w->grant_context = context;
    w->capacity = 1000000; /* a millisecond, until ticks have shown what they can do */
    w->epoch++;            /* what stands was not kept, or is not wanted */
    for (size_t i = 0; i < w->bodies.count; i++) w->bodies.at[i].travelled_to = w->bodies.at[i].pose; /* as bounds.c */
}

int64_t world_next_due_ns(const world *w)
{
    int64_t due = expiry_next_ns(w);
    for (size_t i = 0; i < w->lively.count; i++) {
        const subscription *x = &w->subscriptions.at[w->lively.at[i]];
        if (x->used && x->held.count && x->next_update_ns < due) due = x->next_update_ns;
    }
    return due;
}

bool world_glided(const world *w)
{
    return w->some_glided;
}

bool world_changed(const world *w)
{
    if (soft_is_busy(w)) return true;
    if (w->snapping || w->lets_in || w->left.count || w->searching) return true;
    return w->changed || w->unfinished.count || w->due || w->olds || w->leaving.count || w->going ||
           match_is_unsettled(&w->match);
}

bool world_is_closing(const world *w)
{
    return w->olds > 0;
}

world_figures world_get_figures(const world *w)
{
    return w->figures;
}

const char *world_stage_name(world_stage stage)
{
    static const char *const NAMES[STAGE_COUNT] = {
        [STAGE_UNASKED] = "unasked",
        [STAGE_UNKNOWN] = "unknown",
        [STAGE_STANDING] = "standing",
        [STAGE_BOUNDS] = "bounds",
        [STAGE_MOTION_BOUND] = "motion_bound",
        [STAGE_CACHED_AXIS] = "cached_axis",
        [STAGE_CLOSED_FORM] = "closed_form",
        [STAGE_GJK] = "gjk",
        [STAGE_EPA] = "epa",
        [STAGE_SAT] = "sat",
        [STAGE_CCD] = "ccd",
        [STAGE_MPR] = "mpr",
    };
    return stage < STAGE_COUNT ? NAMES[stage] : "?";
}
