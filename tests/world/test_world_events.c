/* What a subscriber is told: begin, update, end, near, far, unknown, known; by whatever they are caused. */
#include "scene.h"

#include <math.h>
#include <stdio.h>

static void a_contact_begins_persists_and_ends_under_one_id(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 0, 1);
    scene_sphere(w, "b", 3, 1);
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_MANIFOLD, 0);
    scene_subscription(w, &all);
    const world_batch *b = scene_tick(w, 1);
    assert_true(b->snapshot);
    assert_int_equal(b->count, 0);

    scene_move(w, a, 1.5, 0);
    b = scene_tick(w, 2);
    assert_int_equal(b->count, 1);
    world_event begin = b->events[0];
    assert_int_equal(begin.kind, EVENT_BEGIN);
    assert_string_equal(begin.name_a, "a");
    assert_string_equal(begin.name_b, "b");
    assert_true(begin.lo <= -0.5 && begin.hi >= -0.5 && begin.hi - begin.lo <= 1e-9);
    assert_true(begin.axis.x > 0.999999);
    assert_int_equal(begin.manifold.count, 1);

    scene_move(w, a, 1.25, 0);
    b = scene_tick(w, 3);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_UPDATE);
    assert_int_equal(b->events[0].contact, begin.contact);

    assert_null(scene_tick(w, 4)); /* a resting scene says nothing */

    scene_move(w, a, 0.5, 0);
    b = scene_tick(w, 5);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_END);
    assert_int_equal(b->events[0].contact, begin.contact);
    assert_int_equal(b->events[0].cause, CAUSE_MOTION);

    scene_move(w, a, 1.5, 0);
    b = scene_tick(w, 6);
    assert_int_equal(b->events[0].kind, EVENT_BEGIN);
    assert_int_not_equal(b->events[0].contact, begin.contact);
    world_destroy(w);
}

static void touching_exactly_counts_as_contact(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    scene_sphere(w, "a", 0, 1);
    scene_sphere(w, "b", 2, 1);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    const world_batch *b = scene_tick(w, 1);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_BEGIN);
    world_destroy(w);
}

static void teleport(void *w, uint32_t a)
{
    scene_move(w, a, 1e6, 0);
}
static void removal(void *w, uint32_t a)
{
    world_remove_body(w, a, CAUSE_REMOVED);
}
static void loss(void *w, uint32_t a)
{
    world_remove_body(w, a, CAUSE_OWNER_LOST);
}
static void redefine(world *w, uint32_t a, const char *name, double radius, uint64_t mask, const filter_rule *rule)
{
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = radius}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = mask,
        .pose = {{1.5, 0, 0}, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1,
        .rules = rule,
        .rule_count = rule != NULL};
    assert_int_equal(world_put_body(w, &a, &def), WORLD_OK);
}
static void masking(void *w, uint32_t a)
{
    redefine(w, a, "a", 1, 0, NULL);
}
static void allowing(void *w, uint32_t a)
{
    redefine(w, a, "a", 1, 1, &(filter_rule){.pattern = "b", .allow = true, .reason = "they are glued"});
}
static void resizing(void *w, uint32_t a)
{
    redefine(w, a, "a", 0.1, 1, NULL);
}
static void renaming(void *w, uint32_t a)
{
    redefine(w, a, "c", 0.1, 1, NULL);
}
static void unsubscribing(void *w, uint32_t a)
{
    (void)a;
    world_remove_subscription(w, 0, CAUSE_SUBSCRIPTION);
}

