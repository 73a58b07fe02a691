/* match_pass: bodies are looked at for subscriptions that are new, changed or gone, so many steps a tick, counted, so
 * that a replay and a standby stop at the same body. Tick thread.
 *
 * A pass goes once through all bodies, in the order of their ids, for all selectors that were concerned when it began;
 * those that come meanwhile wait for the next one. Until its pass has ended a subscription is unsettled: what it is
 * told is true, but not all, and it has no snapshot. A body that is put is held against all patterns at once; where
 * many have been tried since the last tick, it waits, is in no subscription's pairs until then, and all subscriptions
 * get a report that something is undone. */
#include "match.h"
#include "subscription.h"

#include "base/hash.h"
#include "state.h"

#include <stdio.h>
#include <stdlib.h>

enum {                    /* a step is some nanoseconds */
    STEPS_A_LOOK = 20,    /* at a body, which is some lines of memory */
    STEPS_A_TRY = 20,     /* of one name against one pattern */
    STEPS_A_BODY = 50,    /* whose boxes are put again, with the look at its neighbours; ... */
    STEPS_A_SHAPE = 20,   /* ... for each of its shapes, and of their children */
    TRIES_OF_PUTS = 20000 /* of bodies that are put between two ticks, at most, but for bodies with few */
};
enum { FEW_TRIES = 64 };

/* ---- bodies ---- */

/* Whether it is asked for otherwise than before. */
static bool widen(world *w, body *b)
{
    double was = b->widen, horizon = b->horizon;
    bool impacts = b->impacts;
    const match_reach *r = match_class_reach(&w->match, b->match);
    double reach = 0;
    b->widen = 0;
    for (size_t i = 0; i < b->shape_count; i++) {
        double of_shape = w->colliders.at[b->shapes[i]].reach;
        if (isfinite(of_shape)) reach = fmax(reach, of_shape);
    }
    for (uint32_t i = 0; i < r->range_count; i++)
        b->widen = fmax(b->widen, r->ranges[i].fixed + r->ranges[i].relative * reach + b->rule_reach);
    if (r->impacts && !impacts) b->past_since = w->figures.ticks; /* nobody asked where it was until now */
    b->impacts = r->impacts;
    b->horizon = r->horizon;
    return b->widen != was || b->horizon != horizon || b->impacts != impacts;
}

static void classify(world *w, body *b, size_t *tried)
{
    uint32_t class = match_find_class(&w->match, b->name, b->group, tried);
    w->rematched |= class != b->match;
    match_change_class(&w->match, &b->match, class);
    b->matched = true;
}

void match_hold_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    w->rematched |= b->match != 0;
    match_change_class(&w->match, &b->match, 0);
    b->matched = false;
}

void match_free_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    if (b->matched || b->queued) return;
    array_push(&w->match.unmatched, id);
    b->queued = true;
}

void match_put_body(world *w, uint32_t id)
{
    match *m = &w->match;
    body *b = &w->bodies.at[id];
    if (!b->matched && leaving_holds(w, b)) {
        match_hold_body(w, id);
    } else if (!b->matched && (m->tried <= TRIES_OF_PUTS || m->settled.count + m->pending.count <= FEW_TRIES)) {
        classify(w, b, &m->tried);
    } else if (!b->matched) {
        w->rematched |= b->match != 0;
        match_change_class(m, &b->match, 0); /* what it had matched is not what it matches */
        if (!b->queued) array_push(&m->unmatched, id);
        b->queued = true;
    }
    widen(w, b);
}

/* Few shapes are part of what a body takes. */
static size_t steps_of_put(const world *w, uint32_t id)
{
    enum { FEW = 8 };
    size_t shapes = world_body_shapes(w, id);
    return STEPS_A_BODY + (shapes > FEW ? STEPS_A_SHAPE * shapes : 0);
}

static size_t match_queued(world *w, size_t steps)
{
    match *m = &w->match;
    while (m->first_unmatched < m->unmatched.count && steps < m->steps_a_tick) {
        uint32_t id = m->unmatched.at[m->first_unmatched++];
        body *b = &w->bodies.at[id];
        size_t tried = 0;
        if (!b->queued) continue; /* it is gone, and another has its place */
        b->queued = false;
        if (!b->used || b->ghost || b->matched || leaving_holds(w, b)) continue;
        classify(w, b, &tried);
        widen(w, b);
        body_mark_dirty(w, id, true);
        steps += STEPS_A_TRY * tried + steps_of_put(w, id);
    }
    if (m->first_unmatched < m->unmatched.count) return steps;
    m->unmatched.count = m->first_unmatched = 0;
    return steps;
}

