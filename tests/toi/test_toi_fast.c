/* Random fast pairs against the march (toi_truth.h): none is missed, none is late, no hit is invented. 10^5 pairs;
 * COLLIDED_NIGHTLY: 10^6. On two threads, for it is long. */
#include "toi_pairs.h"
#include "toi_truth.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

enum { THREADS = 2, PAIRS = 100000, PAIRS_NIGHTLY = 1000000, REPORTED = 10 };

typedef struct worker {
    pthread_t thread;
    uint64_t first, count;
    narrow_scratch *scratch;
    uint32_t told[4], hits, frees, unclear, wrong;
    uint64_t queries;
    uint32_t queries_most, steps_most;
    double error;
} worker;

static void complain(
    worker *w, const char *what, uint64_t seed, const toi_pair *p, const toi_result *t, const toi_truth *e)
{
    if (++w->wrong > REPORTED) return;
    print_error("%s: seed %llu, %s-%s: %s [%.17g, %.17g]; truth %d [%.17g, %.17g], nearest %g\n", what,
        (unsigned long long)seed, shape_type_name(p->a.shape->type), shape_type_name(p->b.shape->type),
        toi_status_name(t->status), t->lo, t->hi, (int)e->verdict, e->lo, e->hi, e->nearest);
}

static void compare(worker *w, uint64_t seed, const toi_pair *p, const toi_result *t, const toi_truth *e)
{
    double rounding = 1e-12;
    if (t->status == TOI_UNDECIDED) complain(w, "undecided", seed, p, t, e);
    if (e->verdict == TRUTH_HIT) {
        if (t->status == TOI_FREE) complain(w, "missed", seed, p, t, e);
        if (t->status != TOI_FREE && t->lo > e->hi + rounding) complain(w, "late", seed, p, t, e);
        if (t->status == TOI_HIT) w->error = fmax(w->error, e->lo - t->lo);
        if (t->status == TOI_HIT && t->hi < e->lo - rounding) complain(w, "touches too early", seed, p, t, e);
    }
    if (e->verdict == TRUTH_FREE) {
        if (t->status == TOI_HIT) complain(w, "invented", seed, p, t, e);
        if (t->status == TOI_NEAR && e->nearest > 4 * p->request.tolerance) complain(w, "near, but far", seed, p, t, e);
    }
}

static void *work(void *context)
{
    worker *w = context;
    for (uint64_t i = w->first; i < w->first + w->count; i++) {
        toi_pair p;
        uint64_t seed = 0xfa57000000 + i;
        toi_pair_any(seed, &toi_manners[i % TOI_MANNERS], &p);
        toi_result t;
        toi_find(&p.a, &p.b, &p.request, VEC_ZERO, w->scratch, &t);
        toi_truth e = toi_truth_of(&p.a, &p.b, p.request.span, w->scratch);
        compare(w, seed, &p, &t, &e);
        w->told[t.status]++;
        w->hits += e.verdict == TRUTH_HIT;
        w->frees += e.verdict == TRUTH_FREE;
        w->unclear += e.verdict == TRUTH_UNCLEAR;
        w->queries += t.queries;
        if (t.queries > w->queries_most) w->queries_most = t.queries;
        if (t.steps > w->steps_most) w->steps_most = t.steps;
    }
    return NULL;
}

static void fast_pairs_are_right(void **state)
{
    (void)state;
    uint64_t pairs = getenv("COLLIDED_NIGHTLY") ? PAIRS_NIGHTLY : getenv("COLLIDED_BRIEF") ? PAIRS / 5 : PAIRS;
    worker workers[THREADS] = {0};
    for (uint64_t k = 0; k < THREADS; k++) {
        worker *w = &workers[k];
        w->first = k * pairs / THREADS, w->count = pairs / THREADS;
        w->scratch = aligned_alloc(64, narrow_scratch_size());
        assert_non_null(w->scratch);
        assert_int_equal(pthread_create(&w->thread, NULL, work, w), 0);
    }
    worker all = {0};
    for (int k = 0; k < THREADS; k++) {
        worker *w = &workers[k];
        assert_int_equal(pthread_join(w->thread, NULL), 0);
        free(w->scratch);
        for (int i = 0; i < 4; i++) all.told[i] += w->told[i];
        all.hits += w->hits, all.frees += w->frees, all.unclear += w->unclear, all.wrong += w->wrong;
        all.queries += w->queries;
        if (w->queries_most > all.queries_most) all.queries_most = w->queries_most;
        if (w->steps_most > all.steps_most) all.steps_most = w->steps_most;
        all.error = fmax(all.error, w->error);
    }
    print_message(
        "%llu pairs: truth %u free, %u hit, %u unclear; told %u free, %u hit, %u near; %.2f distances a pair, at most "
        "%u, %u steps; %.2g of the span early\n",
        (unsigned long long)pairs, all.frees, all.hits, all.unclear, all.told[TOI_FREE], all.told[TOI_HIT],
        all.told[TOI_NEAR], (double)all.queries / (double)pairs, all.queries_most, all.steps_most, all.error);
    assert_int_equal(all.wrong, 0);
    assert_true(all.hits > pairs / 4 && all.frees > pairs / 20 && all.unclear < pairs / 100);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(fast_pairs_are_right)};
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
