/* pattern: name patterns made ready to be matched often, and sets of them that are matched at once. '*' = any run of
 * bytes, '?' = any one; "group:PATTERN" is held against the group instead of the name, and no group is not a group.
 * Nothing is shared: any thread, each with its own.
 *
 * One pattern costs at most the text times the pattern's length / 64, whatever its stars are. In a set, a pattern is
 * found by the literal text that it begins or ends with, so that a name costs in proportion to those that may match it;
 * those that begin and end with a wildcard are tried one after the other. */
#ifndef COLLIDED_WORLD_PATTERN_H
#define COLLIDED_WORLD_PATTERN_H

#include "base/array.h"
#include "base/pair_map.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct pattern {
    char *text;          /* its own, without "group:"; runs of stars are one */
    uint32_t length;     /* bytes */
    uint32_t head, tail; /* bytes in front of the first wildcard, and behind the last; without one both are `length` */
    uint32_t least;      /* bytes that a text has at least */
    bool of_group;       /* it is held against the group, which must not be "" */
    bool has_star, has_wildcard;
} pattern;

void pattern_init(pattern *p, const char *text);
void pattern_free(pattern *p);
/* Do both match the same texts, as far as can be seen? */
bool pattern_same(const pattern *a, const pattern *b);
bool pattern_matches(const pattern *p, const char *name, const char *group);

enum { PATTERN_KEY_MAX = 127 }; /* bytes of a head or a tail by which one is found */

typedef struct pattern_entry {
    pattern pattern;
    uint64_t key;            /* of its list, 0: it is one of the loose */
    uint32_t next, previous; /* of the same list; `next` of one of the loose is its place among them */
    uint8_t length;          /* of the head, or the tail, by which it is found */
    bool by_tail, used;
} pattern_entry;

typedef struct pattern_set { /* zeros = empty, but for pattern_set_init */
    ARRAY(pattern_entry) entries;
    pair_map lists;            /* of a head or a tail -> the first of those that have it */
    uint64_t lengths[2][2][2]; /* [group][tail], a bit a length: some have had a key of it */
    ARRAY(uint32_t) loose;     /* neither begin nor end with a literal; or all, where there are few */
    size_t count;
    bool few; /* no more than a look-up costs: all are tried */
} pattern_set;

void pattern_set_init(pattern_set *s, bool few);
void pattern_set_free(pattern_set *s);
/* Under an id that is not in it. Ids are dense. */
void pattern_set_add(pattern_set *s, uint32_t id, const char *text);
void pattern_set_remove(pattern_set *s, uint32_t id);
bool pattern_set_has(const pattern_set *s, uint32_t id);

typedef ARRAY(uint32_t) pattern_ids;

/* Those that match, in no order, behind what `found` has. Returns how many were tried, plus one. */
size_t pattern_set_find(const pattern_set *s, const char *name, const char *group, pattern_ids *found);
/* The least id that matches, or PAIR_MAP_NONE. */
uint32_t pattern_set_first(const pattern_set *s, const char *name, const char *group);
/* How many a name may have to be tried against, at most: what the set costs in the worst case. */
size_t pattern_set_price(const pattern_set *s);

#endif
