/* Which accuracy is recommended, and with which words. */
#include "trade.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

enum { LEVELS = 4 };
static const char *const NAMES[LEVELS] = {"1e-3", "1e-6", "1e-9", "exact"};
static const double ERRORS[LEVELS] = {1e-3, 1e-6, 2e-9, 3e-12};
static trade_row rows[LEVELS];

static trade_advice advise(const double ticks_us[LEVELS], const double false_ones[LEVELS])
{
    trade_advice a;
    for (int i = 0; i < LEVELS; i++)
        rows[i] = (trade_row){.pair = "all",
            .accuracy = NAMES[i],
            .tick_mean_s = 1e-6 * ticks_us[i],
            .false_ones = false_ones[i],
            .error_max_m = ERRORS[i]};
    const trade t = {.rows = rows, .row_count = LEVELS, .levels = LEVELS};
    trade_advise(&t, &a);
    return a;
}

static void expect(const trade_advice *a, const char *use, const char *words)
{
    if (strcmp(a->use->accuracy, use) != 0 || !strstr(a->reason, words))
        fail_msg("use %s: %s; expected %s: ...%s...", a->use->accuracy, a->reason, use, words);
}

static void the_loosest_that_tells_the_same_is_used_if_finer_ones_cost_more(void **state)
{
    (void)state;
    trade_advice a = advise((double[]){10, 20, 28, 40}, (double[]){3, 0, 0, 0});
    expect(&a, "1e-6", "1e-9 costs 1.4 times and changes no event");
    expect(&a, "1e-6", "1e-3 would save 50 %, but tells 3 false events");
}

static void what_is_nearly_free_is_taken(void **state)
{
    (void)state;
    trade_advice a = advise((double[]){20, 20.5, 21.9, 40}, (double[]){0, 0, 0, 0});
    expect(&a, "1e-9", "exact costs 1.83 times and changes no event");
    expect(&a, "1e-9", "1e-6 would save 6 %, and is off by up to 1 um");
    a = advise((double[]){20, 19, 20, 20.5}, (double[]){0, 0, 0, 0});
    expect(&a, "exact", "20.5 us a tick, off by at most 3e-12 m, exact is nearly free here");
}

static void what_is_as_exact_is_no_alternative(void **state)
{
    (void)state;
    trade_advice a = advise((double[]){20, 20.5, 21.9, 40}, (double[]){0, 0, 0, 0});
    rows[1].error_max_m = rows[2].error_max_m; /* the next looser one is as good: the one before it is told */
    const trade t = {.rows = rows, .row_count = LEVELS, .levels = LEVELS};
    trade_advise(&t, &a);
    expect(&a, "1e-9", "1e-3 would save 9 %, and is off by up to 1 mm");
}

static void exact_is_used_where_nothing_else_tells_the_truth(void **state)
{
    (void)state;
    trade_advice a = advise((double[]){10, 20, 30, 40}, (double[]){9, 4, 1, 0});
    expect(&a, "exact", "but tells 1 false event");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_loosest_that_tells_the_same_is_used_if_finer_ones_cost_more),
        cmocka_unit_test(what_is_nearly_free_is_taken),
        cmocka_unit_test(what_is_as_exact_is_no_alternative),
        cmocka_unit_test(exact_is_used_where_nothing_else_tells_the_truth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
