/* rules: which rule of a body is the first that matches another body. The patterns of a body's rules are a rule set,
 * shared by all bodies that have the same ones, and each is held against a name once. Tick thread. */
#ifndef COLLIDED_WORLD_RULES_H
#define COLLIDED_WORLD_RULES_H

#include "base/array.h"
#include "base/id_pool.h"
#include "base/pair_map.h"
#include "filter_rule.h"
#include "pattern.h"

typedef struct rule_set {
    pattern_set patterns; /* under their places in the list */
    uint64_t hash;
    uint32_t count, next; /* next: of the same hash */
    size_t bodies;        /* that have it */
    uint64_t number;      /* of world.rules.numbers: another set under the same id has another one */
    size_t price;
} rule_set;

typedef struct rule_answer { /* as long as the set has this number, and the other body this label */
    uint64_t set, other;
    uint32_t first;
} rule_answer;

typedef struct rule_sets {
    ARRAY(rule_set) sets; /* 0 is that of no rules */
    id_pool ids;
    pair_map set_of; /* hash -> the first set that has it */
    uint64_t numbers;
    size_t dear;          /* sets whose price is more than RULES_CHEAP */
    rule_answer *answers; /* by a hash of both; NULL: none was asked for */
    unsigned answers_log2;
    size_t answered; /* since it grew */
} rule_sets;

void rules_init(rule_sets *r);
void rules_free(rule_sets *r);
/* Instead of the set that it has. */
void rules_choose(rule_sets *r, uint32_t *set, const filter_rule *rules, size_t count);
/* The place of the first rule that matches, or PAIR_MAP_NONE; `label` is another number for another name or group. */
uint32_t rules_first(rule_sets *r, uint32_t set, uint64_t label, const char *name, const char *group);
/* Patterns that a name may have to be tried against, at most; 0 for no rules. A try takes some 10 to 100 ns. It follows
 * from the rules alone, whatever is remembered: what is counted by it is the same in a replay. */
enum { RULES_CHEAP = 64 };
static inline size_t rules_price(const rule_sets *r, uint32_t set)
{
    return r->sets.at[set].price;
}

#endif