static void whatever_ends_a_contact_it_ends_once_and_the_cause_is_told(void **state)
{
    (void)state;
    static const struct {
        void (*how)(void *w, uint32_t a);
        event_cause cause;
    } WAYS[] = {{teleport, CAUSE_MOTION}, {removal, CAUSE_REMOVED}, {loss, CAUSE_OWNER_LOST}, {masking, CAUSE_FILTER},
        {allowing, CAUSE_FILTER}, {resizing, CAUSE_SHAPE}, {renaming, CAUSE_SHAPE},
        {unsubscribing, CAUSE_SUBSCRIPTION}};
    for (size_t i = 0; i < sizeof WAYS / sizeof *WAYS; i++) {
        world *w = scene_world(1, true);
        uint32_t a = scene_sphere(w, "a", 1.5, 1);
        scene_sphere(w, "b", 3, 1);
        world_subscription all = scene_all(WORLD_TOUCH, 0);
        scene_subscription(w, &all);
        int64_t contact = scene_tick(w, 1)->events[0].contact;
        WAYS[i].how(w, a);
        const world_batch *b = scene_tick(w, 2);
        assert_non_null(b);
        assert_int_equal(b->count, 1);
        assert_int_equal(b->events[0].kind, EVENT_END);
        assert_int_equal(b->events[0].contact, contact);
        assert_int_equal(b->events[0].cause, WAYS[i].cause);
        assert_string_equal(b->events[0].name_a, "a");
        assert_null(scene_tick(w, 3));
        assert_int_equal(world_get_figures(w).contacts, 0);
        world_destroy(w);
    }
}

static void distances_are_told_within_the_range_only(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 0, 1);
    scene_sphere(w, "b", 5, 1);
    world_subscription near = scene_all(WORLD_DISTANCE, 2);
    scene_subscription(w, &near);
    assert_int_equal(scene_tick(w, 1)->count, 0);
    scene_move(w, a, 1.5, 0);
    const world_batch *b = scene_tick(w, 2);
    assert_int_equal(b->events[0].kind, EVENT_NEAR);
    assert_true(fabs(b->events[0].lo - 1.5) < 1e-9);
    int64_t id = b->events[0].contact;
    scene_move(w, a, 4, 0); /* overlapping: still a distance, a negative one */
    b = scene_tick(w, 3);
    assert_int_equal(b->events[0].kind, EVENT_NEAR);
    assert_int_equal(b->events[0].contact, id);
    assert_true(fabs(b->events[0].lo + 1) < 1e-9);
    scene_move(w, a, -10, 0);
    b = scene_tick(w, 4);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_FAR);
    assert_int_equal(b->events[0].contact, id);
    world_destroy(w);
}

static void selectors_decide_who_is_a(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    scene_sphere(w, "arm", 0, 1);
    scene_sphere(w, "table", 1, 1);
    scene_sphere(w, "chair", 1.5, 1);
    world_subscription def = {.facts = WORLD_TOUCH, .select_a = "table", .select_b = "arm", .tolerance = 1e-9};
    scene_subscription(w, &def);
    const world_batch *b = scene_tick(w, 1);
    assert_int_equal(b->count, 1);
    assert_string_equal(b->events[0].name_a, "table");
    assert_string_equal(b->events[0].name_b, "arm");
    assert_true(b->events[0].axis.x < -0.999);
    world_destroy(w);
}

static void nobody_interested_means_no_narrow_phase(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 0, 1);
    scene_sphere(w, "b", 1, 1);
    for (int t = 1; t < 10; t++) {
        scene_move(w, a, 0.01 * t, 0);
        assert_null(scene_tick(w, t));
    }
    world_figures f = world_get_figures(w);
    assert_int_equal(f.narrow_queries, 0);
    assert_int_equal(f.pairs, 0);
    world_destroy(w);
}

