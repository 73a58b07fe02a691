/* workers: a pool of threads that join the open job, take chunks of it until none is left, and leave. The caller takes
 * chunks too; then it closes the job and waits only for those that joined: a thread that wakes late finds the job
 * closed and delays nobody. The job's fields are written while the pool is idle and read after joining under the mutex.
 */
#include "workers.h"

#include "array.h"
#include "log.h"

#include <assert.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct job {
    workers_function *function;
    void *context;
    size_t count, chunk;
    atomic_size_t next; /* first index that nobody has taken yet */
} job;

typedef struct member {
    pthread_t thread;
    workers *pool;
    unsigned index;
} member;

struct workers {
    unsigned count; /* the caller's thread included: worker 0 */
    member members[WORKERS_MAX];
    job job;

    pthread_mutex_t mutex; /* guards what follows */
    pthread_cond_t opened, emptied;
    uint64_t job_number;
    unsigned joined;
    bool open, stopping;
};

static void take_chunks(job *j, unsigned worker)
{
    for (;;) {
        size_t begin = atomic_fetch_add_explicit(&j->next, j->chunk, memory_order_relaxed);
        if (begin >= j->count) return;
        size_t end = j->count - begin > j->chunk ? begin + j->chunk : j->count;
        j->function(j->context, begin, end, worker);
    }
}

static void *member_main(void *argument)
{
    member *self = argument;
    workers *w = self->pool;
    uint64_t done = 0; /* the last job that this thread joined */
    pthread_mutex_lock(&w->mutex);
    for (;;) {
        while (!w->stopping && !(w->open && w->job_number != done)) pthread_cond_wait(&w->opened, &w->mutex);
        if (w->stopping) break;
        done = w->job_number;
        w->joined++;
        pthread_mutex_unlock(&w->mutex);
        take_chunks(&w->job, self->index);
        pthread_mutex_lock(&w->mutex);
        if (--w->joined == 0) pthread_cond_signal(&w->emptied);
    }
    pthread_mutex_unlock(&w->mutex);
    return NULL;
}

/* Signals are the business of the thread in sigwait: block them all while the pool's threads inherit the mask. */
static void start_threads(workers *w, unsigned wanted)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (w->count < wanted) {
        member *m = &w->members[w->count];
        *m = (member){.pool = w, .index = w->count};
        int error = pthread_create(&m->thread, NULL, member_main, m);
        if (error) {
            log_warning("only %u of %u workers started: %s", w->count, wanted, strerror(error));
            break;
        }
        w->count++;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
}

workers *workers_create(unsigned count)
{
    assert(count >= 1 && count <= WORKERS_MAX);
    workers *w = base_zalloc(1, sizeof *w);
    w->count = 1;
    pthread_mutex_init(&w->mutex, NULL);
    pthread_cond_init(&w->opened, NULL);
    pthread_cond_init(&w->emptied, NULL);
    start_threads(w, count);
    return w;
}

void workers_destroy(workers *w)
{
    if (!w) return;
    pthread_mutex_lock(&w->mutex);
    w->stopping = true;
    pthread_cond_broadcast(&w->opened);
    pthread_mutex_unlock(&w->mutex);
    for (unsigned i = 1; i < w->count; i++) pthread_join(w->members[i].thread, NULL);
    pthread_cond_destroy(&w->emptied);
    pthread_cond_destroy(&w->opened);
    pthread_mutex_destroy(&w->mutex);
    free(w);
}

unsigned workers_count(const workers *w)
{
    return w->count;
}

static void open_job(workers *w)
{
    pthread_mutex_lock(&w->mutex);
    w->job_number++;
    w->open = true;
    pthread_cond_broadcast(&w->opened);
    pthread_mutex_unlock(&w->mutex);
}

static void close_job(workers *w)
{
    pthread_mutex_lock(&w->mutex);
    w->open = false;
    while (w->joined > 0) pthread_cond_wait(&w->emptied, &w->mutex);
    pthread_mutex_unlock(&w->mutex);
}

void workers_run(workers *w, size_t count, size_t chunk, workers_function *function, void *context)
{
    assert(chunk > 0);
    w->job.function = function;
    w->job.context = context;
    w->job.count = count;
    w->job.chunk = chunk;
    atomic_store_explicit(&w->job.next, 0, memory_order_relaxed);
    bool shared = w->count > 1 && count > chunk; /* one chunk is not worth a wake-up */
    if (shared) open_job(w);
    take_chunks(&w->job, 0);
    if (shared) close_job(w);
}
