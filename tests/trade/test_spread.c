/* Percentiles and means of spread.h against a sorted array. */
#include "trade/spread.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { VALUES = 20000 };

static int rising(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return x < y ? -1 : x > y;
}

static void percentiles_are_right_within_3_percent(void **state)
{
    (void)state;
    static int64_t values[VALUES];
    spread *s = calloc(1, sizeof *s);
    uint64_t random = 1;
    double sum = 0;
    for (int i = 0; i < VALUES; i++) {
        random = random * 6364136223846793005u + 1442695040888963407u;
        values[i] = (int64_t)exp(3 + 12 * (double)(random >> 11) / 9007199254740992.0);
        spread_add(s, values[i]);
        sum += (double)values[i];
    }
    qsort(values, VALUES, sizeof *values, rising);
    for (int percent = 1; percent <= 100; percent++) {
        double is = spread_percentile(s, percent / 100.0), truth = (double)values[VALUES / 100 * percent - 1];
        if (fabs(is - truth) > 0.03 * truth + 1) fail_msg("%d %%: %g, not %g", percent, is, truth);
    }
    assert_true(fabs(spread_mean(s) - sum / VALUES) <= 1e-9 * sum / VALUES);
    free(s);
}

static void a_tick_that_the_scheduler_spoilt_does_not_count(void **state)
{
    (void)state;
    spread *s = calloc(1, sizeof *s);
    assert_true(spread_mean(s) == 0 && spread_calm_mean(s) == 0 && spread_percentile(s, 0.99) == 0);
    for (int i = 0; i < 999; i++) spread_add(s, 1000);
    spread_add(s, 1000000000);
    assert_true(spread_calm_mean(s) == 1000);
    assert_true(spread_mean(s) > 1000000);
    spread_add(s, INT64_MAX); /* what is beyond the last bin is in it; below 0 is 0 */
    spread_add(s, -5);
    assert_true(spread_percentile(s, 1) > 1e12 && spread_percentile(s, 0) == 0);
    free(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(percentiles_are_right_within_3_percent),
        cmocka_unit_test(a_tick_that_the_scheduler_spoilt_does_not_count),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