static uint32_t timed_sphere(world *w, const char *name, double x, int64_t deadline_ns, int64_t stamp_ns)
{
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = {{x, 0, 0}, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1,
        .deadline_ns = deadline_ns,
        .stamp_ns = stamp_ns};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static void past_its_deadline_a_body_is_unknown_not_free(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    int64_t t0 = 100LL * SECOND;
    uint32_t a = timed_sphere(w, "a", 0, SECOND, t0);
    scene_sphere(w, "b", 1.5, 1);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    const world_batch *b = scene_tick(w, t0 + SECOND / 4);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].age_a_ns, SECOND / 4);
    assert_int_equal(b->events[0].age_b_ns, -1);
    int64_t contact = b->events[0].contact;
    assert_int_equal(world_next_due_ns(w), t0 + SECOND);

    b = scene_tick(w, t0 + SECOND);
    assert_int_equal(b->count, 2);
    assert_int_equal(b->events[0].kind, EVENT_UNKNOWN);
    assert_string_equal(b->events[0].name_b, "*");
    assert_int_equal(b->events[1].kind, EVENT_UNKNOWN);
    assert_int_equal(b->events[1].contact, contact);
    assert_true(isinf(b->events[1].lo) && isinf(b->events[1].hi));
    assert_int_equal(world_get_figures(w).stale_bodies, 1);

    world_want_snapshot(w, 0); /* one that comes late is told so too */
    b = scene_tick(w, t0 + SECOND + 1);
    assert_true(b->snapshot);
    assert_int_equal(b->count, 3);
    assert_int_equal(b->events[0].kind, EVENT_BEGIN);
    assert_int_equal(b->events[1].kind, EVENT_UNKNOWN);
    assert_int_equal(b->events[2].kind, EVENT_UNKNOWN);

    scene_move(w, a, 0, t0 + 2LL * SECOND); /* back again: known, and its contact goes on */
    b = scene_tick(w, t0 + 2LL * SECOND);
    assert_int_equal(b->count, 3);
    assert_int_equal(b->events[0].kind, EVENT_KNOWN);
    assert_int_equal(b->events[1].kind, EVENT_KNOWN);
    assert_int_equal(b->events[1].contact, contact);
    assert_int_equal(b->events[2].kind, EVENT_UPDATE);
    world_destroy(w);
}

static void a_stale_body_that_is_removed_is_unknown_no_more(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = timed_sphere(w, "a", 0, SECOND, SECOND);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    assert_int_equal(scene_tick(w, 3LL * SECOND)->events[0].kind, EVENT_UNKNOWN);
    world_remove_body(w, a, CAUSE_REMOVED);
    const world_batch *b = scene_tick(w, 3LL * SECOND);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_KNOWN);
    assert_int_equal(b->events[0].cause, CAUSE_REMOVED);
    assert_int_equal(world_get_figures(w).stale_bodies, 0);
    world_destroy(w);
}

static void what_is_told_is_as_narrow_as_was_asked(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 1.5, 1);
    scene_sphere(w, "b", 3, 1);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    const world_batch *b = scene_tick(w, 1);
    assert_true(b->events[0].hi - b->events[0].lo <= 1e-9);
    scene_move(w, a, 0.95, 0);
    b = scene_tick(w, 2);
    assert_int_equal(b->events[0].kind, EVENT_END);
    assert_true(b->events[0].hi - b->events[0].lo <= 1e-9);
    world_destroy(w);
}

static void only_a_pose_makes_a_stale_body_fresh(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    timed_sphere(w, "a", 0, SECOND, 0); /* not stamped: its deadline counts from when it came */
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(w, &all);
    scene_tick(w, SECOND);
    assert_int_equal(scene_tick(w, 3LL * SECOND)->events[0].kind, EVENT_UNKNOWN);
    all.threshold = 0.5;
    assert_int_equal(world_put_subscription(w, &id, &all), WORLD_OK);
    const world_batch *b = scene_tick(w, 3LL * SECOND + 1);
    for (size_t i = 0; i < b->count; i++) assert_int_not_equal(b->events[i].kind, EVENT_KNOWN);
    assert_int_equal(world_get_figures(w).stale_bodies, 1);
    world_destroy(w);
}

static void a_stamp_of_the_future_grows_stale_in_time(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    timed_sphere(w, "a", 0, SECOND, 1000LL * SECOND); /* its host's clock is ahead */
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    assert_int_equal(world_get_figures(w).stale_bodies, 0);
    scene_tick(w, 2LL * SECOND);
    assert_int_equal(world_get_figures(w).stale_bodies, 1);
    world_destroy(w);
}

