/* match: selectors, selections, classes, and what two classes are wanted by. */
#include "match.h"

#include "base/hash.h"
#include "base/secret.h"
#include "base/sort.h"

#include <stdlib.h>

void match_init(match *m)
{
    *m = (match){.generation = 1, .edition = 1, .pass = 1, .steps_a_tick = MATCH_STEPS_A_TICK};
    pattern_set_init(&m->settled, false);
    pattern_set_init(&m->pending, false);
    pair_map_init(&m->selector_of);
    pair_map_init(&m->selection_of);
    pair_map_init(&m->class_of);
    pair_map_init(&m->list_of);
    id_pool_init(&m->selector_ids);
    id_pool_init(&m->selection_ids);
    id_pool_init(&m->class_ids);
    id_pool_take(&m->class_ids);
    array_push(&m->classes, ((match_class){.next = PAIR_MAP_NONE}));
    array_push(&m->lists, ((match_list){.count = 0}));
}

static void free_lists(match *m)
{
    for (size_t i = 1; i < m->lists.count; i++)
        if (m->lists.at[i].own) free((uint32_t *)m->lists.at[i].at);
    m->lists.count = 1;
    m->own_ids = 0;
    pair_map_free(&m->list_of);
    pair_map_init(&m->list_of);
}

void match_free(match *m)
{
    free_lists(m);
    array_free(&m->lists);
    pattern_set_free(&m->settled);
    pattern_set_free(&m->pending);
    for (size_t i = 0; i < m->selectors.count; i++)
        for (int side = 0; side < 2; side++) array_free(&m->selectors.at[i].sides[side]);
    for (size_t i = 0; i < m->selections.count; i++) array_free(&m->selections.at[i].ids);
    for (size_t i = 0; i < m->classes.count; i++) free(m->classes.at[i].selectors);
    array_free(&m->selectors);
    array_free(&m->selections);
    array_free(&m->classes);
    array_free(&m->touched);
    array_free(&m->concerned);
    array_free(&m->next);
    array_free(&m->unmatched);
    array_free(&m->found);
    array_free(&m->scratch);
    id_pool_free(&m->selector_ids);
    id_pool_free(&m->selection_ids);
    id_pool_free(&m->class_ids);
    pair_map_free(&m->selector_of);
    pair_map_free(&m->selection_of);
    pair_map_free(&m->class_of);
    pair_map_free(&m->list_of);
}

/* ---- how far subscriptions reach ---- */

/* The boxes of both bodies of a pair are widened by half of what is asked of it, so that together they never miss it;
 * what a rule adds is carried by the body whose rule it is, alone. */
static match_reach reach_of_subscription(const subscription *i)
{
    double most = 0;
    if (i->facts & WORLD_DISTANCE) most = fmax(most, i->range);
    if (i->facts & (WORLD_TOUCH | WORLD_MANIFOLD | WORLD_IMPACT | WORLD_PREDICT)) most = fmax(most, i->threshold);
    return (match_reach){.ranges = {{.fixed = 0.5 * (most + i->hysteresis + i->tolerance),
                             .relative = i->tolerance > 0 ? 0 : i->relative_tolerance}},
        .range_count = 1,
        .impacts = i->facts & WORLD_IMPACT,
        .horizon = i->facts & WORLD_PREDICT ? i->horizon : 0};
}

/* Of more than there is room for, the last two become one that is no less than either: boxes may be wider than asked.
 */
static void add_range(match_reach *to, match_range r)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < to->range_count; i++) {
        match_range at = to->ranges[i];
        if (at.fixed >= r.fixed && at.relative >= r.relative) return;
        if (at.fixed > r.fixed || at.relative > r.relative) to->ranges[kept++] = at;
    }
    to->range_count = kept;
    if (kept < MATCH_RANGES) {
        to->ranges[to->range_count++] = r;
        return;
    }
    match_range *last = &to->ranges[kept - 1];
    *last = (match_range){fmax(last->fixed, r.fixed), fmax(last->relative, r.relative)};
}

