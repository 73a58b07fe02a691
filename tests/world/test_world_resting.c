/* What rests is told once: poses sent again, answers with the same bits. And hysteresis: what trembles about a
 * threshold begins once and ends once. */
#include "scene.h"

#include <stdio.h>

static size_t count_kind(const world_batch *b, uint8_t kind)
{
    size_t n = 0;
    for (size_t i = 0; b && i < b->count; i++) n += b->events[i].kind == kind;
    return n;
}

static void a_pose_sent_again_is_no_news(void **state)
{
    (void)state;
    static const unsigned FACTS[] = {WORLD_TOUCH, WORLD_DISTANCE, WORLD_TOUCH | WORLD_MANIFOLD | WORLD_DISTANCE};
    for (size_t f = 0; f < sizeof FACTS / sizeof *FACTS; f++) {
        world *w = scene_world(1, true);
        world_subscription all = scene_all(FACTS[f], 5);
        scene_subscription(w, &all);
        scene_sphere(w, "a", 0, 1);
        uint32_t b = scene_sphere(w, "b", 1.5, 1);
        assert_non_null(scene_tick(w, SECOND));
        for (int64_t t = 2; t < 10; t++) {
            scene_move(w, b, 1.5, t * SECOND);
            const world_batch *told = scene_tick(w, t * SECOND + 5);
            /* with the second stamp a velocity is known, which is news once */
            if (t > 3) assert_null(told);
        }
        size_t looked = 0;
        int64_t oldest_ns;
        assert_true(world_oldest_stamp(w, 0, &looked, &oldest_ns));
        assert_int_equal(oldest_ns, 9 * (int64_t)SECOND); /* a has none */
        assert_int_equal(looked, 1);
        scene_move(w, b, 1.25, 10 * (int64_t)SECOND);
        const world_batch *moved = scene_tick(w, 10 * (int64_t)SECOND);
        assert_int_equal(moved->count, 1);
        world_destroy(w);
    }
}

static void who_wants_all_is_told_all_once(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t i = scene_subscription(w, &all);
    scene_sphere(w, "a", 0, 1);
    uint32_t b = scene_sphere(w, "b", 1.5, 1);
    scene_tick(w, SECOND);
    scene_move(w, b, 1.5, 0);
    assert_null(scene_tick(w, 2 * (int64_t)SECOND));
    scene_move(w, b, 1.5, 0);
    world_want_all(w, i);
    assert_int_equal(count_kind(scene_tick(w, 3 * (int64_t)SECOND), EVENT_UPDATE), 1);
    scene_move(w, b, 1.5, 0);
    assert_null(scene_tick(w, 4 * (int64_t)SECOND));
    world_destroy(w);
}

/* What was held back is told when the rate allows, and nothing after it. */
static void an_update_that_was_held_back_is_told_once(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    all.period_ns = SECOND;
    scene_subscription(w, &all);
    scene_sphere(w, "a", 0, 1);
    uint32_t b = scene_sphere(w, "b", 1.5, 1);
    int64_t t = SECOND;
    scene_tick(w, t);
    scene_move(w, b, 1.25, 0);
    scene_tick(w, t += SECOND); /* told, and the period begins */
    scene_move(w, b, 1.375, 0);
    assert_null(scene_tick(w, t += 1000));
    scene_move(w, b, 1.375, 0); /* the same again, while it waits */
    assert_null(scene_tick(w, t += 1000));
    assert_true(world_next_due_ns(w) != INT64_MAX);
    assert_int_equal(count_kind(scene_tick(w, t += SECOND), EVENT_UPDATE), 1);
    scene_move(w, b, 1.375, 0);
    assert_null(scene_tick(w, t += SECOND));
    assert_true(world_next_due_ns(w) == INT64_MAX);
    world_destroy(w);
}

