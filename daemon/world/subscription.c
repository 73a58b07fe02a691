/* subscription: who wants to know what, from the command that puts it to the batch that closes it. Which bodies and
 * pairs it is about is found by match.c. Tick thread.
 *
 * A tick costs nothing for a subscription with nothing to report: what concerns one puts it on the list of the
 * lively, and only that is walked. */
#include "subscription.h"
#include "base/sort.h"
#include "match.h"
#include "state.h"

#include <stdlib.h>
#include <string.h>

double subscription_tolerance(const subscription *i, double size)
{
    return i->tolerance > 0 ? i->tolerance : i->relative_tolerance * size;
}

/* ---- the lively ---- */

void subscription_wake(world *w, uint32_t id)
{
    subscription *i = &w->subscriptions.at[id];
    if (!i->lively) array_push(&w->lively, id);
    i->lively = true;
}

void subscription_wake_selecting(world *w, uint32_t id)
{
    const match *m = &w->match;
    if (id >= m->selectors.count) return;
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < m->selectors.at[id].sides[side].count; i++) {
            const match_selection *s = &m->selections.at[m->selectors.at[id].sides[side].at[i]];
            for (size_t k = 0; k < s->ids.count; k++) subscription_wake(w, s->ids.at[k]);
        }
}

void subscription_sort_lively(world *w)
{
    array_reserve(&w->sort_scratch, w->lively.count);
    sort_keys(w->lively.at, w->sort_scratch.at, w->lively.count);
}

/* The last tick has been reported; subscriptions with nothing due are no longer lively. */
static void rest_lively(world *w)
{
    size_t kept = 0;
    for (size_t k = 0; k < w->lively.count; k++) {
        subscription *i = &w->subscriptions.at[w->lively.at[k]];
        bool owes = i->snapshot || i->snapping || i->closing || i->settling || i->all || i->held.count;
        i->events.count = i->images.count = i->undone = 0;
        if (i->images_reported && !i->snapping) array_free(&i->images); /* seldom needed again, and large */
        i->images_begin = i->images_reported = false;
        i->lively = i->used && (owes || i->reported != w->reported_in_common);
        if (i->lively) w->lively.at[kept++] = w->lively.at[k];
    }
    w->lively.count = kept;
}

/* ---- how many ask for what ---- */

static bool asks_now(const subscription *i)
{
    return i->used && !i->closing && i->facts & (WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD);
}

static void count_one(subscription_counts *c, const subscription *i, size_t by)
{
    bool asks = asks_now(i);
    c->now += asks ? by : 0;
    c->bounds += asks && i->accuracy == WORLD_BY_BOXES ? by : 0;
    c->sweeps += i->used && !i->closing && i->facts & (WORLD_IMPACT | WORLD_PREDICT) ? by : 0;
}

/* From here on ticks, and poses, go by it. Who asks matters where it is one alone. */
static void publish_counts(world *w)
{
    w->sweepers = w->asking.sweeps;
    w->askers = w->asking.now;
    w->bounds_asked = w->asking.bounds;
    w->first_asker = 0;
    while (w->askers == 1 && !asks_now(&w->subscriptions.at[w->first_asker])) w->first_asker++;
}

/* ---- put, asked, removed ---- */

static bool same_subscription(const subscription *i, const world_subscription *def)
{
    return i->facts == def->facts && i->threshold == def->threshold && i->range == def->range &&
           i->hysteresis == def->hysteresis && i->tolerance == def->tolerance &&
           i->relative_tolerance == def->relative_tolerance && i->accuracy == def->accuracy &&
           i->soft_each == def->soft_each && i->soft_most == def->soft_most && i->horizon == def->horizon &&
           i->period_ns == def->period_ns && strcmp(i->select_a, def->select_a) == 0 &&
           strcmp(i->select_b, def->select_b) == 0;
}

static uint32_t new_subscription(world *w)
{
    uint32_t id = id_pool_take(&w->subscription_ids);
    array_reserve(&w->subscriptions, id + 1);
    while (w->subscriptions.count <= id) w->subscriptions.at[w->subscriptions.count++] = (subscription){.used = false};
    subscription *i = &w->subscriptions.at[id];
    *i = (subscription){.used = true,
        .lively = i->lively,
        .listed = i->listed,
        .first_watch = WORLD_NONE,
        .last_watch = WORLD_NONE,
        .first_old = WORLD_NONE,
        .last_old = WORLD_NONE,
        .snap_next = WORLD_NONE,
        .selection = WORLD_NONE,
        .select_a = base_strdup(""),
        .select_b = base_strdup("")};
    w->figures.subscriptions++;
    return id;
}