static void add_reach(match_reach *to, const match_reach *more)
{
    for (uint32_t i = 0; i < more->range_count; i++) add_range(to, more->ranges[i]);
    to->impacts |= more->impacts;
    to->horizon = fmax(to->horizon, more->horizon);
}

static const match_reach *reach_of_selector(match *m, uint32_t id)
{
    match_selector *s = &m->selectors.at[id];
    if (s->reach_known) return &s->reach;
    s->reach = (match_reach){.range_count = 0};
    s->reach_known = true;
    for (int side = 0; side < 2; side++)
        for (size_t i = 0; i < s->sides[side].count; i++)
            add_reach(&s->reach, &m->selections.at[s->sides[side].at[i]].reach);
    return &s->reach;
}

const match_reach *match_class_reach(match *m, uint32_t id)
{
    match_class *c = &m->classes.at[id];
    if (c->reach_of == m->generation) return &c->reach;
    c->reach = (match_reach){.range_count = 0};
    c->reach_of = m->generation;
    for (uint32_t i = 0; i < c->count; i++) add_reach(&c->reach, reach_of_selector(m, c->selectors[i]));
    return &c->reach;
}

/* ---- selectors ---- */

static uint64_t hash_of_pattern(const pattern *p)
{
    uint64_t h = hash_bytes(secret() + p->of_group, p->text, p->length);
    return h ? h : 1;
}

static uint64_t next_key(uint64_t key)
{
    return key + 1 ? key + 1 : 1;
}

static const pattern *pattern_of(const match *m, uint32_t id)
{
    const pattern_set *s = pattern_set_has(&m->settled, id) ? &m->settled : &m->pending;
    return &s->entries.at[id].pattern;
}

static uint32_t find_selector(const match *m, const pattern *p, uint64_t *key)
{
    uint32_t id;
    *key = hash_of_pattern(p);
    while ((id = pair_map_get(&m->selector_of, *key)) != PAIR_MAP_NONE && !pattern_same(pattern_of(m, id), p))
        *key = next_key(*key);
    return id;
}

/* Those behind it that were probed past it move up. */
static void forget_selector(match *m, uint32_t id)
{
    uint64_t key;
    uint32_t moved;
    find_selector(m, pattern_of(m, id), &key);
    pair_map_remove(&m->selector_of, key);
    for (key = next_key(key); (moved = pair_map_get(&m->selector_of, key)) != PAIR_MAP_NONE; key = next_key(key)) {
        uint64_t home;
        pair_map_remove(&m->selector_of, key);
        find_selector(m, pattern_of(m, moved), &home);
        pair_map_put(&m->selector_of, home, moved);
    }
}

static uint32_t look_up(const match *m, const char *text, uint64_t *key)
{
    pattern p;
    pattern_init(&p, text);
    uint32_t id = find_selector(m, &p, key);
    pattern_free(&p);
    return id;
}

void match_place_selector(match *m, uint32_t id, const char *text)
{
    uint64_t key;
    look_up(m, text, &key);
    pattern_set_add(m->selectors.at[id].pending ? &m->pending : &m->settled, id, text);
    pair_map_put(&m->selector_of, key, id);
}

static uint32_t take_selector(match *m, const char *text)
{
    uint64_t key;
    uint32_t id = look_up(m, text, &key);
    if (id != PAIR_MAP_NONE) return id;
    id = id_pool_take(&m->selector_ids);
    array_reserve(&m->selectors, (size_t)id + 1);
    while (m->selectors.count <= id) m->selectors.at[m->selectors.count++] = (match_selector){.used = false};
    match_selector *s = &m->selectors.at[id];
    s->used = s->live = s->pending = true;
    s->reach_known = false;
    s->bodies = 0;
    match_place_selector(m, id, text);
    return id;
}

/* Nobody selects by it any more: no name is held against it, and it is gone when no body has it. */
static void retire_selector(match *m, uint32_t id)
{
    match_selector *s = &m->selectors.at[id];
    forget_selector(m, id);
    pattern_set_remove(s->pending ? &m->pending : &m->settled, id);
    s->live = s->pending = false;
}