static void what_is_known_again_is_told_though_it_is_as_it_was(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE, 5);
    scene_subscription(w, &all);
    scene_sphere(w, "a", 0, 1);
    uint32_t b = scene_sphere(w, "b", 1.5, 1);
    scene_tick(w, SECOND);
    world_hold_body(w, b);
    assert_true(count_kind(scene_tick(w, 2 * (int64_t)SECOND), EVENT_UNKNOWN) > 0);
    scene_move(w, b, 1.5, 0);
    const world_batch *told = scene_tick(w, 3 * (int64_t)SECOND);
    assert_true(count_kind(told, EVENT_KNOWN) > 0);
    assert_int_equal(count_kind(told, EVENT_UPDATE), 1);
    world_destroy(w);
}

typedef struct told {
    size_t begins, ends, nears, fars;
} told;

/* Two balls of 1 m tremble about a gap; what is told of it. */
static told tremble(world_subscription terms, double gap, double by, bool coarse_neighbour)
{
    told sum = {0};
    world *w = scene_world(1, true);
    scene_subscription(w, &terms);
    if (coarse_neighbour) {
        world_subscription other = scene_all(WORLD_TOUCH, 0);
        other.threshold = terms.threshold;
        scene_subscription(w, &other);
    }
    scene_sphere(w, "a", 0, 1);
    uint32_t b = scene_sphere(w, "b", 10, 1);
    int64_t t = 0;
    for (int i = 0; i < 100; i++) {
        scene_move(w, b, i == 99 ? 10 : 2 + gap + (i % 2 ? by : -by), 0);
        world_batches all;
        world_tick(w, t += SECOND / 100, &all);
        assert_null(world_validate(w));
        for (size_t k = 0; k < all.count; k++) {
            if (all.at[k].subscription || all.at[k].snapshot) continue;
            sum.begins += count_kind(&all.at[k], EVENT_BEGIN);
            sum.ends += count_kind(&all.at[k], EVENT_END);
            for (size_t e = 0; e < all.at[k].count; e++) {
                sum.fars += all.at[k].events[e].kind == EVENT_FAR;
                sum.nears += all.at[k].events[e].kind == EVENT_NEAR;
            }
        }
    }
    world_destroy(w);
    return sum;
}

static void what_trembles_about_a_threshold_begins_once_and_ends_once(void **state)
{
    (void)state;
    static const world_accuracy ACCURACIES[] = {WORLD_BY_TOLERANCE, WORLD_BY_VERDICT, WORLD_BY_BOXES};
    for (size_t i = 0; i < 3; i++) {
        for (int neighbour = 0; neighbour < 2; neighbour++) {
            world_subscription terms = scene_all(WORLD_TOUCH, 0);
            terms.threshold = 0.5;
            terms.accuracy = ACCURACIES[i];
            double coarse = ACCURACIES[i] == WORLD_BY_BOXES ? 0.5 : 0; /* its slack is part of what it tells */
            told without = tremble(terms, 0.5 + 0.2 * coarse, 0.001 + 0.5 * coarse, neighbour);
            if (!coarse) assert_true(without.begins > 40);
            assert_int_equal(without.begins, without.ends);
            terms.hysteresis = 0.002 + 2 * coarse;
            told with = tremble(terms, 0.5 + 0.2 * coarse, 0.001 + 0.5 * coarse, neighbour);
            assert_int_equal(with.begins, 1);
            assert_int_equal(with.ends, 1);
        }
    }
}

static void near_and_far_have_the_same_hysteresis(void **state)
{
    (void)state;
    world_subscription terms = scene_all(WORLD_DISTANCE, 0.5);
    assert_true(tremble(terms, 0.5, 0.001, false).fars > 40);
    terms.hysteresis = 0.002;
    assert_int_equal(tremble(terms, 0.5, 0.001, false).fars, 1);
    terms.hysteresis = 0.0009; /* too little */
    assert_true(tremble(terms, 0.5, 0.001, false).fars > 40);
}