static void mark_changed(world *w, uint32_t id)
{
    subscription *i = &w->subscriptions.at[id];
    if (!i->changed && !i->olds) array_push(&w->changed_subscriptions, id);
    i->changed = true;
    w->changed = true;
    subscription_wake(w, id);
}

static void mark_unsettled(world *w, uint32_t id)
{
    subscription *i = &w->subscriptions.at[id];
    if (!i->listed) array_push(&w->unsettled, id);
    i->listed = true;
    i->settling = SETTLES_NEXT;
}

world_status world_put_subscription(world *w, uint32_t *id, const world_subscription *def)
{
    bool is_new = *id == WORLD_NONE;
    if (is_new)
        *id = new_subscription(w);
    else if (*id >= w->subscriptions.count || !w->subscriptions.at[*id].used || w->subscriptions.at[*id].closing)
        return WORLD_UNKNOWN_ID;
    subscription *i = &w->subscriptions.at[*id];
    world_want_snapshot(w, *id);
    i->owner = def->owner;
    i->in_step = def->in_step;
    if (!is_new && same_subscription(i, def)) return WORLD_OK;
    count_one(&w->asking, i, (size_t)-1);
    match_detach(w, *id);
    free(i->select_a);
    free(i->select_b);
    i->select_a = base_strdup(def->select_a);
    i->select_b = base_strdup(def->select_b);
    i->facts = def->facts;
    i->threshold = def->threshold;
    i->range = def->range;
    i->hysteresis = def->hysteresis;
    i->tolerance = def->tolerance;
    i->relative_tolerance = def->relative_tolerance;
    i->accuracy = def->accuracy;
    i->soft_each = def->soft_each;
    i->soft_most = def->soft_most;
    i->horizon = def->horizon;
    i->period_ns = def->period_ns;
    count_one(&w->asking, i, 1);
    match_attach(w, *id);
    mark_unsettled(w, *id);
    mark_changed(w, *id);
    return WORLD_OK;
}

world_status world_get_subscription(const world *w, uint32_t id, world_subscription *out)
{
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used || w->subscriptions.at[id].closing)
        return WORLD_UNKNOWN_ID;
    const subscription *i = &w->subscriptions.at[id];
    *out = (world_subscription){.facts = i->facts,
        .select_a = i->select_a,
        .select_b = i->select_b,
        .threshold = i->threshold,
        .range = i->range,
        .hysteresis = i->hysteresis,
        .tolerance = i->tolerance,
        .relative_tolerance = i->relative_tolerance,
        .accuracy = i->accuracy,
        .horizon = i->horizon,
        .soft_each = i->soft_each,
        .soft_most = i->soft_most,
        .period_ns = i->period_ns,
        .owner = i->owner,
        .in_step = i->in_step};
    return WORLD_OK;
}

world_status world_remove_subscription(world *w, uint32_t id, uint8_t cause)
{
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used || w->subscriptions.at[id].closing)
        return WORLD_UNKNOWN_ID;
    subscription *i = &w->subscriptions.at[id];
    count_one(&w->asking, i, (size_t)-1);
    match_detach(w, id);
    i->closing = true;
    i->closing_cause = cause;
    i->settling = SETTLED;
    mark_changed(w, id);
    return WORLD_OK;
}

uint64_t world_subscription_work(const world *w, uint32_t id)
{
    return id < w->subscriptions.count && w->subscriptions.at[id].used ? w->subscriptions.at[id].work : 0;
}

void world_want_snapshot(world *w, uint32_t id)
{
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used) return;
    w->subscriptions.at[id].snapshot = true;
    w->changed = true;
    subscription_wake(w, id);
}

void world_want_all(world *w, uint32_t id)
{
    if (id >= w->subscriptions.count || !w->subscriptions.at[id].used) return;
    w->subscriptions.at[id].all = true;
    subscription_wake(w, id);
}

/* ---- who is asked about ---- */

bool subscription_has(const world *w, uint32_t id, const body *b)
{
    const subscription *i = &w->subscriptions.at[id];
    if (i->selection == WORLD_NONE) return false;
    const uint32_t *selectors = w->match.selections.at[i->selection].selectors;
    return match_class_has(&w->match, b->match, selectors[0]) || match_class_has(&w->match, b->match, selectors[1]);
}