/* ---- selections ---- */

static uint64_t selection_key(uint32_t a, uint32_t b)
{
    return ((uint64_t)a + 1) << 32 | ((uint64_t)b + 1);
}

static uint32_t take_selection(match *m, uint32_t a, uint32_t b)
{
    uint32_t id = pair_map_get(&m->selection_of, selection_key(a, b));
    if (id != PAIR_MAP_NONE) return id;
    id = id_pool_take(&m->selection_ids);
    array_reserve(&m->selections, (size_t)id + 1);
    while (m->selections.count <= id) m->selections.at[m->selections.count++] = (match_selection){.used = false};
    match_selection *s = &m->selections.at[id];
    *s = (match_selection){.used = true, .selectors = {a, b}, .ids = s->ids};
    s->ids.count = 0;
    for (int side = 0; side < 2; side++) {
        match_selector *of = &m->selectors.at[s->selectors[side]];
        s->places[side] = (uint32_t)of->sides[side].count;
        array_push(&of->sides[side], id);
    }
    pair_map_put(&m->selection_of, selection_key(a, b), id);
    return id;
}

static void drop_selection(match *m, uint32_t id)
{
    match_selection *s = &m->selections.at[id];
    pair_map_remove(&m->selection_of, selection_key(s->selectors[0], s->selectors[1]));
    for (int side = 0; side < 2; side++) {
        match_selector *of = &m->selectors.at[s->selectors[side]];
        uint32_t moved = of->sides[side].at[--of->sides[side].count];
        of->sides[side].at[s->places[side]] = moved;
        m->selections.at[moved].places[side] = s->places[side];
        of->reach_known = false;
    }
    for (int side = 0; side < 2; side++) {
        match_selector *of = &m->selectors.at[s->selectors[side]];
        if (of->live && !of->sides[0].count && !of->sides[1].count) retire_selector(m, s->selectors[side]);
    }
    s->used = false;
    id_pool_give(&m->selection_ids, id);
}

static void touch(match *m, uint32_t id)
{
    match_selection *s = &m->selections.at[id];
    if (!s->touched) array_push(&m->touched, id);
    s->touched = true;
}

static void join_selection(world *w, uint32_t subscription_id, uint32_t a, uint32_t b)
{
    match *m = &w->match;
    uint32_t id = take_selection(m, a, b);
    match_selection *s = &m->selections.at[id];
    w->subscriptions.at[subscription_id].selection = id;
    s->subscriptions++;
    array_push(&s->ids, subscription_id);
    touch(m, id);
}

/* To find the pairs that are wanted now, or no more, it is enough to put the bodies of one of the two again: those that
 * come to match a new pattern are put anyway, and of two old ones the fewer. */
static void concern(match *m, uint32_t a, uint32_t b)
{
    const match_selector *x = &m->selectors.at[a], *y = &m->selectors.at[b];
    bool first = x->pending || (!y->pending && x->bodies <= y->bodies);
    match_next_pass(m, a, first);
    match_next_pass(m, b, !first);
}

void match_attach(world *w, uint32_t subscription_id)
{
    match *m = &w->match;
    const subscription *i = &w->subscriptions.at[subscription_id];
    uint32_t a = take_selector(m, i->select_a), b = take_selector(m, i->select_b);
    join_selection(w, subscription_id, a, b);
    concern(m, a, b);
}

bool match_reattach(world *w, uint32_t subscription_id)
{
    uint64_t key;
    const subscription *i = &w->subscriptions.at[subscription_id];
    uint32_t a = look_up(&w->match, i->select_a, &key), b = look_up(&w->match, i->select_b, &key);
    if (a == PAIR_MAP_NONE || b == PAIR_MAP_NONE) return false;
    join_selection(w, subscription_id, a, b);
    return true;
}

