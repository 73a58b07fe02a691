/* interest: who wants to know what of which pairs, as bits on the bodies. Tick thread. */
#include "filter.h"
#include "state.h"

#include <stdlib.h>
#include <string.h>

static void set_bit(uint64_t *words, uint32_t bit, bool on)
{
    uint64_t mask = (uint64_t)1 << (bit & 63);
    words[bit >> 6] = on ? words[bit >> 6] | mask : words[bit >> 6] & ~mask;
}

static bool get_bit(const uint64_t *words, uint32_t bit)
{
    return words[bit >> 6] >> (bit & 63) & 1;
}

/* The boxes of both bodies of a pair are widened by half of what is asked of it, so that together they never miss it;
 * what a rule adds is carried by the body whose rule it is, alone. */
static double half_range(const interest *i, double reach)
{
    double most = 0, share = i->tolerance > 0 ? 0 : i->relative_tolerance * reach;
    if (i->facts & WORLD_DISTANCE) most = fmax(most, i->range);
    if (i->facts & (WORLD_TOUCH | WORLD_MANIFOLD | WORLD_IMPACT | WORLD_FORETELL)) most = fmax(most, i->threshold);
    return 0.5 * (most + i->hysteresis + i->tolerance) + share;
}

double interest_tolerance(const interest *i, double size)
{
    return i->tolerance > 0 ? i->tolerance : i->relative_tolerance * size;
}

static double most_reach(const world *w, const body *b)
{
    double most = 0;
    for (size_t i = 0; i < b->shape_count; i++) {
        double reach = w->solids.at[b->shapes[i]].reach;
        if (isfinite(reach)) most = fmax(most, reach);
    }
    return most;
}

static void widen_body(world *w, body *b)
{
    double reach = most_reach(w, b);
    b->widen = b->horizon = 0;
    b->impacts = false;
    for (size_t word = 0; word < w->words; word++)
        for (uint64_t bits = b->match_a[word] | b->match_b[word]; bits; bits &= bits - 1) {
            const interest *x = &w->interests.at[word * 64 + (size_t)__builtin_ctzll(bits)];
            if (!x->used) continue;
            b->widen = fmax(b->widen, half_range(x, reach) + b->rule_reach);
            b->impacts |= (x->facts & WORLD_IMPACT) != 0;
            if (x->facts & WORLD_FORETELL) b->horizon = fmax(b->horizon, x->horizon);
        }
}

static bool match_one(world *w, body *b, uint32_t id)
{
    const interest *i = &w->interests.at[id];
    bool on = i->used && !i->closing;
    bool a = on && filter_matches(i->select_a, b->name, b->group);
    bool c = on && filter_matches(i->select_b, b->name, b->group);
    bool was_a = get_bit(b->match_a, id), was_c = get_bit(b->match_b, id), concerned = a || c || was_a || was_c;
    w->rematched |= a != was_a || c != was_c;
    set_bit(b->match_a, id, a);
    set_bit(b->match_b, id, c);
    return concerned;
}

void interest_match_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    for (uint32_t i = 0; i < w->interests.count; i++) match_one(w, b, i);
    widen_body(w, b);
}

/* Interests of this word in which the two bodies are a pair, one as A and the other as B. */
uint64_t interest_word(const body *a, const body *b, size_t word)
{
    return (a->match_a[word] & b->match_b[word]) | (a->match_b[word] & b->match_a[word]);
}

bool interest_wants(const world *w, const body *a, const body *b)
{
    for (size_t word = 0; word < w->words; word++)
        if (interest_word(a, b, word)) return true;
    return false;
}

bool body_is_asked_for(const world *w, const body *b)
{
    for (size_t word = 0; word < w->words; word++)
        if (b->match_a[word] | b->match_b[word]) return true;
    return false;
}

