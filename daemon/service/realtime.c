/* realtime: each of the three is asked for on its own, and a refusal ends the start: who asked for it relies on it. */
#include "realtime.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sysexits.h>
#include <unistd.h>

/* One number, or -1. */
static long take_cpu_number(const char **text)
{
    char *end;
    if (**text < '0' || **text > '9') return -1;
    long n = strtol(*text, &end, 10);
    *text = end;
    return n < CPU_SETSIZE ? n : -1;
}

bool realtime_processors(const char *list, cpu_set_t *set, char *why, size_t why_size)
{
    const char *at = list;
    CPU_ZERO(set);
    for (;;) {
        long first = take_cpu_number(&at), last = first;
        if (first >= 0 && *at == '-') {
            at++;
            last = take_cpu_number(&at);
        }
        if (first < 0 || last < first || (*at && *at != ',')) break;
        for (long i = first; i <= last; i++) CPU_SET((size_t)i, set);
        if (!*at) return true;
        at++;
    }
    snprintf(why, why_size, "cpus = \"%.80s\": allowed are numbers from 0 to %d and ranges, divided by commas: 2,4-7",
        list, CPU_SETSIZE - 1);
    return false;
}

static int pin(const char *list, char *why, size_t why_size)
{
    cpu_set_t set;
    if (!realtime_processors(list, &set, why, why_size)) return EX_CONFIG;
    if (sched_setaffinity(0, sizeof set, &set) == 0) return EX_OK;
    snprintf(why, why_size, "cpus = \"%.80s\": %s: name some that are there and allowed: taskset -p %d lists them",
        list, strerror(errno), (int)getpid());
    return EX_CONFIG;
}

/* A limit that is reached later would end the daemon when it next grows: so there must be none, also for root, who may
 * become another user (user), or be root in a container only. */
static int lock_memory(char *why, size_t why_size)
{
    const struct rlimit none = {RLIM_INFINITY, RLIM_INFINITY};
    struct rlimit most;
    int refused = setrlimit(RLIMIT_MEMLOCK, &none) == 0 ? 0 : errno;
    if (getrlimit(RLIMIT_MEMLOCK, &most) != 0 || most.rlim_cur != RLIM_INFINITY)
        errno = refused;
    else if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0)
        return EX_OK;
    snprintf(
        why, why_size, "lock_memory = yes: %s: do: ulimit -l unlimited (or LimitMEMLOCK=infinity)", strerror(errno));
    return EX_NOPERM;
}

static int set_priority(long priority, char *why, size_t why_size)
{
    struct sched_param p = {.sched_priority = (int)priority};
    if (sched_setscheduler(0, SCHED_FIFO, &p) == 0) return EX_OK;
    snprintf(why, why_size,
        "fifo_priority = %ld: %s: do: ulimit -r %ld (in the unit, instead of this option: CPUSchedulingPolicy=fifo "
        "and CPUSchedulingPriority=%ld)",
        priority, strerror(errno), priority, priority);
    return EX_NOPERM;
}

int realtime_apply(const config *c, char *why, size_t why_size)
{
    int status = *c->cpus ? pin(c->cpus, why, why_size) : EX_OK;
    if (status == EX_OK && c->lock_memory) status = lock_memory(why, why_size);
    if (status == EX_OK && c->fifo_priority) status = set_priority(c->fifo_priority, why, why_size);
    return status;
}