void match_detach(world *w, uint32_t subscription_id)
{
    match *m = &w->match;
    subscription *i = &w->subscriptions.at[subscription_id];
    if (i->selection == WORLD_NONE) return;
    match_selection *s = &m->selections.at[i->selection];
    s->subscriptions--;
    touch(m, i->selection);
    concern(m, s->selectors[0], s->selectors[1]);
    i->selection = WORLD_NONE;
}

/* A subscription that came, went and came again is there once. */
static void tidy(world *w, uint32_t id)
{
    match_selection *s = &w->match.selections.at[id];
    size_t kept = 0, count = s->ids.count;
    array_reserve(&w->match.scratch, 2 * count);
    for (size_t i = 0; i < count; i++) w->match.scratch.at[i] = s->ids.at[i];
    sort_keys(w->match.scratch.at, w->match.scratch.at + count, count);
    s->reach = (match_reach){.range_count = 0};
    for (size_t i = 0; i < count; i++) {
        uint32_t at = (uint32_t)w->match.scratch.at[i];
        const subscription *x = &w->subscriptions.at[at];
        if (!x->used || x->selection != id || (kept && s->ids.at[kept - 1] == at)) continue;
        match_reach reach = reach_of_subscription(x);
        add_reach(&s->reach, &reach);
        s->ids.at[kept++] = at;
    }
    s->ids.count = kept;
    for (int side = 0; side < 2; side++) w->match.selectors.at[s->selectors[side]].reach_known = false;
}

static void drop_idle_classes(match *m)
{
    for (uint32_t id = 1; id < m->classes.count; id++) {
        match_class *c = &m->classes.at[id];
        if (c->bodies || !c->selectors) continue;
        uint32_t *link = NULL, first = pair_map_get(&m->class_of, c->hash);
        if (first == id && c->next == PAIR_MAP_NONE) {
            pair_map_remove(&m->class_of, c->hash);
        } else if (first == id) {
            pair_map_put(&m->class_of, c->hash, c->next);
        } else {
            for (link = &m->classes.at[first].next; *link != id;) link = &m->classes.at[*link].next;
            *link = c->next;
        }
        free(c->selectors);
        *c = (match_class){.next = PAIR_MAP_NONE};
        id_pool_give(&m->class_ids, id);
    }
    m->idle_classes = 0;
}

static void new_edition(match *m)
{
    if (++m->edition == 0) m->edition = 1;
}

enum { IDLE_CLASSES = 1024 };             /* are kept, beside as many as there are in use */
enum { OWN_IDS_MOST = 16 * 1024 * 1024 }; /* 64 MB of lists: with more, those that are needed are made anew */

void match_refresh(world *w)
{
    match *m = &w->match;
    bool crowded = m->idle_classes > IDLE_CLASSES + m->classes.count / 2;
    if (!m->touched.count && !crowded && m->own_ids <= OWN_IDS_MOST) return;
    for (size_t i = 0; i < m->touched.count; i++) {
        match_selection *s = &m->selections.at[m->touched.at[i]];
        s->touched = false;
        if (s->subscriptions)
            tidy(w, m->touched.at[i]);
        else
            drop_selection(m, m->touched.at[i]);
    }
    m->touched.count = 0;
    if (crowded) drop_idle_classes(m);
    free_lists(m);
    m->generation++;
    new_edition(m);
}

/* ---- classes ---- */

bool match_class_has(const match *m, uint32_t id, uint32_t selector)
{
    const match_class *c = &m->classes.at[id];
    uint32_t from = 0, to = c->count;
    while (from < to) {
        uint32_t middle = (from + to) / 2;
        if (c->selectors[middle] < selector)
            from = middle + 1;
        else
            to = middle;
    }
    return from < c->count && c->selectors[from] == selector;
}

