/* filter_rule: one of the rules by which a body says which others it is held against. */
#ifndef COLLIDED_WORLD_FILTER_RULE_H
#define COLLIDED_WORLD_FILTER_RULE_H

#include <stdbool.h>

typedef struct filter_rule {
    const char *pattern; /* the other body's name ('*', '?'), or "group:" and its group */
    bool allow;          /* true: touching is allowed, the pair is not looked at */
    const char *reason;
    /* For the pairs that it checks; where rules of both bodies say something, the larger number counts. */
    double padding; /* m, added to a subscription's threshold; may be negative */
    double margin;  /* m, >= 0, added to a subscription's range */
} filter_rule;

#endif
