/* plain_filter: patterns and rules one by one; see plain_filter.c. */
#ifndef COLLIDED_TESTS_WORLD_PLAIN_FILTER_H
#define COLLIDED_TESTS_WORLD_PLAIN_FILTER_H

#include "world/world.h"

#include <stdbool.h>
#include <stddef.h>

/* '*' = any run of characters, '?' = any one. "group:PATTERN" is held against the group instead of the name. */
bool filter_matches(const char *pattern, const char *name, const char *group);

/* The first rule that matches the other body, or NULL. */
const filter_rule *filter_first(const filter_rule *rules, size_t count, const char *name, const char *group);

#endif