static uint32_t new_class(match *m, uint64_t hash, const uint32_t *ids, uint32_t count)
{
    uint32_t id = id_pool_take(&m->class_ids);
    array_reserve(&m->classes, (size_t)id + 1);
    if (id >= m->classes.count) m->classes.count = (size_t)id + 1;
    match_class *c = &m->classes.at[id];
    *c = (match_class){.selectors = base_alloc(count, sizeof *ids), .count = count, .hash = hash};
    memcpy(c->selectors, ids, count * sizeof *ids);
    c->next = pair_map_get(&m->class_of, hash);
    pair_map_put(&m->class_of, hash, id);
    m->idle_classes++;
    return id;
}

/* Of what is in m->found, in any order. */
uint32_t match_class_of_found(match *m)
{
    uint32_t *ids = m->found.at, count = (uint32_t)m->found.count;
    if (!count) return 0;
    if (count > 1) qsort(ids, count, sizeof *ids, sort_compare_u32);
    uint32_t kept = 1;
    for (uint32_t i = 1; i < count; i++)
        if (ids[i] != ids[kept - 1]) ids[kept++] = ids[i];
    uint64_t hash = hash_words(secret(), ids, kept * sizeof *ids);
    if (!hash) hash = 1;
    for (uint32_t id = pair_map_get(&m->class_of, hash); id != PAIR_MAP_NONE; id = m->classes.at[id].next) {
        const match_class *c = &m->classes.at[id];
        if (c->count == kept && memcmp(c->selectors, ids, kept * sizeof *ids) == 0) return id;
    }
    return new_class(m, hash, ids, kept);
}

uint32_t match_find_class(match *m, const char *name, const char *group, size_t *tried)
{
    m->found.count = 0;
    *tried += pattern_set_find(&m->settled, name, group, &m->found);
    *tried += pattern_set_find(&m->pending, name, group, &m->found);
    return match_class_of_found(m);
}

uint32_t match_renew_class(match *m, uint32_t id, const char *name, const char *group, size_t *tried)
{
    const match_class *c = &m->classes.at[id];
    m->found.count = 0;
    for (uint32_t i = 0; i < c->count; i++)
        if (m->selectors.at[c->selectors[i]].live) array_push(&m->found, c->selectors[i]);
    bool same = m->found.count == c->count;
    size_t kept = m->found.count;
    if (m->pending.count && name) *tried += pattern_set_find(&m->pending, name, group, &m->found);
    return same && m->found.count == kept ? id : match_class_of_found(m);
}

static void count_bodies(match *m, uint32_t id, size_t by)
{
    const match_class *c = &m->classes.at[id];
    for (uint32_t i = 0; i < c->count; i++) m->selectors.at[c->selectors[i]].bodies += by;
}

void match_change_class(match *m, uint32_t *of_body, uint32_t to)
{
    if (*of_body == to) return;
    new_edition(m);
    count_bodies(m, to, 1);
    count_bodies(m, *of_body, (size_t)-1);
    m->idle_classes -= to && !m->classes.at[to].bodies;
    m->classes.at[to].bodies += to != 0;
    m->classes.at[*of_body].bodies -= *of_body != 0;
    m->idle_classes += *of_body && !m->classes.at[*of_body].bodies;
    *of_body = to;
}

const match_class *match_concern(match *m, uint32_t id)
{
    match_class *c = &m->classes.at[id];
    if (c->concern_of == m->pass) return c;
    c->concern_of = m->pass;
    c->concerned = c->marked = false;
    for (uint32_t i = 0; i < c->count; i++) {
        c->concerned |= m->selectors.at[c->selectors[i]].concerned;
        c->marked |= m->selectors.at[c->selectors[i]].marked;
    }
    return c;
}

/* ---- who wants ---- */