static uint64_t *wider(uint64_t *words, size_t old, size_t count)
{
    uint64_t *bits = base_zalloc(count, sizeof *bits);
    memcpy(bits, words, old * sizeof *bits);
    free(words);
    return bits;
}

static void grow(world *w, size_t interests)
{
    size_t need = (interests + 63) / 64;
    if (need <= w->words) return;
    for (size_t i = 0; i < w->bodies.count; i++) {
        body *b = &w->bodies.at[i];
        if (!b->used) continue;
        b->match_a = wider(b->match_a, w->words, need);
        b->match_b = wider(b->match_b, w->words, need);
    }
    w->words = need;
}

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
    grow(w, w->interests.count);
    interest *i = &w->interests.at[id];
    *i = (interest){.used = true, .first_watch = WORLD_NONE};
    i->select_a = base_strdup("");
    i->select_b = base_strdup("");
    w->figures.interests++;
    return id;
}

world_status world_put_interest(world *w, uint32_t *id, const world_interest *def)
{
    bool is_new = *id == WORLD_NONE;
    if (is_new)
        *id = new_interest(w);
    else if (*id >= w->interests.count || !w->interests.at[*id].used || w->interests.at[*id].closing)
        return WORLD_UNKNOWN_ID;
    interest *i = &w->interests.at[*id];
    i->snapshot = true;
    w->changed = true;
    if (!is_new && same_interest(i, def)) return WORLD_OK;
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
    i->changed = true;
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
    w->interests.at[id].closing = w->interests.at[id].changed = true;
    w->interests.at[id].closing_cause = cause;
    w->changed = true;
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
}

void world_want_all(world *w, uint32_t id)
{
    if (id < w->interests.count && w->interests.at[id].used) w->interests.at[id].all = true;
}

/* What was told under the old terms of those that changed ends. */
static void close_changed(world *w)
{
    w->changed_interests.count = 0;
    for (uint32_t id = 0; id < w->interests.count; id++) {
        interest *i = &w->interests.at[id];
        if (!i->used || !i->changed) continue;
        i->changed = false;
        w->epoch++;
        events_close(w, id, i->closing ? i->closing_cause : (uint8_t)CAUSE_INTEREST);
        array_push(&w->changed_interests, id);
    }
}

/* Every body that the old or the new terms concern is looked at again. */
static void match_changed(world *w)
{
    if (!w->changed_interests.count) return;
    for (uint32_t k = 0; k < w->bodies.count; k++) {
        body *b = &w->bodies.at[k];
        bool concerned = false;
        if (!b->used || b->ghost) continue;
        for (size_t i = 0; i < w->changed_interests.count; i++)
            concerned |= match_one(w, b, w->changed_interests.at[i]);
        if (!concerned) continue;
        widen_body(w, b);
        body_mark_dirty(w, k, true);
    }
}

void interest_count(world *w)
{
    w->sweepers = w->askers = 0;
    w->bounds_asked = false;
    for (size_t id = 0; id < w->interests.count; id++) {
        const interest *i = &w->interests.at[id];
        bool asks = i->used && !i->closing && (i->facts & (WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD));
        if (asks && !w->askers++) w->first_asker = (uint32_t)id;
        w->bounds_asked |= asks && i->accuracy == WORLD_BY_BOXES;
        w->sweepers += i->used && !i->closing && (i->facts & (WORLD_IMPACT | WORLD_FORETELL));
    }
}

void interest_settle_changes(world *w)
{
    interest_count(w);
    close_changed(w);
    match_changed(w);
}

/* Those whose closing batch the last tick has told. */
void interest_finish(world *w)
{
    for (uint32_t id = 0; id < w->interests.count; id++) {
        interest *i = &w->interests.at[id];
        if (!i->used || !i->closing || i->changed) continue;
        free(i->select_a);
        free(i->select_b);
        array_free(&i->held);
        array_free(&i->events);
        *i = (interest){.used = false};
        id_pool_give(&w->interest_ids, id);
        w->figures.interests--;
    }
}