/* ---- passes ---- */

void match_next_pass(match *m, uint32_t id, bool marked)
{
    match_selector *s = &m->selectors.at[id];
    if (!s->next) array_push(&m->next, id);
    s->next = true;
    s->next_marked |= marked;
}

static void begin_pass(world *w)
{
    match *m = &w->match;
    m->concerned.count = 0;
    for (size_t i = 0; i < m->next.count; i++) {
        match_selector *s = &m->selectors.at[m->next.at[i]];
        s->concerned = true;
        s->marked = s->next_marked;
        s->next = s->next_marked = false;
        array_push(&m->concerned, m->next.at[i]);
    }
    m->next.count = 0;
    m->cursor = 0;
    m->pass++;
    m->passing = true;
    subscription_pass_began(w);
}

static char *text_of(const pattern *p)
{
    size_t size = p->length + sizeof "group:";
    char *text = base_alloc(size, 1);
    snprintf(text, size, "%s%s", p->of_group ? "group:" : "", p->text);
    return text;
}

/* All have been held against it. */
static void settle_selector(match *m, uint32_t id)
{
    const pattern *p = &m->pending.entries.at[id].pattern;
    char *text = text_of(p);
    pattern_set_remove(&m->pending, id);
    pattern_set_add(&m->settled, id, text);
    m->selectors.at[id].pending = false;
    free(text);
}

static void end_pass(world *w)
{
    match *m = &w->match;
    for (size_t i = 0; i < m->concerned.count; i++) {
        uint32_t id = m->concerned.at[i];
        match_selector *s = &m->selectors.at[id];
        s->concerned = s->marked = false;
        if (s->pending) settle_selector(m, id);
        if (s->live || s->next) continue;
        s->used = false;
        id_pool_give(&m->selector_ids, id);
    }
    m->concerned.count = 0;
    m->passing = false;
    subscription_pass_ended(w);
}

/* What is put into the broad phase again has its pairs decided again, for those that want them now. A body that is
 * asked for from farther away, or less far, is put again for that alone. A ghost only gives up what nobody selects by
 * any more. */
static size_t look_at(world *w, uint32_t id)
{
    match *m = &w->match;
    enum { AHEAD = 16 }; /* bodies */
    body *b = &w->bodies.at[id], *later = &w->bodies.at[id + AHEAD < w->bodies.count ? id + AHEAD : id];
    size_t tried = 0;
    __builtin_prefetch(&later->matched);
    __builtin_prefetch(&later->name);
    if (!b->used || !b->matched) return STEPS_A_LOOK;
    uint32_t class = match_renew_class(m, b->match, b->ghost ? NULL : b->name, b->group, &tried);
    const match_class *c = match_concern(m, class);
    bool is_new = class != b->match, put = is_new || c->marked;
    match_change_class(m, &b->match, class);
    if (b->ghost) return STEPS_A_LOOK + STEPS_A_TRY * tried;
    w->rematched |= is_new;
    if (is_new || c->concerned) put |= widen(w, b);
    if (!put || (b->dirty && b->refilter)) return STEPS_A_LOOK + STEPS_A_TRY * tried;
    body_mark_dirty(w, id, true);
    return steps_of_put(w, id) + STEPS_A_TRY * tried;
}

void match_run(world *w)
{
    match *m = &w->match;
    size_t steps = match_queued(w, 0);
    m->tried = 0;
    while (steps < m->steps_a_tick && (m->passing || m->next.count)) {
        if (!m->passing) begin_pass(w);
        w->epoch++; /* other subscriptions in the pairs of a body than there were */
        while (m->cursor < w->bodies.count && steps < m->steps_a_tick) steps += look_at(w, m->cursor++);
        if (m->cursor == w->bodies.count) end_pass(w);
    }
}

bool match_is_unsettled(const match *m)
{
    return m->passing || m->next.count || m->first_unmatched < m->unmatched.count;
}