/* Those of the selections in m->found, each once. */
static match_list list_of_found(match *m)
{
    size_t count = 0, kept = 0;
    if (m->found.count > 1) qsort(m->found.at, m->found.count, sizeof *m->found.at, sort_compare_u32);
    for (size_t i = 0; i < m->found.count; i++)
        if (!i || m->found.at[i] != m->found.at[kept - 1]) m->found.at[kept++] = m->found.at[i];
    m->found.count = kept;
    if (!kept) return (match_list){.count = 0};
    const match_selection *first = &m->selections.at[m->found.at[0]];
    if (kept == 1) return (match_list){first->ids.at, (uint32_t)first->ids.count, false};
    for (size_t i = 0; i < kept; i++) count += m->selections.at[m->found.at[i]].ids.count;
    array_reserve(&m->scratch, 2 * count);
    count = 0;
    for (size_t i = 0; i < kept; i++) {
        const match_selection *s = &m->selections.at[m->found.at[i]];
        for (size_t k = 0; k < s->ids.count; k++) m->scratch.at[count++] = s->ids.at[k];
    }
    sort_keys(m->scratch.at, m->scratch.at + count, count);
    uint32_t *ids = base_alloc(count, sizeof *ids);
    m->own_ids += count;
    for (size_t i = 0; i < count; i++) ids[i] = (uint32_t)m->scratch.at[i];
    return (match_list){ids, (uint32_t)count, true};
}

match_list match_of_class(match *m, uint32_t id)
{
    static const match_list NOBODY = {0};
    match_list all;
    const match_class *c = &m->classes.at[id];
    m->found.count = 0;
    for (uint32_t i = 0; i < c->count; i++)
        for (int side = 0; side < 2; side++) {
            const match_selector *s = &m->selectors.at[c->selectors[i]];
            for (size_t k = 0; k < s->sides[side].count; k++) array_push(&m->found, s->sides[side].at[k]);
        }
    all = list_of_found(m);
    if (!all.own) return all.count ? all : NOBODY;
    array_push(&m->lists, all); /* until match_refresh */
    return all;
}

static void add_selection(match *m, uint32_t a, uint32_t b)
{
    uint32_t id = pair_map_get(&m->selection_of, selection_key(a, b));
    if (id != PAIR_MAP_NONE) array_push(&m->found, id);
}

static size_t selections_of(const match *m, const match_class *c)
{
    size_t count = 0;
    for (uint32_t i = 0; i < c->count; i++)
        count += m->selectors.at[c->selectors[i]].sides[0].count + m->selectors.at[c->selectors[i]].sides[1].count;
    return count;
}

/* Each two selectors are looked up, or where those have fewer selections, each of these. */
static void find_selections(match *m, uint32_t a, uint32_t b)
{
    const match_class *x = &m->classes.at[a], *y = &m->classes.at[b];
    m->found.count = 0;
    if (2 * (size_t)x->count * y->count <= selections_of(m, x)) {
        for (uint32_t i = 0; i < x->count; i++)
            for (uint32_t k = 0; k < y->count; k++) {
                add_selection(m, x->selectors[i], y->selectors[k]);
                add_selection(m, y->selectors[k], x->selectors[i]);
            }
        return;
    }
    for (uint32_t i = 0; i < x->count; i++)
        for (int side = 0; side < 2; side++) {
            const match_selector *s = &m->selectors.at[x->selectors[i]];
            for (size_t k = 0; k < s->sides[side].count; k++) {
                uint32_t id = s->sides[side].at[k];
                if (match_class_has(m, b, m->selections.at[id].selectors[!side])) array_push(&m->found, id);
            }
        }
}

uint32_t match_search(match *m, uint32_t a, uint32_t b)
{
    if (!a || !b) return 0;
    uint64_t key = a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
    uint32_t list = pair_map_get(&m->list_of, key);
    if (list == PAIR_MAP_NONE) {
        bool turned = selections_of(m, &m->classes.at[b]) < selections_of(m, &m->classes.at[a]);
        find_selections(m, turned ? b : a, turned ? a : b);
        match_list wanted = list_of_found(m);
        list = wanted.count ? (uint32_t)m->lists.count : 0;
        if (list) array_push(&m->lists, wanted);
        pair_map_put(&m->list_of, key, list);
    }
    m->near[(a * 31 + b) % MATCH_NEAR] = (match_near){a, b, list, (uint32_t)m->generation};
    return list;
}