static void a_deadline_of_ages_is_no_deadline(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    timed_sphere(w, "a", 0, INT64_MAX, SECOND);
    scene_tick(w, 2LL * SECOND);
    assert_int_equal(world_get_figures(w).stale_bodies, 0);
    world_destroy(w);
}

static void a_held_body_is_stale_at_once_and_until_its_next_pose(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 0, 1);
    scene_sphere(w, "b", 1.5, 1);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    scene_tick(w, 1);
    world_hold_body(w, a);
    const world_batch *b = scene_tick(w, 2);
    assert_int_equal(b->count, 2);
    assert_int_equal(b->events[0].kind, EVENT_UNKNOWN);
    scene_move(w, a, 3.55, 3); /* apart, but the fat boxes still meet */
    b = scene_tick(w, 3);
    assert_int_equal(b->events[0].kind, EVENT_KNOWN);
    assert_int_equal(b->events[b->count - 1].kind, EVENT_END);
    world_destroy(w);
}

static void a_rate_holds_updates_back_but_loses_none_of_their_ends(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 1.5, 1);
    scene_sphere(w, "b", 3, 1);
    world_subscription slow = scene_all(WORLD_TOUCH, 0);
    slow.period_ns = SECOND;
    scene_subscription(w, &slow);
    assert_int_equal(scene_tick(w, 10LL * SECOND)->count, 1);
    for (int i = 1; i <= 9; i++) {
        scene_move(w, a, 1.5 + 0.01 * i, 0);
        assert_null(scene_tick(w, 10LL * SECOND + i * (SECOND / 10)));
    }
    assert_int_equal(world_next_due_ns(w), 11LL * SECOND);
    const world_batch *b = scene_tick(w, 11LL * SECOND); /* the last of them, though nothing moves any more */
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_UPDATE);
    assert_true(fabs(b->events[0].lo + 0.59) < 1e-8);
    scene_move(w, a, 0, 0);
    assert_int_equal(scene_tick(w, 11LL * SECOND + 1)->events[0].kind, EVENT_END); /* ends do not wait */
    world_destroy(w);
}

static void a_snapshot_tells_all_that_is(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    for (int i = 0; i < 10; i++) {
        char name[16];
        snprintf(name, sizeof name, "s%d", i);
        scene_sphere(w, name, 1.5 * i, 1);
    }
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE, 1.5);
    scene_subscription(w, &all);
    const world_batch *b = scene_tick(w, 1);
    assert_true(b->snapshot);
    assert_int_equal(b->count, 9 + 17); /* neighbours touch, they and the next ones are near */
    world_want_snapshot(w, 0);
    b = scene_tick(w, 2);
    assert_true(b->snapshot);
    assert_int_equal(b->count, 26);
    int64_t last = 0;
    for (size_t i = 0; i < b->count; i++) {
        assert_int_equal(b->events[i].cause, CAUSE_SNAPSHOT);
        assert_true(b->events[i].contact > last);
        last = b->events[i].contact;
    }
    world_destroy(w);
}

static void names_are_unique(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = scene_sphere(w, "a", 0, 1);
    world_body def = {.name = "a", .group = "", .pose = POSE_IDENTITY};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_NAME_TAKEN);
    assert_int_equal(world_remove_body(w, a, CAUSE_REMOVED), WORLD_OK);
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK); /* free at once */
    assert_int_equal(world_find_body(w, "a"), id);
    assert_int_equal(world_move_body(w, a, POSE_IDENTITY, 0, NULL, NULL), WORLD_UNKNOWN_ID);
    world_destroy(w);
}

/* Contacts begin, have an update that the rate holds back, and end, again and again: nothing is kept of those that
 * ended (see world_validate), and of the one that stands at last one update is told when the rate allows. */
