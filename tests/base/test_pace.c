/* Rounds under a budget, on a clock that the test turns: what a unit takes, and what comes after the work, is not known
 * before, and changes. */
#include "base/pace.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const int64_t LIMIT = 300000; /* ns */

typedef struct round_kind {
    int64_t before_ns, after_ns; /* what a round takes beside its work */
    double unit_ns;
    uint64_t units; /* that there are to be done */
} round_kind;

/* Pieces of 500 units, one after the other. Returns how long the round took; *done: units. */
static int64_t run_round(pace *p, const round_kind *k, uint64_t *done)
{
    static int64_t clock;
    int64_t began = clock += 1000000;
    *done = 0;
    pace_begin(p, clock);
    clock += k->before_ns;
    for (uint64_t granted = pace_grant(p, clock, 0);;) {
        while (*done < k->units && *done + 500 <= granted) {
            *done += 500;
            clock += (int64_t)(500 * k->unit_ns);
        }
        if (*done >= k->units) break;
        uint64_t more = pace_grant(p, clock, *done);
        if (more <= granted) break;
        granted = more;
    }
    clock += k->after_ns;
    pace_end(p, clock, *done);
    return clock - began;
}

static void rounds_end_in_time_and_use_their_time(void **state)
{
    (void)state;
    static const round_kind KINDS[] = {
        {20000, 10000, 1, UINT64_MAX}, {20000, 90000, 0.2, UINT64_MAX}, {100000, 30000, 5, UINT64_MAX}};
    pace p;
    pace_init(&p, LIMIT);
    for (size_t k = 0; k < sizeof KINDS / sizeof *KINDS; k++)
        for (int i = 0; i < 200; i++) {
            uint64_t done;
            int64_t took = run_round(&p, &KINDS[k], &done);
            if (i < 60) continue; /* it learns */
            assert_in_range(took, LIMIT * 8 / 10, LIMIT * 102 / 100);
        }
}

static void no_work_is_granted_where_there_is_no_time(void **state)
{
    (void)state;
    const round_kind late = {2 * LIMIT, 0, 1, UINT64_MAX};
    pace p;
    uint64_t done;
    pace_init(&p, LIMIT);
    for (int i = 0; i < 10; i++) {
        run_round(&p, &late, &done);
        assert_int_equal(done, 0);
    }
}

static void little_work_is_done_whole(void **state)
{
    (void)state;
    const round_kind small = {1000, 1000, 1, 5000};
    pace p;
    uint64_t done;
    pace_init(&p, LIMIT);
    for (int i = 0; i < 10; i++) {
        int64_t took = run_round(&p, &small, &done);
        assert_true(done == 5000 && took < LIMIT / 10);
    }
}

/* A clock that stands still makes no unit free. */
static void a_clock_that_stands_is_no_harm(void **state)
{
    (void)state;
    pace p;
    pace_init(&p, LIMIT);
    for (int i = 0; i < 2000; i++) {
        pace_begin(&p, 5);
        uint64_t granted = pace_grant(&p, 5, 0);
        assert_true(granted > 0 && granted < UINT64_C(1) << 40);
        granted = pace_grant(&p, 5, granted);
        pace_end(&p, 5, granted);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rounds_end_in_time_and_use_their_time),
        cmocka_unit_test(no_work_is_granted_where_there_is_no_time),
        cmocka_unit_test(little_work_is_done_whole),
        cmocka_unit_test(a_clock_that_stands_is_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