/* The boxes of the broad phase hold as long as the contact does: the end is told where it is, not where boxes part. */
static void a_wide_hysteresis_is_kept_to(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_subscription terms = scene_all(WORLD_TOUCH, 0);
    terms.hysteresis = 20;
    scene_subscription(w, &terms);
    scene_sphere(w, "a", 0, 1);
    uint32_t b = scene_sphere(w, "b", 1.5, 1);
    scene_tick(w, 1);
    scene_move(w, b, 21.9, 0);
    assert_int_equal(count_kind(scene_tick(w, 2), EVENT_UPDATE), 1);
    scene_move(w, b, 22.1, 0);
    const world_batch *end = scene_tick(w, 3);
    assert_int_equal(count_kind(end, EVENT_END), 1);
    assert_true(end->events[0].lo > 20);
    scene_move(w, b, 21.9, 0); /* it takes the threshold itself to begin again */
    assert_null(scene_tick(w, 4));
    scene_move(w, b, 1.9, 0);
    assert_int_equal(count_kind(scene_tick(w, 5), EVENT_BEGIN), 1);
    world_destroy(w);
}

/* Of so many pairs that they are looked through in parts: against all of them at once. */
static void the_oldest_stamp_of_very_many_pairs(void **state)
{
    (void)state;
    enum { BALLS = 260, MANY_PAIRS = BALLS * (BALLS - 1) / 2, PARTS_MOST = 4 };
    world *w = scene_world(1, true);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t first = scene_subscription(w, &all), second = scene_subscription(w, &all), balls[BALLS];
    char name[16];
    int64_t oldest_ns;
    size_t looked = 0;
    world_brief brief;
    for (int i = 0; i < BALLS; i++) {
        snprintf(name, sizeof name, "%d", i);
        balls[i] = scene_sphere(w, name, 1e-4 * i, 1);
    }
    scene_tick(w, 1);
    for (int i = 0; i < BALLS; i++) scene_move(w, balls[i], 2e-4 * i, 1000 + (i * 7) % BALLS);
    scene_tick(w, 2000);
    assert_true(world_brief_of(w, first, SIZE_MAX, &brief));
    assert_in_range(brief.pairs, MANY_PAIRS, MANY_PAIRS);
    assert_int_equal(brief.oldest_ns, 1000);
    int parts = 1;
    for (; !world_oldest_stamp(w, first, &looked, &oldest_ns); parts++) {
        assert_in_range(looked, 1, (size_t)parts * OLDEST_STAMP_PART);
        assert_false(world_oldest_stamp(w, second, &looked, &oldest_ns)); /* its turn is later */
    }
    assert_in_range(parts, 2, PARTS_MOST);
    assert_int_equal(oldest_ns, 1000);

    /* A pair begins behind the place that has been reached, and its pose is older than all. */
    looked = 0;
    assert_false(world_oldest_stamp(w, second, &looked, &oldest_ns));
    world_remove_body(w, balls[0], CAUSE_REMOVED);
    scene_tick(w, 2001);
    scene_tick(w, 2002);
    uint32_t late = scene_sphere(w, "late", 0, 1);
    scene_move(w, late, 0, 500);
    scene_tick(w, 2003);
    while (!world_oldest_stamp(w, second, &looked, &oldest_ns)) assert_in_range(looked, 1, 8 * OLDEST_STAMP_PART);
    assert_int_equal(oldest_ns, 500);

    /* Who asks no more keeps nobody from his turn. */
    assert_false(world_oldest_stamp(w, first, &looked, &oldest_ns));
    int asked = 1;
    while (!world_oldest_stamp(w, second, &looked, &oldest_ns)) assert_in_range(++asked, 1, 2 * PARTS_MOST);
    assert_int_equal(oldest_ns, 500);
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_oldest_stamp_of_very_many_pairs),
        cmocka_unit_test(a_pose_sent_again_is_no_news),
        cmocka_unit_test(who_wants_all_is_told_all_once),
        cmocka_unit_test(an_update_that_was_held_back_is_told_once),
        cmocka_unit_test(what_is_known_again_is_told_though_it_is_as_it_was),
        cmocka_unit_test(what_trembles_about_a_threshold_begins_once_and_ends_once),
        cmocka_unit_test(near_and_far_have_the_same_hysteresis),
        cmocka_unit_test(a_wide_hysteresis_is_kept_to),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
