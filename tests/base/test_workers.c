/* Worker pools: each index exactly once, each worker with scratch memory of its own. Run under TSan as well. */
#include "base/workers.h"
#include "cmocka_c.h"
#include "prng.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <time.h>

enum { INDICES = 3000 };

typedef struct tally {
    unsigned char visits[INDICES]; /* plain memory: two threads on one index are a race that TSan sees */
    size_t by_worker[WORKERS_MAX];
    size_t chunk, count;
    unsigned workers;
    atomic_bool broken; /* a range or a worker's number was out of bounds */
} tally;

static void visit(void *context, size_t begin, size_t end, unsigned worker)
{
    tally *t = context;
    if (begin >= end || end > t->count || end - begin > t->chunk || worker >= t->workers) {
        atomic_store(&t->broken, true);
        return;
    }
    for (size_t i = begin; i < end; i++) t->visits[i]++;
    t->by_worker[worker] += end - begin;
}

static void check_run(workers *w, size_t count, size_t chunk)
{
    static tally t;
    memset(&t, 0, sizeof t);
    t.count = count;
    t.chunk = chunk;
    t.workers = workers_count(w);
    workers_run(w, count, chunk, visit, &t);
    assert_false(atomic_load(&t.broken));
    size_t sum = 0;
    for (size_t i = 0; i < WORKERS_MAX; i++) sum += t.by_worker[i];
    assert_int_equal(sum, count);
    for (size_t i = 0; i < INDICES; i++) assert_int_equal(t.visits[i], i < count);
}

static void each_index_is_covered_exactly_once(void **state)
{
    (void)state;
    prng random = {5};
    for (unsigned n = 1; n <= 8; n++) {
        workers *w = workers_create(n);
        assert_int_equal(workers_count(w), n);
        check_run(w, 0, 1);
        check_run(w, 1, 1);
        check_run(w, INDICES, INDICES + 5);
        for (int i = 0; i < 200; i++) check_run(w, prng_below(&random, INDICES + 1), 1 + prng_below(&random, 64));
        workers_destroy(w);
    }
}

static void a_pool_that_never_ran_ends(void **state)
{
    (void)state;
    for (unsigned n = 1; n <= WORKERS_MAX; n *= 4) workers_destroy(workers_create(n));
    workers_destroy(NULL);
}

typedef struct meeting {
    atomic_uint present;
    unsigned wanted;
} meeting;

/* Returns only when `wanted` threads are inside at once, or after two seconds. */
static void meet(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)begin, (void)end, (void)worker;
    meeting *m = context;
    atomic_fetch_add(&m->present, 1);
    for (int i = 0; i < 2000 && atomic_load(&m->present) < m->wanted; i++)
        nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

static void chunks_run_at_the_same_time(void **state)
{
    (void)state;
    workers *w = workers_create(3);
    for (int i = 0; i < 20; i++) {
        meeting m = {.wanted = 3};
        int64_t before = (int64_t)time(NULL);
        workers_run(w, 3, 1, meet, &m);
        assert_int_equal(atomic_load(&m.present), 3);
        assert_true((int64_t)time(NULL) - before < 2);
    }
    workers_destroy(w);
}

static void record_mask(void *context, size_t begin, size_t end, unsigned worker)
{
    (void)end, (void)worker;
    sigset_t *masks = context;
    pthread_sigmask(SIG_BLOCK, NULL, &masks[begin]);
    nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
}

static void the_pool_blocks_signals_and_the_caller_keeps_its_mask(void **state)
{
    (void)state;
    enum { CHUNKS = 40 };
    static sigset_t masks[CHUNKS];
    workers *w = workers_create(2);
    workers_run(w, CHUNKS, 1, record_mask, masks);
    workers_destroy(w);
    int blocked = 0;
    for (int i = 0; i < CHUNKS; i++) blocked += sigismember(&masks[i], SIGTERM) == 1;
    assert_in_range(blocked, 1, CHUNKS - 1); /* the pool's thread took some, the caller the others */
    sigset_t own;
    pthread_sigmask(SIG_BLOCK, NULL, &own);
    assert_int_equal(sigismember(&own, SIGTERM), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_index_is_covered_exactly_once),
        cmocka_unit_test(a_pool_that_never_ran_ends),
        cmocka_unit_test(chunks_run_at_the_same_time),
        cmocka_unit_test(the_pool_blocks_signals_and_the_caller_keeps_its_mask),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
