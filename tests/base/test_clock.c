/* Clocks: nanoseconds, and the monotonic one never steps back. */
#include "base/clock.h"
#include "cmocka_c.h"

#include <time.h>

static void the_wall_clock_agrees_with_time(void **state)
{
    (void)state;
    int64_t before = (int64_t)time(NULL), stamp = clock_wall_ns() / 1000000000, after = (int64_t)time(NULL);
    /* time() may lag behind by one tick of the coarse clock. */
    assert_true(stamp >= before && stamp <= after + 1);
}

static void the_monotonic_clock_counts_nanoseconds(void **state)
{
    (void)state;
    int64_t begin = clock_monotonic_ns();
    nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
    int64_t passed = clock_monotonic_ns() - begin;
    assert_true(passed >= 2000000);
    assert_true(passed < INT64_C(5000000000));
}

static void the_monotonic_clock_never_steps_back(void **state)
{
    (void)state;
    int64_t last = clock_monotonic_ns();
    for (int i = 0; i < 100000; i++) {
        int64_t now = clock_monotonic_ns();
        assert_true(now >= last);
        last = now;
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_wall_clock_agrees_with_time),
        cmocka_unit_test(the_monotonic_clock_counts_nanoseconds),
        cmocka_unit_test(the_monotonic_clock_never_steps_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
