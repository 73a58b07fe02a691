/* Metrics: addresses that stay, names that are unique, counts that no thread loses. */
#include "base/metrics.h"
#include "cmocka_c.h"

#include <pthread.h>
#include <stdio.h>

static void addresses_stay_while_the_table_grows(void **state)
{
    (void)state;
    enum { METRICS = 100 };
    char name[32];
    static metric *at[METRICS];
    metrics *m = metrics_create();
    for (int i = 0; i < METRICS; i++) {
        snprintf(name, sizeof name, "metric_%d", i);
        at[i] = metrics_add(m, name, "a count"); /* which keeps a copy */
        metric_set(at[i], (uint64_t)i);
    }
    assert_int_equal(metrics_count(m), METRICS);
    for (int i = 0; i < METRICS; i++) {
        assert_ptr_equal(metrics_at(m, (size_t)i), at[i]);
        snprintf(name, sizeof name, "metric_%d", i);
        assert_string_equal(metrics_at(m, (size_t)i)->name, name);
        assert_int_equal(metric_get(at[i]), i);
    }
    metrics_destroy(m);
}

static void the_same_name_is_the_same_metric(void **state)
{
    (void)state;
    metrics *m = metrics_create();
    metric *ticks = metrics_add(m, "ticks", "ticks so far");
    assert_ptr_not_equal(metrics_add(m, "pairs", "pairs now"), ticks);
    assert_ptr_equal(metrics_add(m, "ticks", "ticks so far"), ticks);
    assert_int_equal(metrics_count(m), 2);
    metrics_destroy(m);
}

enum { THREADS = 4, COUNTS = 50000 };

static void *count_many(void *argument)
{
    for (int i = 0; i < COUNTS; i++) metric_count(argument, 2);
    return NULL;
}

static void no_count_is_lost_between_threads(void **state)
{
    (void)state;
    metrics *m = metrics_create();
    metric *counted = metrics_add(m, "counted", "things");
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++) assert_int_equal(pthread_create(&threads[i], NULL, count_many, counted), 0);
    for (int i = 0; i < THREADS; i++) pthread_join(threads[i], NULL);
    assert_int_equal(metric_get(counted), 2 * THREADS * COUNTS);
    metrics_destroy(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(addresses_stay_while_the_table_grows),
        cmocka_unit_test(the_same_name_is_the_same_metric),
        cmocka_unit_test(no_count_is_lost_between_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
