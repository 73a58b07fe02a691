/* What counts as missed and as false, on streams made by hand. */
#include "trade/episodes.h"
#include "trade/meter.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static world *nothing;

static void tell(episodes *e, int64_t tick, uint8_t kind, int64_t contact, const char *b)
{
    const char *a = "arm";
    const int32_t shape = 0;
    const wire_event_batch m = {.client = 1,
        .subscription = 1,
        .tick = tick,
        .kinds = {1, &kind},
        .contacts = {1, &contact},
        .names_a = {1, &a},
        .names_b = {1, &b},
        .shapes_a = {1, &shape},
        .shapes_b = {1, &shape}};
    episodes_take(e, nothing, &m, 100);
}

static uint64_t missing(episodes *all, episodes *among)
{
    uint64_t counts[METER_PAIRS + 1] = {0}, sum = 0;
    episodes_sort(all);
    episodes_sort(among);
    episodes_missing(all, among, counts);
    for (size_t i = 0; i <= METER_PAIRS; i++) sum += counts[i];
    return sum;
}

static void pair_of_runs(episodes *exact, episodes *loose)
{
    episodes_init(exact);
    episodes_init(loose);
}

static void expect(episodes *exact, episodes *loose, uint64_t missed, uint64_t false_ones)
{
    assert_int_equal(missing(exact, loose), missed);
    assert_int_equal(missing(loose, exact), false_ones);
    episodes_free(exact);
    episodes_free(loose);
}

static void a_contact_that_the_other_run_never_tells_is_missed_or_false(void **state)
{
    (void)state;
    episodes exact, loose;
    pair_of_runs(&exact, &loose);
    tell(&exact, 10, EVENT_BEGIN, 1, "box");
    tell(&exact, 12, EVENT_END, 1, "box");
    tell(&loose, 10, EVENT_BEGIN, 1, "cone");
    tell(&loose, 12, EVENT_END, 1, "cone");
    tell(&loose, 30, EVENT_BEGIN, 2, "box");
    expect(&exact, &loose, 1, 2);
}

static void a_wider_contact_is_the_same_and_so_is_one_that_joins_two(void **state)
{
    (void)state;
    episodes exact, loose;
    pair_of_runs(&exact, &loose);
    tell(&loose, 5, EVENT_BEGIN, 1, "box");
    tell(&loose, 25, EVENT_END, 1, "box");
    tell(&exact, 10, EVENT_BEGIN, 1, "box");
    tell(&exact, 11, EVENT_UPDATE, 1, "box");
    tell(&exact, 12, EVENT_END, 1, "box");
    tell(&exact, 20, EVENT_BEGIN, 2, "box");
    tell(&exact, 22, EVENT_END, 2, "box");
    expect(&exact, &loose, 0, 0);
}

static void two_ticks_of_shift_are_allowed_and_three_are_not(void **state)
{
    (void)state;
    for (int64_t shift = -4; shift <= 4; shift++) {
        episodes exact, loose;
        pair_of_runs(&exact, &loose);
        tell(&exact, 10, EVENT_IMPACT, 1, "box");
        tell(&loose, 10 + shift, EVENT_IMPACT, 1, "box");
        uint64_t apart = shift < -EPISODES_SHIFT || shift > EPISODES_SHIFT;
        expect(&exact, &loose, apart, apart);
    }
}

static void facts_are_told_apart_and_what_lasts_to_the_end_counts(void **state)
{
    (void)state;
    episodes exact, loose;
    pair_of_runs(&exact, &loose);
    tell(&exact, 10, EVENT_NEAR, 1, "box");
    tell(&exact, 12, EVENT_NEAR, 1, "box"); /* an update of it */
    tell(&exact, 14, EVENT_PREDICTED, 2, "cone");
    tell(&loose, 10, EVENT_BEGIN, 1, "box");
    tell(&loose, 99, EVENT_PREDICTED, 2, "cone");
    assert_int_equal(exact.at.count, 2);
    assert_int_equal(exact.events, 3);
    assert_true(exact.bytes == 300);
    expect(&exact, &loose, 1, 1);
}

static int make_world(void **state)
{
    (void)state;
    const world_options options = world_options_default();
    nothing = world_create(&options);
    return 0;
}

static int drop_world(void **state)
{
    (void)state;
    world_destroy(nothing);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_contact_that_the_other_run_never_tells_is_missed_or_false),
        cmocka_unit_test(a_wider_contact_is_the_same_and_so_is_one_that_joins_two),
        cmocka_unit_test(two_ticks_of_shift_are_allowed_and_three_are_not),
        cmocka_unit_test(facts_are_told_apart_and_what_lasts_to_the_end_counts),
    };
    return cmocka_run_group_tests(tests, make_world, drop_world);
}
