/* memory: memory_limit, held against what this process has resident: that is what the kernel's own limits count, and
 * what libraries (DDS, qhull) and builds under way take is in it, which no counter of our own allocations would see. It
 * is read (one read of /proc/self/statm, about a microsecond) before each tick, and before a command if that was 10 ms
 * ago; what commands that wait for a tick will need is estimated on top. Whatever would make the daemon grow beyond it
 * is refused before it is recorded, and how many pairs may begin in a tick is recorded with it, so that a replay needs
 * to know of none of this. Tick thread. */
#ifndef COLLIDED_SERVICE_MEMORY_H
#define COLLIDED_SERVICE_MEMORY_H

#include "wire/wire.h"

#include <stdbool.h>
#include <stdint.h>

struct service;
struct link;

typedef struct memory_gauge {
    int statm;         /* of this process; -1: nothing is looked at */
    int64_t limit;     /* bytes that may be resident */
    int64_t space;     /* bytes of addresses (ulimit -v), less an eighth; INT64_MAX: as many as there are */
    int64_t resident;  /* bytes, at the last look, ... */
    int64_t left;      /* ... and so many until a limit is reached */
    int64_t promised;  /* bytes that what was let in since the last tick is likely to need */
    int64_t looked_ns; /* monotonic */
    int64_t next_trim_ns;
    int64_t pairs; /* at the last look */
    bool reported; /* that it is short, in the log */
} memory_gauge;

/* Bytes that this process may have: of the machine's memory, its cgroup's (memory.max and memory.high, or
 * memory.limit_in_bytes, of it and of those above it) the least. `root`: "" (for tests: a folder that stands for /). */
int64_t memory_granted(const char *root);

void memory_open(struct service *s);
void memory_close(struct service *s);
/* False: it would grow beyond the limit; named, counted. Not of a replay. */
bool memory_admit(struct service *s, const struct link *from, const wire_message *m, wire_refusal *why);
/* So many pairs may there be in the tick that comes, of max_pairs; 0: all. */
int64_t memory_pairs_most(struct service *s);
void memory_after_tick(struct service *s); /* what waited for it has been applied */
void memory_trim(struct service *s);       /* each round: gives back what can be, where it is short */
bool memory_is_short(const struct service *s);

#endif
