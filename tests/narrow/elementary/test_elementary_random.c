/* Queries of all classes against exact arithmetic: no contact missed, no time late, every claim of an answer true; with
 * and without a separation. 10^5 of them, ten times as many with COLLIDED_NIGHTLY=1 in the environment, a
 * fifth with COLLIDED_BRIEF=1. */
#include "elementary_judge.h"
#include "elementary_sets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

static size_t wanted(size_t count)
{
    return getenv("COLLIDED_NIGHTLY") ? 10 * count : getenv("COLLIDED_BRIEF") ? count / 5 : count;
}

static void hold(elementary_class c, size_t n, double separation, elementary_tally *tally)
{
    elementary_query q = elementary_make(c, n);
    elementary_truth truth = elementary_oracle(&q);
    elementary_result r = elementary_ask(&q, separation);
    const char *fault = elementary_fault(&q, separation, &r, &truth);
    elementary_count(tally, &r, &truth);
    if (!fault) return;
    elementary_print(&q, &r, &truth);
    fail_msg("%s %zu, separation %g: %s", elementary_class_name(c), n, separation, fault);
}

static void hold_without_separation(void **state)
{
    (void)state;
    elementary_tally all[ELEMENTARY_CLASSES] = {0};
    for (int c = 0; c < ELEMENTARY_CLASSES; c++) {
        for (size_t n = 0; n < wanted(10000); n++) hold((elementary_class)c, n, 0, &all[c]);
        elementary_print_tally(elementary_class_name((elementary_class)c), &all[c]);
        assert_true(all[c].contacts > 0);
    }
    /* How good, not only how safe. In general position a hit is proved, and nothing else is called one. */
    const elementary_tally *random = &all[ELEMENTARY_RANDOM], *cloth = &all[ELEMENTARY_CLOTH];
    assert_true(random->contacts > wanted(10000) / 10 && cloth->contacts > wanted(10000) / 50);
    size_t few = wanted(10000) / 5000; /* within rounding of a corner */
    assert_true(random->false_hits + cloth->false_hits + all[ELEMENTARY_NEAR_MISS].false_hits <= few);
    assert_true(random->undecided + cloth->undecided <= few);
    assert_true(random->certain * 1000 >= random->hits * 995 && cloth->certain * 1000 >= cloth->hits * 995);
    assert_true(random->steps < 4 * random->queries && cloth->steps < 2 * cloth->queries);
}

/* Two edges whose ends differ by the least number there is do not touch, whatever scaling makes of that. */
static void what_is_less_than_scales_is_not_lost(void **state)
{
    (void)state;
    const elementary_query q = {ELEMENTARY_EE,
        {{0x1.58p-1, -0x1.7p-2, 0x1p-1074}, {0x1.ep-1, 0x1.28p+0, 0x1.ap-3}, {0x1.6p-1, 0x1.cp-1, -0x1.28p-1},
            {0x1.58p-1, -0x1.7p-2, 0}},
        {{0x1.dp-1, -0x1p-4, 1}, {0x1.5p-1, 0x1.ap-1, 0x1.88p-1}, {-1, 1, -0x1.4p-1}, {0x1.dp-2, 0x1.18p-1, -0x1p-3}}};
    elementary_truth truth = elementary_oracle(&q);
    elementary_result r = elementary_ask(&q, 0);
    assert_false(truth.touches);
    assert_null(elementary_fault(&q, 0, &r, &truth));
}

static void hold_with_a_separation(void **state)
{
    (void)state;
    for (int c = 0; c < ELEMENTARY_CLASSES; c++) {
        elementary_tally tally = {0};
        for (size_t n = 0; n < wanted(400); n++)
            hold((elementary_class)c, 2000000 + n, pow(10, -1.0 * (double)(n % 12)), &tally);
        elementary_print_tally(elementary_class_name((elementary_class)c), &tally);
        assert_true(tally.certain > tally.queries / 50);
    }
}

/* Thresholds on the lattice, exactly reached or missed. */
static void hold_with_a_separation_on_the_lattice(void **state)
{
    (void)state;
    elementary_tally tally = {0};
    for (size_t n = 0; n < wanted(4000); n++)
        hold(ELEMENTARY_LATTICE, 4000000 + n, 0.125 * (double)(1 + n / 2 % 4), &tally);
    elementary_print_tally("on the lattice", &tally);
    assert_true(tally.certain > tally.queries / 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hold_without_separation),
        cmocka_unit_test(what_is_less_than_scales_is_not_lost),
        cmocka_unit_test(hold_with_a_separation),
        cmocka_unit_test(hold_with_a_separation_on_the_lattice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
