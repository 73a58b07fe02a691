/* Quantiles: never below the truth, and at most an eighth above it, over the whole range. */
#include "base/quantiles.h"

#include "cmocka_c.h"
#include "prng.h"

#include <math.h>
#include <stdlib.h>

static int compare(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static void a_quantile_is_the_truth_or_an_eighth_more(void **state)
{
    (void)state;
    enum { COUNT = 5000 };
    static const double shares[] = {0, 0.001, 0.5, 0.9, 0.99, 1};
    static int64_t all[COUNT];
    static quantiles q;
    prng r = {3};
    for (int round = 0; round < 20; round++) {
        quantiles_clear(&q);
        for (int i = 0; i < COUNT; i++)
            quantiles_add(&q, all[i] = (int64_t)(prng_next(&r) >> (1 + prng_next(&r) % 63)));
        qsort(all, COUNT, sizeof *all, compare);
        for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
            int64_t rank = (int64_t)ceil(shares[i] * COUNT), truth = all[rank > 0 ? rank - 1 : 0];
            int64_t told = quantiles_at(&q, shares[i]);
            assert_true(told >= truth && told - truth <= truth / 8);
        }
        assert_int_equal(q.most_ns, all[COUNT - 1]);
        assert_int_equal(quantiles_at(&q, 1), q.most_ns);
    }
}

static void the_ends_of_the_range(void **state)
{
    (void)state;
    static quantiles q;
    assert_int_equal(quantiles_at(&q, 0.5), 0);
    quantiles_add(&q, -5);
    assert_int_equal(quantiles_at(&q, 0.5), 0);
    quantiles_add(&q, INT64_MAX);
    assert_int_equal(quantiles_at(&q, 0.5), 0);
    assert_true(quantiles_at(&q, 0.51) == INT64_MAX);
    quantiles_clear(&q);
    assert_true(q.count == 0 && q.most_ns == 0 && quantiles_at(&q, 1) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_quantile_is_the_truth_or_an_eighth_more),
        cmocka_unit_test(the_ends_of_the_range),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
