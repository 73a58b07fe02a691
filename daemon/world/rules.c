/* rules: sets are found by their content; what a set says of a name is kept in a table that only saves time: an answer
 * that another one has driven out is found again. */
#include "rules.h"

#include "base/hash.h"
#include "base/secret.h"

#include <stdlib.h>
#include <string.h>

enum { FEW_RULES = 8 };
enum { ANSWERS_FIRST_LOG2 = 14, ANSWERS_MOST_LOG2 = 18 };

void rules_init(rule_sets *r)
{
    *r = (rule_sets){.numbers = 0};
    id_pool_init(&r->ids);
    pair_map_init(&r->set_of);
    id_pool_take(&r->ids);
    array_push(&r->sets, ((rule_set){.next = PAIR_MAP_NONE}));
}

void rules_free(rule_sets *r)
{
    for (size_t i = 1; i < r->sets.count; i++) pattern_set_free(&r->sets.at[i].patterns);
    array_free(&r->sets);
    id_pool_free(&r->ids);
    pair_map_free(&r->set_of);
    free(r->answers);
}

static uint64_t hash_of(const filter_rule *rules, size_t count)
{
    uint64_t h = secret();
    for (size_t i = 0; i < count; i++) h = hash_bytes(h, rules[i].pattern, strlen(rules[i].pattern) + 1);
    return h ? h : 1;
}

static bool has_patterns(const rule_set *s, const filter_rule *rules, size_t count)
{
    if (s->count != count) return false;
    for (uint32_t i = 0; i < count; i++) {
        pattern p;
        pattern_init(&p, rules[i].pattern);
        bool same = pattern_same(&p, &s->patterns.entries.at[i].pattern);
        pattern_free(&p);
        if (!same) return false;
    }
    return true;
}

static uint32_t new_set(rule_sets *r, uint64_t hash, const filter_rule *rules, size_t count)
{
    uint32_t id = id_pool_take(&r->ids);
    array_reserve(&r->sets, (size_t)id + 1);
    if (id >= r->sets.count) r->sets.count = (size_t)id + 1;
    rule_set *s = &r->sets.at[id];
    *s = (rule_set){.hash = hash, .count = (uint32_t)count, .number = ++r->numbers};
    pattern_set_init(&s->patterns, count <= FEW_RULES);
    for (uint32_t i = 0; i < count; i++) pattern_set_add(&s->patterns, i, rules[i].pattern);
    s->price = pattern_set_price(&s->patterns);
    r->dear += s->price > RULES_CHEAP;
    s->next = pair_map_get(&r->set_of, hash);
    pair_map_put(&r->set_of, hash, id);
    return id;
}

static void drop_set(rule_sets *r, uint32_t id)
{
    rule_set *s = &r->sets.at[id];
    uint32_t first = pair_map_get(&r->set_of, s->hash);
    if (first != id) {
        while (r->sets.at[first].next != id) first = r->sets.at[first].next;
        r->sets.at[first].next = s->next;
    } else if (s->next != PAIR_MAP_NONE) {
        pair_map_put(&r->set_of, s->hash, s->next);
    } else {
        pair_map_remove(&r->set_of, s->hash);
    }
    r->dear -= s->price > RULES_CHEAP;
    pattern_set_free(&s->patterns);
    *s = (rule_set){.next = PAIR_MAP_NONE};
    id_pool_give(&r->ids, id);
}

static uint32_t find_set(rule_sets *r, const filter_rule *rules, size_t count)
{
    if (!count) return 0;
    uint64_t hash = hash_of(rules, count);
    for (uint32_t id = pair_map_get(&r->set_of, hash); id != PAIR_MAP_NONE; id = r->sets.at[id].next)
        if (has_patterns(&r->sets.at[id], rules, count)) return id;
    return new_set(r, hash, rules, count);
}

void rules_choose(rule_sets *r, uint32_t *set, const filter_rule *rules, size_t count)
{
    uint32_t chosen = find_set(r, rules, count), old = *set;
    r->sets.at[chosen].bodies += chosen != 0;
    *set = chosen;
    if (old && !--r->sets.at[old].bodies) drop_set(r, old);
}

/* ---- what was answered ---- */

/* Grows while answers drive each other out: each that is found makes it fuller. */
static void grow_answers(rule_sets *r)
{
    if (r->answers && (r->answers_log2 >= ANSWERS_MOST_LOG2 || r->answered < (size_t)1 << r->answers_log2)) return;
    free(r->answers);
    r->answers_log2 = r->answers ? r->answers_log2 + 2 : ANSWERS_FIRST_LOG2;
    r->answers = base_zalloc((size_t)1 << r->answers_log2, sizeof *r->answers);
    r->answered = 0;
}

static rule_answer *place_of_answer(const rule_sets *r, uint64_t set, uint64_t other)
{
    uint64_t h = (set * 0x9e3779b97f4a7c15u ^ other) * 0xbf58476d1ce4e5b9u;
    return &r->answers[h >> (64 - r->answers_log2)];
}

uint32_t rules_first(rule_sets *r, uint32_t set, uint64_t label, const char *name, const char *group)
{
    const rule_set *s = &r->sets.at[set];
    if (!set) return PAIR_MAP_NONE;
    grow_answers(r);
    rule_answer *a = place_of_answer(r, s->number, label);
    if (a->set == s->number && a->other == label) return a->first;
    *a = (rule_answer){s->number, label, pattern_set_first(&s->patterns, name, group)};
    r->answered++;
    return a->first;
}
