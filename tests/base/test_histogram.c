/* Histograms: where a number is counted, and what is added to the sum. */
#include "base/histogram.h"
#include "cmocka_c.h"

#include <math.h>

static const double BOUNDS[] = {1, 2, 4};

static void a_number_is_counted_at_the_first_bound_that_it_is_not_above(void **state)
{
    (void)state;
    histogram h = {.name = "h", .bounds = BOUNDS, .count = 3};
    const double numbers[] = {0, 1, 1.5, 2, 4, 5};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) histogram_add(&h, numbers[i]);
    const uint64_t expected[] = {2, 2, 1, 1};
    for (size_t i = 0; i < 4; i++) assert_int_equal(h.below[i], expected[i]);
    assert_int_equal(histogram_total(&h), 6);
    assert_true(h.sum == 13.5);
}

/* The interval of what is unknown has no end. */
static void an_infinite_number_is_counted_and_does_not_spoil_the_sum(void **state)
{
    (void)state;
    histogram h = {.name = "h", .bounds = BOUNDS, .count = 3};
    histogram_add(&h, 1.5);
    histogram_add(&h, (double)INFINITY);
    histogram_add(&h, (double)NAN); /* is not */
    assert_int_equal(h.below[3], 1);
    assert_int_equal(histogram_total(&h), 2);
    assert_true(h.sum == 1.5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_number_is_counted_at_the_first_bound_that_it_is_not_above),
        cmocka_unit_test(an_infinite_number_is_counted_and_does_not_spoil_the_sum),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
