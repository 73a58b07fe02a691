/* Filters: who is looked at, from which side, and from how far: masks one way and both ways, rules that pad and widen
 * single pairs, and what a change of them means to those who were told. */
#include "scene.h"

typedef struct actor {
    const char *name;
    double x;
    uint64_t category, mask;
    bool one_way;
    const filter_rule *rule;
} actor;

static uint32_t put(world *w, uint32_t id, actor a)
{
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    world_body def = {.name = a.name,
        .group = "",
        .category = a.category ? a.category : 1,
        .mask = a.mask,
        .one_way = a.one_way,
        .pose = {{a.x, 0, 0}, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1,
        .rules = a.rule,
        .rule_count = a.rule != NULL};
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static world *watched_world(unsigned facts, double range)
{
    world *w = scene_world(1, true);
    world_subscription all = scene_all(facts, range);
    scene_subscription(w, &all);
    return w;
}

enum { HURT = 2, HIT = 4 };

static void a_hit_box_looks_at_hurt_boxes_that_do_not_look_back(void **state)
{
    (void)state;
    for (int order = 0; order < 2; order++) { /* whichever comes first in the world */
        world *w = watched_world(WORLD_TOUCH, 0);
        actor sword = {"sword", 0, HIT, HURT, true, NULL}, arm = {"arm", 1.5, HURT, 0, false, NULL};
        put(w, WORLD_NONE, order ? sword : arm);
        put(w, WORLD_NONE, order ? arm : sword);
        const world_batch *b = scene_tick(w, 1);
        assert_int_equal(b->count, 1);
        assert_string_equal(b->events[0].name_a, "sword");
        assert_string_equal(b->events[0].name_b, "arm");
        assert_true(b->events[0].axis.x > 0.999999); /* from A to B */
        world_destroy(w);
    }
}

static void two_way_bodies_must_both_look_and_of_two_hit_boxes_one_is_enough(void **state)
{
    (void)state;
    static const struct {
        actor a, b;
        size_t pairs;
    } CASES[] = {
        {{"a", 0, 1, 2, false, NULL}, {"b", 1, 2, 1, false, NULL}, 1},
        {{"a", 0, 1, 2, false, NULL}, {"b", 1, 2, 4, false, NULL}, 0}, /* b does not look */
        {{"a", 0, 1, 2, true, NULL}, {"b", 1, 2, 4, false, NULL}, 1},
        {{"a", 0, 1, 4, true, NULL}, {"b", 1, 2, 1, false, NULL}, 0}, /* that b looks is not asked */
        {{"a", 0, 1, 4, true, NULL}, {"b", 1, 2, 1, true, NULL}, 1},
        {{"a", 0, 1, 4, true, NULL}, {"b", 1, 2, 4, true, NULL}, 0},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        world *w = watched_world(WORLD_TOUCH, 0);
        put(w, WORLD_NONE, CASES[i].a);
        put(w, WORLD_NONE, CASES[i].b);
        assert_int_equal(scene_tick(w, 1)->count, CASES[i].pairs);
        world_destroy(w);
    }
}

static void an_subscription_s_own_sides_come_before_the_look(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_subscription hurt = {
        .facts = WORLD_TOUCH, .select_a = "arm", .select_b = "*", .tolerance = 1e-9}; /* it wants the arm as A */
    scene_subscription(w, &hurt);
    put(w, WORLD_NONE, (actor){"sword", 0, HIT, HURT, true, NULL});
    put(w, WORLD_NONE, (actor){"arm", 1.5, HURT, 0, false, NULL});
    assert_string_equal(scene_tick(w, 1)->events[0].name_a, "arm");
    world_destroy(w);
}

/* Gap of two unit spheres at 0 and x: x - 2. The box of the fat margin is 0.1 m: 5 m of padding are beyond it. */
static void padding_moves_the_touch_of_the_pairs_of_its_rule_alone(void **state)
{
    (void)state;
    world *w = watched_world(WORLD_TOUCH, 0);
    filter_rule far = {.pattern = "human*", .padding = 5};
    uint32_t tool = put(w, WORLD_NONE, (actor){"tool", 0, 1, UINT64_MAX, false, &far});
    uint32_t human = put(w, WORLD_NONE, (actor){"human1", 7.001, 1, UINT64_MAX, false, NULL});
    put(w, WORLD_NONE, (actor){"crate", -6.9, 1, UINT64_MAX, false, NULL});
    assert_int_equal(scene_tick(w, 1)->count, 0);

    scene_move(w, human, 6.999, 0);
    const world_batch *b = scene_tick(w, 2);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, EVENT_BEGIN);
    assert_true(b->events[0].lo <= 4.999 && b->events[0].hi >= 4.999); /* the distance itself is not changed */

    scene_move(w, human, 7.001, 0);
    b = scene_tick(w, 3);
    assert_int_equal(b->events[0].kind, EVENT_END);
    assert_int_equal(b->events[0].cause, CAUSE_MOTION);

    scene_move(w, tool, 0.01, 0); /* and from the other body's side */
    assert_int_equal(scene_tick(w, 4)->events[0].kind, EVENT_BEGIN);
    world_destroy(w);
}

static void negative_padding_lets_a_pair_sink_in(void **state)
{
    (void)state;
    world *w = watched_world(WORLD_TOUCH, 0);
    filter_rule press = {.pattern = "hole", .padding = -0.01};
    uint32_t peg = put(w, WORLD_NONE, (actor){"peg", 0, 1, UINT64_MAX, false, &press});
    put(w, WORLD_NONE, (actor){"hole", 1.995, 1, UINT64_MAX, false, NULL});
    assert_int_equal(scene_tick(w, 1)->count, 0);
    scene_move(w, peg, 0.0051, 0);
    assert_int_equal(scene_tick(w, 2)->count, 1);
    world_destroy(w);
}

static void a_margin_tells_distances_from_farther_away_and_the_larger_rule_counts(void **state)
{
    (void)state;
    world *w = watched_world(WORLD_DISTANCE, 1);
    filter_rule some = {.pattern = "*", .margin = 1}, more = {.pattern = "*", .margin = 3};
    put(w, WORLD_NONE, (actor){"a", 0, 1, UINT64_MAX, false, &some});
    uint32_t b = put(w, WORLD_NONE, (actor){"b", 6.001, 1, UINT64_MAX, false, &more});
    put(w, WORLD_NONE, (actor){"c", -3.001, 1, UINT64_MAX, false, NULL}); /* 1.001 from a: within its margin */
    assert_int_equal(scene_tick(w, 1)->count, 1);
    scene_move(w, b, 5.999, 0);
    const world_batch *batch = scene_tick(w, 2);
    assert_int_equal(batch->count, 1);
    assert_int_equal(batch->events[0].kind, EVENT_NEAR);
    assert_string_equal(batch->events[0].name_b, "b");
    world_destroy(w);
}

static void a_change_of_rules_begins_and_ends_and_says_that_it_was_the_filter(void **state)
{
    (void)state;
    world *w = watched_world(WORLD_TOUCH, 0);
    filter_rule far = {.pattern = "*", .padding = 0.5}, glued = {.pattern = "*", .allow = true};
    actor a = {"a", 0, 1, UINT64_MAX, false, NULL};
    uint32_t id = put(w, WORLD_NONE, a);
    put(w, WORLD_NONE, (actor){"b", 2.3, 1, UINT64_MAX, false, NULL});
    assert_int_equal(scene_tick(w, 1)->count, 0);
    const filter_rule *const rules[] = {&far, NULL, &far, &glued, &far};
    const event_kind told[] = {EVENT_BEGIN, EVENT_END, EVENT_BEGIN, EVENT_END, EVENT_BEGIN};
    for (int i = 0; i < 5; i++) {
        a.rule = rules[i];
        put(w, id, a);
        const world_batch *batch = scene_tick(w, 2 + i);
        assert_int_equal(batch->count, 1);
        assert_int_equal(batch->events[0].kind, told[i]);
        assert_int_equal(batch->events[0].cause, CAUSE_FILTER);
    }
    world_destroy(w);
}

/* A pair that was proven apart by more than was asked then, and stands where it stood. */
static void a_padding_that_comes_later_reaches_a_pair_that_was_apart(void **state)
{
    (void)state;
    filter_rule far = {.pattern = "a", .padding = 0.16}, near = {.pattern = "a", .padding = 0.14};
    world *w = watched_world(WORLD_TOUCH, 0);
    put(w, WORLD_NONE, (actor){"a", 0, 1, 1, false, NULL});
    uint32_t id = put(w, WORLD_NONE, (actor){"b", 2.15, 1, 1, false, NULL});
    for (int tick = 1; tick < 3; tick++) {
        const world_batch *b = scene_tick(w, tick);
        assert_true(!b || !b->count);
        assert_int_equal(world_get_figures(w).pairs, 1);
        world_move_body(w, id, (pose){{2.15, 0, 0}, {1, 0, 0, 0}}, tick, NULL, NULL);
    }
    put(w, id, (actor){"b", 2.15, 1, 1, false, &far});
    const world_batch *begins = scene_tick(w, 3);
    assert_true(begins && begins->count == 1 && begins->events[0].kind == EVENT_BEGIN);
    put(w, id, (actor){"b", 2.15, 1, 1, false, &near});
    const world_batch *ends = scene_tick(w, 4);
    assert_true(ends && ends->count == 1 && ends->events[0].kind == EVENT_END);
    world_destroy(w);
}

static void explain_tells_the_way_and_the_padding(void **state)
{
    (void)state;
    char text[2048];
    world *w = watched_world(WORLD_TOUCH, 0);
    filter_rule far = {.pattern = "arm", .padding = 0.25, .margin = 2, .reason = "sharp"};
    uint32_t sword = put(w, WORLD_NONE, (actor){"sword", 0, HIT, HURT, true, &far});
    uint32_t arm = put(w, WORLD_NONE, (actor){"arm", 1.5, HURT, 0, false, NULL});
    scene_tick(w, 1);
    for (int turned = 0; turned < 2; turned++) {
        world_explain(w, turned ? arm : sword, turned ? sword : arm, 1, text, sizeof text);
        assert_non_null(strstr(text, "checked, a rule asks for it"));
        assert_non_null(strstr(text, "sharp"));
        assert_non_null(strstr(text, "one way: sword looks at arm"));
        assert_non_null(strstr(text, "rules add 0.25 m to the threshold and 2 m to the range"));
    }
    world_destroy(w);
}

/* Of two bodies of eight balls each, which meet as 64 pairs: their rules are held against each other when they meet,
 * and again when one of them has others; neither for each two balls nor in each tick. */
static void rules_are_matched_once_for_two_bodies(void **state)
{
    (void)state;
    enum { BALLS = 8 };
    world *w = watched_world(WORLD_TOUCH, 0);
    world_shape balls[BALLS];
    for (int i = 0; i < BALLS; i++)
        balls[i] = (world_shape){.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    filter_rule rules[2] = {{.pattern = "nobody", .allow = true}, {.pattern = "*", .padding = 0.5}};
    world_body def = {.group = "",
        .category = 1,
        .mask = 1,
        .pose = POSE_IDENTITY,
        .shapes = balls,
        .shape_count = BALLS,
        .rules = rules,
        .rule_count = 2};
    uint32_t id[2] = {WORLD_NONE, WORLD_NONE};
    for (int i = 0; i < 2; i++) {
        def.name = i ? "b" : "a";
        def.pose.p.x = 2.3 * i;
        assert_int_equal(world_put_body(w, &id[i], &def), WORLD_OK);
    }
    for (int tick = 1; tick < 5; tick++) {
        const world_batch *b = scene_tick(w, tick);
        assert_true(tick > 1 || b->count == BALLS * BALLS);
        assert_int_equal(world_get_figures(w).rulings, 1);
        scene_move(w, id[1], 2.3 + 0.01 * tick, 0);
    }
    rules[1].padding = 0.1; /* of the one body: of the other they stay */
    def.pose.p.x = 2.3;
    assert_int_equal(world_put_body(w, &id[1], &def), WORLD_OK);
    assert_int_equal(world_get_figures(w).pairs, BALLS * BALLS);
    const world_batch *b = scene_tick(w, 5); /* the larger padding counts */
    for (size_t i = 0; b && i < b->count; i++) assert_int_equal(b->events[i].kind, EVENT_UPDATE);
    assert_int_equal(world_get_figures(w).rulings, 2);
    def.name = "a", def.pose.p.x = 0;
    assert_int_equal(world_put_body(w, &id[0], &def), WORLD_OK);
    const world_batch *ends = scene_tick(w, 6);
    assert_true(ends && ends->count == BALLS * BALLS && ends->events[0].kind == EVENT_END);
    assert_int_equal(world_get_figures(w).rulings, 3);
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hit_box_looks_at_hurt_boxes_that_do_not_look_back),
        cmocka_unit_test(two_way_bodies_must_both_look_and_of_two_hit_boxes_one_is_enough),
        cmocka_unit_test(an_subscription_s_own_sides_come_before_the_look),
        cmocka_unit_test(padding_moves_the_touch_of_the_pairs_of_its_rule_alone),
        cmocka_unit_test(negative_padding_lets_a_pair_sink_in),
        cmocka_unit_test(a_margin_tells_distances_from_farther_away_and_the_larger_rule_counts),
        cmocka_unit_test(a_change_of_rules_begins_and_ends_and_says_that_it_was_the_filter),
        cmocka_unit_test(a_padding_that_comes_later_reaches_a_pair_that_was_apart),
        cmocka_unit_test(explain_tells_the_way_and_the_padding),
        cmocka_unit_test(rules_are_matched_once_for_two_bodies),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
