/* metrics: the table of counters. Registering is for one thread, at start; counting and reading are for any. Each
 * metric has memory of its own, so that its address outlives the growth of the table. */
#include "metrics.h"

#include "array.h"

#include <stdlib.h>
#include <string.h>

struct metrics {
    ARRAY(metric *) list;
};

metrics *metrics_create(void)
{
    return base_zalloc(1, sizeof(metrics));
}

void metrics_destroy(metrics *m)
{
    if (!m) return;
    for (size_t i = 0; i < m->list.count; i++) {
        free((char *)m->list.at[i]->name);
        free(m->list.at[i]);
    }
    array_free(&m->list);
    free(m);
}

metric *metrics_add(metrics *m, const char *name, const char *help)
{
    for (size_t i = 0; i < m->list.count; i++)
        if (strcmp(m->list.at[i]->name, name) == 0) return m->list.at[i];
    metric *added = base_zalloc(1, sizeof *added);
    added->name = base_strdup(name);
    added->help = help;
    array_push(&m->list, added);
    return added;
}

size_t metrics_count(const metrics *m)
{
    return m->list.count;
}
const metric *metrics_at(const metrics *m, size_t index)
{
    return m->list.at[index];
}
