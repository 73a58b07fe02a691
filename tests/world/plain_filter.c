/* plain_filter: the grammar of patterns and the first rule that matches, in a few lines: what world/pattern.h and
 * world/rules.h are held against. */
#include "plain_filter.h"

#include <string.h>

/* On a mismatch only the last star is moved on: at most the text times the pattern. */
static bool glob(const char *pattern, const char *text)
{
    const char *star = NULL, *resume = NULL;
    while (*text) {
        if (*pattern == '*') {
            star = ++pattern;
            resume = text;
        } else if (*pattern == '?' || *pattern == *text) {
            pattern++, text++;
        } else if (star) {
            pattern = star;
            text = ++resume;
        } else {
            return false;
        }
    }
    while (*pattern == '*') pattern++;
    return !*pattern;
}

bool filter_matches(const char *pattern, const char *name, const char *group)
{
    static const char GROUP[] = "group:";
    if (strncmp(pattern, GROUP, sizeof GROUP - 1) == 0) return *group && glob(pattern + sizeof GROUP - 1, group);
    return glob(pattern, name);
}

const filter_rule *filter_first(const filter_rule *rules, size_t count, const char *name, const char *group)
{
    for (size_t i = 0; i < count; i++)
        if (filter_matches(rules[i].pattern, name, group)) return &rules[i];
    return NULL;
}
