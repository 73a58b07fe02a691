/* interest: who wants to know what, from the command that puts it to the batch that closes it. Which bodies and pairs
 * it is about is found by match.c. Tick thread.
 *
 * A tick costs nothing for an interest that has nothing to be told: what concerns one puts it on the list of the
 * lively, and only that is walked. */
#include "interest.h"
#include "base/sort.h"
#include "match.h"
#include "state.h"

#include <stdlib.h>
#include <string.h>

double interest_tolerance(const interest *i, double size)
{
    return i->tolerance > 0 ? i->tolerance : i->relative_tolerance * size;
}

/* ---- the lively ---- */

void interest_wake(world *w, uint32_t id)
{
    interest *i = &w->interests.at[id];
    if (!i->lively) array_push(&w->lively, id);
    i->lively = true;
}

void interest_wake_selecting(world *w, uint32_t id)
{
    const match *m = &w->match;
    if (id >= m->selectors.count) return;
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < m->selectors.at[id].sides[side].count; i++) {
            const match_selection *s = &m->selections.at[m->selectors.at[id].sides[side].at[i]];
            for (size_t k = 0; k < s->ids.count; k++) interest_wake(w, s->ids.at[k]);
        }
}

void interest_sort_lively(world *w)
{
    array_reserve(&w->sort_scratch, w->lively.count);
    sort_keys(w->lively.at, w->sort_scratch.at, w->lively.count);
}

/* The last tick has been told; those of which nothing is due any more are lively no longer. */
static void rest_lively(world *w)
{
    size_t kept = 0;
    for (size_t k = 0; k < w->lively.count; k++) {
        interest *i = &w->interests.at[w->lively.at[k]];
        bool owes = i->snapshot || i->snapping || i->closing || i->settling || i->all || i->held.count;
        i->events.count = i->images.count = i->undone = 0;
        i->images_begin = i->images_told = false;
        i->lively = i->used && (owes || i->told != w->told_in_common);
        if (i->lively) w->lively.at[kept++] = w->lively.at[k];
    }
    w->lively.count = kept;
}

/* ---- how many ask for what ---- */

static bool asks_now(const interest *i)
{
    return i->used && !i->closing && i->facts & (WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD);
}

static void count_one(interest_counts *c, const interest *i, size_t by)
{
    bool asks = asks_now(i);
    c->now += asks ? by : 0;
    c->bounds += asks && i->accuracy == WORLD_BY_BOXES ? by : 0;
    c->sweeps += i->used && !i->closing && i->facts & (WORLD_IMPACT | WORLD_FORETELL) ? by : 0;
}

/* From here on ticks, and poses, go by it. Who asks matters where it is one alone. */
static void publish_counts(world *w)
{
    w->sweepers = w->asking.sweeps;
    w->askers = w->asking.now;
    w->bounds_asked = w->asking.bounds;
    w->first_asker = 0;
    while (w->askers == 1 && !asks_now(&w->interests.at[w->first_asker])) w->first_asker++;
}

/* ---- put, asked, removed ---- */

static bool same_interest(const interest *i, const world_interest *def)
{
    return i->facts == def->facts && i->threshold == def->threshold && i->range == def->range &&
           i->hysteresis == def->hysteresis && i->tolerance == def->tolerance &&
           i->relative_tolerance == def->relative_tolerance && i->accuracy == def->accuracy &&
           i->horizon == def->horizon && i->period_ns == def->period_ns && strcmp(i->select_a, def->select_a) == 0 &&
           strcmp(i->select_b, def->select_b) == 0;
}

