/* workers: a pool that runs a function over [0, count) in chunks. The caller's thread takes part.
 *
 * Which worker runs which chunk is left to chance; a result that must not depend on it is written to a place of its
 * own per index, and read back in index order. `worker` (0..count-1) selects scratch memory. Signals are blocked in
 * the pool's threads. One thread at a time may call workers_run. */
#ifndef COLLIDED_BASE_WORKERS_H
#define COLLIDED_BASE_WORKERS_H

#include <stddef.h>

enum { WORKERS_MAX = 64 };

typedef struct workers workers;
typedef void workers_function(void *context, size_t begin, size_t end, unsigned worker);

workers *workers_create(unsigned count); /* 1 = no thread beside the caller's */
void workers_destroy(workers *w);
unsigned workers_count(const workers *w);
void workers_run(workers *w, size_t count, size_t chunk, workers_function *function, void *context);

#endif