subscription_sides subscription_sides_of(const world *w, uint32_t id, const body *a, const body *b)
{
    const match *m = &w->match;
    const subscription *i = &w->subscriptions.at[id];
    if (i->selection == WORLD_NONE) return (subscription_sides){false, false};
    const uint32_t *s = m->selections.at[i->selection].selectors;
    return (subscription_sides){
        .straight = match_class_has(m, a->match, s[0]) && match_class_has(m, b->match, s[1]),
        .turned = match_class_has(m, b->match, s[0]) && match_class_has(m, a->match, s[1]),
    };
}

size_t subscription_unseen(const world *w, const subscription *i)
{
    size_t left = w->bodies.count - (i->settling == SETTLES_NOW ? w->match.cursor : 0);
    return i->settling == SETTLED ? 0 : left ? left : 1;
}

/* ---- in the tick ---- */

/* What was reported under the old terms of those that changed ends; they stay on the list until all of it has. */
static void close_changed(world *w)
{
    size_t count = w->changed_subscriptions.count;
    if (count > 1) qsort(w->changed_subscriptions.at, count, sizeof *w->changed_subscriptions.at, sort_compare_u32);
    for (size_t k = 0; k < count; k++) {
        uint32_t id = w->changed_subscriptions.at[k];
        subscription *i = &w->subscriptions.at[id];
        if (!i->changed) continue;
        i->changed = false;
        i->changed_tick = w->figures.ticks;
        w->epoch++;
        closing_begin(w, id);
    }
    closing_go_on(w);
}

void subscription_settle_changes(world *w)
{
    if (w->changed_subscriptions.count) publish_counts(w);
    close_changed(w);
    match_refresh(w);
    match_run(w);
}

void subscription_pass_began(world *w)
{
    for (size_t k = 0; k < w->unsettled.count; k++) {
        subscription *i = &w->subscriptions.at[w->unsettled.at[k]];
        if (i->settling == SETTLES_NEXT) i->settling = SETTLES_NOW;
    }
}

void subscription_pass_ended(world *w)
{
    size_t kept = 0;
    for (size_t k = 0; k < w->unsettled.count; k++) {
        subscription *i = &w->subscriptions.at[w->unsettled.at[k]];
        if (i->settling == SETTLES_NOW) i->settling = SETTLED;
        i->listed = i->settling != SETTLED;
        if (i->listed) w->unsettled.at[kept++] = w->unsettled.at[k];
    }
    w->unsettled.count = kept;
}

static void forget_subscription(world *w, uint32_t id)
{
    subscription *i = &w->subscriptions.at[id];
    free(i->select_a);
    free(i->select_b);
    array_free(&i->held);
    array_free(&i->events);
    array_free(&i->images);
    *i = (subscription){.used = false, .lively = i->lively, .listed = i->listed, .selection = WORLD_NONE};
    id_pool_give(&w->subscription_ids, id);
    w->figures.subscriptions--;
}

/* Those whose closing batch the last tick has reported are gone. */
void subscription_begin_tick(world *w)
{
    size_t kept = 0;
    for (size_t k = 0; k < w->changed_subscriptions.count; k++) {
        const subscription *i = &w->subscriptions.at[w->changed_subscriptions.at[k]];
        if (i->changed || i->olds)
            w->changed_subscriptions.at[kept++] = w->changed_subscriptions.at[k];
        else if (i->used && i->closing)
            forget_subscription(w, w->changed_subscriptions.at[k]);
    }
    w->changed_subscriptions.count = kept;
    rest_lively(w);
}

void subscription_end_tick(world *w)
{
    for (size_t k = 0; k < w->lively.count; k++) w->subscriptions.at[w->lively.at[k]].all = false;
}

/* What is not saved follows from what is. */
void subscription_restored(world *w)
{
    w->asking = (subscription_counts){0};
    w->reported_in_common = SIZE_MAX;
    for (uint32_t id = 0; id < w->subscriptions.count; id++) {
        subscription *i = &w->subscriptions.at[id];
        i->lively = i->listed = false;
        if (!i->used) continue;
        count_one(&w->asking, i, 1);
        i->snapshot |= i->snapping; /* a subscription that waits for it gets it from the beginning */
        i->snapping = false;
        subscription_wake(w, id);
        w->olds += i->olds;
        if (i->changed || i->closing || i->olds) array_push(&w->changed_subscriptions, id);
        i->listed = i->settling != SETTLED;
        if (i->listed) array_push(&w->unsettled, id);
    }
    publish_counts(w); /* poses may come before the first tick */
}