static uint32_t new_interest(world *w)
{
    uint32_t id = id_pool_take(&w->interest_ids);
    array_reserve(&w->interests, id + 1);
    while (w->interests.count <= id) w->interests.at[w->interests.count++] = (interest){.used = false};
    interest *i = &w->interests.at[id];
    *i = (interest){.used = true,
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
    w->figures.interests++;
    return id;
}

static void mark_changed(world *w, uint32_t id)
{
    interest *i = &w->interests.at[id];
    if (!i->changed && !i->olds) array_push(&w->changed_interests, id);
    i->changed = true;
    w->changed = true;
    interest_wake(w, id);
}

static void mark_unsettled(world *w, uint32_t id)
{
    interest *i = &w->interests.at[id];
    if (!i->listed) array_push(&w->unsettled, id);
    i->listed = true;
    i->settling = SETTLES_NEXT;
}

world_status world_put_interest(world *w, uint32_t *id, const world_interest *def)
{
    bool is_new = *id == WORLD_NONE;
    if (is_new)
        *id = new_interest(w);
    else if (*id >= w->interests.count || !w->interests.at[*id].used || w->interests.at[*id].closing)
        return WORLD_UNKNOWN_ID;
    interest *i = &w->interests.at[*id];
    world_want_snapshot(w, *id);
    if (!is_new && same_interest(i, def)) return WORLD_OK;
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
    i->horizon = def->horizon;
    i->period_ns = def->period_ns;
    count_one(&w->asking, i, 1);
    match_attach(w, *id);
    mark_unsettled(w, *id);
    mark_changed(w, *id);
    return WORLD_OK;
}

world_status world_get_interest(const world *w, uint32_t id, world_interest *out)
{
    if (id >= w->interests.count || !w->interests.at[id].used || w->interests.at[id].closing) return WORLD_UNKNOWN_ID;
    const interest *i = &w->interests.at[id];
    *out = (world_interest){.facts = i->facts,
        .select_a = i->select_a,
        .select_b = i->select_b,
        .threshold = i->threshold,
        .range = i->range,
        .hysteresis = i->hysteresis,
        .tolerance = i->tolerance,
        .relative_tolerance = i->relative_tolerance,
        .accuracy = i->accuracy,
        .horizon = i->horizon,
        .period_ns = i->period_ns};
    return WORLD_OK;
}

world_status world_remove_interest(world *w, uint32_t id, uint8_t cause)
{
    if (id >= w->interests.count || !w->interests.at[id].used || w->interests.at[id].closing) return WORLD_UNKNOWN_ID;
    interest *i = &w->interests.at[id];
    count_one(&w->asking, i, (size_t)-1);
    match_detach(w, id);
    i->closing = true;
    i->closing_cause = cause;
    i->settling = SETTLED;
    mark_changed(w, id);
    return WORLD_OK;
}

uint64_t world_interest_work(const world *w, uint32_t id)
{
    return id < w->interests.count && w->interests.at[id].used ? w->interests.at[id].work : 0;
}

void world_want_snapshot(world *w, uint32_t id)
{
    if (id >= w->interests.count || !w->interests.at[id].used) return;
    w->interests.at[id].snapshot = true;
    w->changed = true;
    interest_wake(w, id);
}

void world_want_all(world *w, uint32_t id)
{
    if (id >= w->interests.count || !w->interests.at[id].used) return;
    w->interests.at[id].all = true;
    interest_wake(w, id);
}

/* ---- who is asked about ---- */

bool interest_has(const world *w, uint32_t id, const body *b)
{
    const interest *i = &w->interests.at[id];
    if (i->selection == WORLD_NONE) return false;
    const uint32_t *selectors = w->match.selections.at[i->selection].selectors;
    return match_class_has(&w->match, b->match, selectors[0]) || match_class_has(&w->match, b->match, selectors[1]);
}

interest_sides interest_sides_of(const world *w, uint32_t id, const body *a, const body *b)
{
    const match *m = &w->match;
    const interest *i = &w->interests.at[id];
    if (i->selection == WORLD_NONE) return (interest_sides){false, false};
    const uint32_t *s = m->selections.at[i->selection].selectors;
    return (interest_sides){
        .straight = match_class_has(m, a->match, s[0]) && match_class_has(m, b->match, s[1]),
        .turned = match_class_has(m, b->match, s[0]) && match_class_has(m, a->match, s[1]),
    };
}

size_t interest_unseen(const world *w, const interest *i)
{
    size_t left = w->bodies.count - (i->settling == SETTLES_NOW ? w->match.cursor : 0);
    return i->settling == SETTLED ? 0 : left ? left : 1;
}

/* ---- in the tick ---- */

/* What was told under the old terms of those that changed ends; they stay on the list until all of it has. */
static void close_changed(world *w)
{
    size_t count = w->changed_interests.count;
    if (count > 1) qsort(w->changed_interests.at, count, sizeof *w->changed_interests.at, sort_compare_u32);
    for (size_t k = 0; k < count; k++) {
        uint32_t id = w->changed_interests.at[k];
        interest *i = &w->interests.at[id];
        if (!i->changed) continue;
        i->changed = false;
        i->changed_tick = w->figures.ticks;
        w->epoch++;
        closing_begin(w, id);
    }
    closing_go_on(w);
}

void interest_settle_changes(world *w)
{
    if (w->changed_interests.count) publish_counts(w);
    close_changed(w);
    match_refresh(w);
    match_run(w);
}

void interest_pass_began(world *w)
{
    for (size_t k = 0; k < w->unsettled.count; k++) {
        interest *i = &w->interests.at[w->unsettled.at[k]];
        if (i->settling == SETTLES_NEXT) i->settling = SETTLES_NOW;
    }
}

void interest_pass_ended(world *w)
{
    size_t kept = 0;
    for (size_t k = 0; k < w->unsettled.count; k++) {
        interest *i = &w->interests.at[w->unsettled.at[k]];
        if (i->settling == SETTLES_NOW) i->settling = SETTLED;
        i->listed = i->settling != SETTLED;
        if (i->listed) w->unsettled.at[kept++] = w->unsettled.at[k];
    }
    w->unsettled.count = kept;
}

static void forget_interest(world *w, uint32_t id)
{
    interest *i = &w->interests.at[id];
    free(i->select_a);
    free(i->select_b);
    array_free(&i->held);
    array_free(&i->events);
    array_free(&i->images);
    *i = (interest){.used = false, .lively = i->lively, .listed = i->listed, .selection = WORLD_NONE};
    id_pool_give(&w->interest_ids, id);
    w->figures.interests--;
}

/* Those whose closing batch the last tick has told are gone. */
void interest_begin_tick(world *w)
{
    size_t kept = 0;
    for (size_t k = 0; k < w->changed_interests.count; k++) {
        const interest *i = &w->interests.at[w->changed_interests.at[k]];
        if (i->changed || i->olds)
            w->changed_interests.at[kept++] = w->changed_interests.at[k];
        else if (i->used && i->closing)
            forget_interest(w, w->changed_interests.at[k]);
    }
    w->changed_interests.count = kept;
    rest_lively(w);
}

void interest_end_tick(world *w)
{
    for (size_t k = 0; k < w->lively.count; k++) w->interests.at[w->lively.at[k]].all = false;
}

/* What is not saved follows from what is. */
void interest_restored(world *w)
{
    w->asking = (interest_counts){0};
    w->told_in_common = SIZE_MAX;
    for (uint32_t id = 0; id < w->interests.count; id++) {
        interest *i = &w->interests.at[id];
        i->lively = i->listed = false;
        if (!i->used) continue;
        count_one(&w->asking, i, 1);
        i->snapshot |= i->snapping; /* whoever waits for it is told from the beginning */
        i->snapping = false;
        interest_wake(w, id);
        w->olds += i->olds;
        if (i->changed || i->closing || i->olds) array_push(&w->changed_interests, id);
        i->listed = i->settling != SETTLED;
        if (i->listed) array_push(&w->unsettled, id);
    }
    publish_counts(w); /* poses may come before the first tick */
}