/* ---- saved ---- */

/* Selectors keep their ids, which the classes of bodies are written in; selections, classes and lists are made anew. */
void match_save(const world *w, bytes_out *to)
{
    const match *m = &w->match;
    bytes_put_count(to, m->selectors.count);
    for (uint32_t id = 0; id < m->selectors.count; id++) {
        const match_selector *s = &m->selectors.at[id];
        uint8_t flags = (uint8_t)(s->used | s->live << 1 | s->pending << 2 | s->concerned << 3 | s->next << 4 |
                                  s->marked << 5 | s->next_marked << 6);
        bytes_put(to, &flags, 1);
        if (!s->live) continue;
        char *text = text_of(&(s->pending ? &m->pending : &m->settled)->entries.at[id].pattern);
        bytes_put_text(to, text);
        free(text);
    }
    const uint64_t numbers[] = {m->passing, m->cursor, m->tried, m->unmatched.count - m->first_unmatched};
    bytes_put(to, numbers, sizeof numbers);
    for (size_t i = m->first_unmatched; i < m->unmatched.count; i++)
        bytes_put(to, &m->unmatched.at[i], sizeof *m->unmatched.at);
}

static void restore_selector(match *m, uint32_t id, uint8_t flags, const char *text)
{
    match_selector *s = &m->selectors.at[id];
    *s = (match_selector){.used = flags & 1,
        .live = flags >> 1 & 1,
        .pending = flags >> 2 & 1,
        .concerned = flags >> 3 & 1,
        .next = flags >> 4 & 1,
        .marked = flags >> 5 & 1,
        .next_marked = flags >> 6 & 1};
    if (s->live) match_place_selector(m, id, text);
    if (s->concerned) array_push(&m->concerned, id);
    if (s->next) array_push(&m->next, id);
}

const char *match_restore(world *w, bytes_in *from)
{
    match *m = &w->match;
    uint64_t numbers[4];
    size_t count = bytes_get_count(from, 1);
    array_reserve(&m->selectors, count + 1);
    m->selectors.count = count;
    for (uint32_t id = 0; id < count; id++) id_pool_take(&m->selector_ids);
    for (uint32_t id = 0; id < count; id++) {
        uint8_t flags;
        bytes_get(from, &flags, 1);
        restore_selector(m, id, flags, flags >> 1 & 1 ? bytes_get_text(from) : NULL);
        if (!(flags & 1)) id_pool_give(&m->selector_ids, id);
    }
    bytes_get(from, numbers, sizeof numbers);
    if (from->broken || numbers[3] > from->left / sizeof(uint32_t)) return "the patterns of subscriptions are cut off";
    m->passing = numbers[0];
    m->cursor = (uint32_t)numbers[1];
    m->tried = (size_t)numbers[2];
    array_reserve(&m->unmatched, (size_t)numbers[3] + 1);
    m->unmatched.count = (size_t)numbers[3];
    bytes_get(from, m->unmatched.at, m->unmatched.count * sizeof *m->unmatched.at);
    for (size_t i = 0; i < m->unmatched.count; i++)
        if (m->unmatched.at[i] >= w->bodies.count) return "a body that waits is not there";
    for (uint32_t id = 0; id < w->subscriptions.count; id++) {
        subscription *i = &w->subscriptions.at[id];
        i->selection = WORLD_NONE;
        if (i->used && !i->closing && !match_reattach(w, id)) return "a subscription's pattern is not there";
    }
    match_refresh(w);
    return NULL;
}

void match_save_class(const match *m, uint32_t id, bytes_out *to)
{
    const match_class *c = &m->classes.at[id];
    bytes_put_count(to, c->count);
    bytes_put(to, c->selectors, c->count * sizeof *c->selectors);
}

void match_restore_class(match *m, uint32_t *id, bytes_in *from)
{
    size_t count = bytes_get_count(from, sizeof(uint32_t));
    array_reserve(&m->found, count + 1);
    bytes_get(from, m->found.at, count * sizeof *m->found.at);
    m->found.count = 0;
    for (size_t i = 0; i < count; i++)
        if (m->found.at[i] < m->selectors.count) m->found.at[m->found.count++] = m->found.at[i];
    match_change_class(m, id, match_class_of_found(m));
}
