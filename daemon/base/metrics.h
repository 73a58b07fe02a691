/* metrics: named counters. Registered once at start, then added to from any thread; read in registration order. */
#ifndef COLLIDED_BASE_METRICS_H
#define COLLIDED_BASE_METRICS_H

#include <stddef.h>
#include <stdint.h>

typedef struct metric {
    const char *name; /* lower_case, e.g. "reject_bad_number" */
    const char *help; /* one line, with the unit */
    _Atomic uint64_t value;
} metric;

typedef struct metrics metrics;

metrics *metrics_create(void);
void metrics_destroy(metrics *m);
/* The pointer stays valid; the same name is the same metric. The name is copied, the help is a static string. */
metric *metrics_add(metrics *m, const char *name, const char *help);
size_t metrics_count(const metrics *m);
const metric *metrics_at(const metrics *m, size_t index);

static inline void metric_count(metric *m, uint64_t by)
{
    __atomic_fetch_add((uint64_t *)&m->value, by, __ATOMIC_RELAXED);
}
static inline void metric_set(metric *m, uint64_t to)
{
    __atomic_store_n((uint64_t *)&m->value, to, __ATOMIC_RELAXED);
}
static inline uint64_t metric_get(const metric *m)
{
    return __atomic_load_n((const uint64_t *)&m->value, __ATOMIC_RELAXED);
}

#endif