static void updates_of_what_has_ended_do_not_pile_up(void **state)
{
    (void)state;
    const int64_t period = 1000000;
    world *w = scene_world(1, true);
    world_subscription slow = scene_all(WORLD_TOUCH, 0);
    slow.period_ns = period;
    scene_subscription(w, &slow);
    uint32_t id = scene_sphere(w, "a", 0, 0.5);
    scene_sphere(w, "b", 0.9, 0.5);
    scene_sphere(w, "c", 0.95, 0.5); /* touches b all along */
    int64_t now = 10 * period, held = 0;
    scene_tick(w, now);
    for (int i = 0; i < 3 * 200 + 2; i++) {
        scene_move(w, id, i % 3 == 2 ? -1 : 1e-3 * (i % 3 + 1), 0);
        const world_batch *b = scene_tick(w, ++now);
        held += i % 3 == 1 && !b;
    }
    assert_in_range(held, 195, 201); /* nearly all, the first few may be told */
    const world_batch *b = scene_tick(w, now + 2 * period);
    assert_int_equal(b->count, 2); /* with b and with c, once each */
    assert_int_equal(b->events[0].kind, EVENT_UPDATE);
    assert_int_equal(b->events[1].kind, EVENT_UPDATE);
    assert_null(scene_tick(w, now + 4 * period));
    world_destroy(w);
}

/* Far away in one tick, beyond any box: it ends with the distance that it has then. What is unknown does not end. */
static void an_end_tells_how_they_are_then_whatever_their_boxes(void **state)
{
    (void)state;
    for (int margin = 0; margin <= 100; margin += 50) {
        world_options o = world_options_default();
        o.margin = margin;
        world *w = world_create(&o);
        uint32_t a = scene_sphere(w, "a", 0, 1);
        scene_sphere(w, "b", 1.5, 1);
        world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE, 0.5);
        scene_subscription(w, &all);
        scene_tick(w, 1);
        scene_move(w, a, -30, 2);
        const world_batch *b = scene_tick(w, 2);
        assert_int_equal(b->count, 2);
        for (size_t i = 0; i < 2; i++) {
            assert_int_equal(b->events[i].kind, i ? EVENT_FAR : EVENT_END);
            assert_true(fabs(b->events[i].lo - 29.5) < 1e-6 && b->events[i].cause == CAUSE_MOTION);
        }
        scene_move(w, a, 0, 3);
        assert_int_equal(scene_tick(w, 3)->count, 2);
        uint32_t other = world_find_body(w, "b");
        world_hold_body(w, other);
        scene_tick(w, 4);
        scene_move(w, a, -30, 5);
        assert_null(scene_tick(w, 5));
        scene_move(w, other, 1.5, 6);
        b = scene_tick(w, 6);
        assert_true(b->count > 2 && b->events[b->count - 2].kind == EVENT_END && b->events[b->count - 2].lo > 29);
        world_destroy(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_contact_begins_persists_and_ends_under_one_id),
        cmocka_unit_test(touching_exactly_counts_as_contact),
        cmocka_unit_test(whatever_ends_a_contact_it_ends_once_and_the_cause_is_told),
        cmocka_unit_test(distances_are_told_within_the_range_only),
        cmocka_unit_test(an_end_tells_how_they_are_then_whatever_their_boxes),
        cmocka_unit_test(selectors_decide_who_is_a),
        cmocka_unit_test(nobody_interested_means_no_narrow_phase),
        cmocka_unit_test(past_its_deadline_a_body_is_unknown_not_free),
        cmocka_unit_test(a_stale_body_that_is_removed_is_unknown_no_more),
        cmocka_unit_test(what_is_told_is_as_narrow_as_was_asked),
        cmocka_unit_test(only_a_pose_makes_a_stale_body_fresh),
        cmocka_unit_test(a_stamp_of_the_future_grows_stale_in_time),
        cmocka_unit_test(a_deadline_of_ages_is_no_deadline),
        cmocka_unit_test(a_held_body_is_stale_at_once_and_until_its_next_pose),
        cmocka_unit_test(a_rate_holds_updates_back_but_loses_none_of_their_ends),
        cmocka_unit_test(a_snapshot_tells_all_that_is),
        cmocka_unit_test(names_are_unique),
        cmocka_unit_test(updates_of_what_has_ended_do_not_pile_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
