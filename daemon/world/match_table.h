/* match_table: which subscriptions want which bodies. Names are held against patterns once a name and pattern, whatever
 * the number of subscriptions that share a pattern, and of bodies that are a pair.
 *
 * A selector is one pattern by which subscriptions select; a selection is two of them, A's and B's, and the
 * subscriptions that have these. The selectors that a body matches are its class, shared by all bodies that match the
 * same ones; which subscriptions want a pair follows from the classes of its two bodies, and is found once for each two
 * classes. So a body costs what it matches, a pair the same look-up whatever the number of subscriptions, and a
 * subscription under patterns that are known nothing until it is told of something. Tick thread, but for reading what a
 * pair's list says. */
#ifndef COLLIDED_WORLD_MATCH_TABLE_H
#define COLLIDED_WORLD_MATCH_TABLE_H

#include "base/array.h"
#include "base/id_pool.h"
#include "base/pair_map.h"
#include "pattern.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct match_range { /* m: a body of this reach is widened by fixed + relative * reach */
    double fixed, relative;
} match_range;

enum { MATCH_RANGES = 8 };

typedef struct match_reach { /* how far, how long and for what a body is asked for: the most of several subscriptions */
    match_range ranges[MATCH_RANGES];
    uint32_t range_count; /* none is less in both than another */
    bool impacts;
    double horizon; /* s */
} match_reach;

typedef struct match_selector {
    bool used, live;      /* live: subscriptions select by it; otherwise bodies may still have it, until a pass ends */
    bool pending;         /* not every body has been held against it */
    bool concerned, next; /* in the lists of this name, and ... */
    bool marked, next_marked; /* ... all its bodies are put again */
    size_t bodies;            /* that match it, as far as is known */
    ARRAY(uint32_t) sides[2]; /* selections in which it is A's, B's */
    bool reach_known;
    match_reach reach; /* of its subscriptions */
} match_selector;

typedef struct match_selection {
    bool used, touched;
    uint32_t selectors[2], places[2]; /* A's and B's, and where it is in their lists */
    size_t subscriptions;             /* that have it */
    ARRAY(uint32_t) ids;              /* of them, rising; while it is touched, with others and in disorder */
    match_reach reach;
} match_selection;

typedef struct match_class {
    uint32_t *selectors;  /* rising */
    uint32_t count, next; /* next: of the same hash */
    uint64_t hash;
    size_t bodies;
    uint64_t reach_of, concern_of; /* match.generation, match.pass, for which ... */
    match_reach reach;
    bool concerned, marked; /* ... by one of its selectors */
} match_class;

typedef struct match_list { /* subscriptions, by rising id */
    const uint32_t *at;
    uint32_t count;
    bool own; /* several selections' put together */
} match_list;

enum { MATCH_STEPS_A_TICK = 1000000 }; /* of some nanoseconds, at most: then a tick goes on with its other work */
enum { MATCH_NEAR = 256 };             /* look-ups of two classes that are remembered without a search */

typedef struct match_near {
    uint32_t a, b, list, generation;
} match_near;

typedef struct match {
    pattern_set settled, pending; /* of live selectors, by id */
    ARRAY(match_selector) selectors;
    id_pool selector_ids;
    pair_map selector_of; /* hash of a pattern -> selector; colliding hashes are probed on with the next key */

    ARRAY(match_selection) selections;
    id_pool selection_ids;
    pair_map selection_of;
    ARRAY(uint32_t) touched;

    ARRAY(match_class) classes; /* 0 is that of no selector */
    id_pool class_ids;
    pair_map class_of;   /* hash -> the first class that has it */
    size_t idle_classes; /* of no body */

    ARRAY(match_list) lists; /* 0 is empty */
    pair_map list_of;        /* of two classes */
    size_t own_ids;          /* in the lists of their own */
    match_near near[MATCH_NEAR];
    uint64_t generation; /* counts changes of selections, from 1: lists and reaches of another are void */
    uint32_t edition;    /* likewise, and bodies' changes of class: what pairs are wanted by in another is void */

    /* A pass looks at each body for all selectors that are concerned: see match_pass.c. */
    ARRAY(uint32_t) concerned, next; /* in the pass that is under way, and in the next one */
    uint64_t pass;                   /* counts them, from 1 */
    bool passing;
    uint32_t cursor;           /* bodies before it have been looked at */
    ARRAY(uint32_t) unmatched; /* bodies that were put when too many patterns had been tried in this tick */
    size_t first_unmatched;    /* of these */
    size_t tried;              /* patterns against names of bodies that were put, since the last tick */

    size_t steps_a_tick; /* of passes: see match_pass.c */
    pattern_ids found;   /* scratch */
    ARRAY(uint64_t) scratch;
} match;

/* What two bodies of these classes are wanted by, as an index of match.lists, until match_refresh. */
uint32_t match_search(match *m, uint32_t a, uint32_t b);
static inline uint32_t match_wanted(match *m, uint32_t a, uint32_t b)
{
    const match_near *n = &m->near[(a * 31 + b) % MATCH_NEAR];
    return n->a == a && n->b == b && n->generation == (uint32_t)m->generation ? n->list : match_search(m, a, b);
}

#endif
