/* Ways and courses that are easily missed: of different spans, in the orientation of the end, of half-spaces and of
 * fixed bodies, redefined or stale underway; and what is told of a pair that ends for one subscription only. */
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WAYPOINTS = 64 }; /* of a body in one tick */

static const quat UPRIGHT = {1, 0, 0, 0};

static world_body body_of(const char *name, const world_shape *shape, vec3 at, world_ccd ccd)
{
    return (world_body){.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .ccd = ccd,
        .stamp_ns = SECOND,
        .pose = {at, UPRIGHT},
        .shapes = shape,
        .shape_count = 1};
}

static uint32_t put(world *w, const world_body *def)
{
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, def), WORLD_OK);
    return id;
}

static uint32_t ball(world *w, const char *name, vec3 at, double radius, world_ccd ccd)
{
    world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = radius}, .local = POSE_IDENTITY};
    world_body def = body_of(name, &s, at, ccd);
    return put(w, &def);
}

static uint32_t rod(world *w, const char *name, vec3 at, world_ccd ccd)
{
    world_shape s = {.shape = {.type = SHAPE_CAPSULE, .radius = 0.01, .half = {0, 0, 1}}, .local = POSE_IDENTITY};
    world_body def = body_of(name, &s, at, ccd);
    return put(w, &def);
}

static world_subscription all_of(unsigned facts, double horizon)
{
    return (world_subscription){
        .facts = facts, .select_a = "*", .select_b = "*", .tolerance = 1e-9, .horizon = horizon};
}

static void move(world *w, uint32_t id, vec3 at, quat q, int64_t stamp_ns, const vec3 *linear, const vec3 *angular)
{
    assert_int_equal(world_move_body(w, id, (pose){at, q}, stamp_ns, linear, angular), WORLD_OK);
}

static int count(const world_batch *b, uint8_t kind)
{
    int n = 0;
    for (size_t i = 0; b && i < b->count; i++) n += b->events[i].kind == kind;
    return n;
}

/* A rod turns by 1.2 rad in 0.1 s, and so it says; the other body's last pose is a second old. It makes no whole turn
 * in that second. */
static void each_ways_turns_are_those_of_its_own_time(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t post = ball(w, "post", vec(0.9, 0, 0), 0.05, WORLD_CCD_OFF),
             turning = rod(w, "rod", VEC_ZERO, WORLD_CCD_FULL);
    world_subscription all = all_of(WORLD_IMPACT, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    move(w, turning, VEC_ZERO, UPRIGHT, SECOND + 9 * (int64_t)SECOND / 10, NULL, NULL);
    scene_tick(w, SECOND + 9 * (int64_t)SECOND / 10);
    vec3 still = VEC_ZERO, spin = {0, 12, 0};
    quat q = {cos(0.6), 0, sin(0.6), 0};
    move(w, turning, VEC_ZERO, q, 2 * (int64_t)SECOND, &still, &spin);
    move(w, post, vec(0.9, 0, 0), UPRIGHT, 2 * (int64_t)SECOND, NULL, NULL);
    assert_int_equal(count(scene_tick(w, 2 * (int64_t)SECOND), EVENT_IMPACT), 0);
    assert_true(world_get_figures(w).sweeps > 0);
    world_destroy(w);
}

/* Not by the rounding of its orientation either: a way that turns is dearer to sweep. */
static void what_keeps_its_orientation_does_not_turn(void **state)
{
    (void)state;
    for (int i = 0; i < 1000; i++) {
        quat q = quat_unit((quat){1, 0.001 * i, -0.003 * i, 0.7});
        motion m = motion_between((pose){vec(1, 2, 3), q}, (pose){vec(2, 2, i), q}, 0.01);
        assert_true(m.angular.x == 0 && m.angular.y == 0 && m.angular.z == 0 && m.linear.x == 100);
    }
}

/* In the orientation of its end, the rod is in the post from the beginning; it was not when it stood upright. */
static void a_linear_way_that_begins_in_contact_is_told(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t id = rod(w, "rod", VEC_ZERO, WORLD_CCD_LINEAR);
    ball(w, "post", vec(0.9, 0, 0), 0.05, WORLD_CCD_OFF);
    world_subscription all = all_of(WORLD_IMPACT | WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    quat lying = {sqrt(0.5), 0, sqrt(0.5), 0};
    move(w, id, vec(-2, 0, 0), lying, 2 * (int64_t)SECOND, NULL, NULL);
    const world_batch *b = scene_tick(w, 2 * (int64_t)SECOND);
    assert_int_equal(count(b, EVENT_IMPACT), 1);
    assert_int_equal(count(b, EVENT_BEGIN), 0);

    move(w, id, vec(0.3, 0, 0), lying, 3 * (int64_t)SECOND, NULL, NULL); /* in contact, ... */
    assert_int_equal(count(scene_tick(w, 3 * (int64_t)SECOND), EVENT_BEGIN), 1);
    move(w, id, vec(-2, 0, 0), lying, 4 * (int64_t)SECOND, NULL, NULL); /* ... from which it goes: that was told */
    b = scene_tick(w, 4 * (int64_t)SECOND);
    assert_int_equal(count(b, EVENT_IMPACT), 0);
    assert_int_equal(count(b, EVENT_END), 1);
    world_destroy(w);
}

static world_body floor_body(const world_shape *s)
{
    world_body def = body_of("floor", s, VEC_ZERO, WORLD_CCD_OFF);
    return def;
}

/* A floor that rises, and one that may begin to turn: about its origin, 10 m from the ball. */
static void half_spaces_have_courses(void **state)
{
    (void)state;
    for (int turns = 0; turns < 2; turns++) {
        world *w = scene_world(1, true);
        world_shape s = {.shape = {.type = SHAPE_HALFSPACE}, .local = POSE_IDENTITY};
        world_body def = floor_body(&s);
        def.angular_acceleration = turns ? 0.2 : 0;
        uint32_t id = put(w, &def);
        ball(w, "ball", vec(10, 0, 2), 0.5, WORLD_CCD_OFF); /* 1.5 m above it */
        world_subscription all = all_of(WORLD_PREDICT, 2);
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        vec3 up = {0, 0, turns ? 0 : 1};
        move(w, id, VEC_ZERO, UPRIGHT, 2 * (int64_t)SECOND, &up, NULL);
        world_batches out;
        world_tick(w, 2 * (int64_t)SECOND, &out);
        assert_int_equal(world_get_figures(w).predicted, 1);
        world_want_snapshot(w, 0);
        const world_batch *b = scene_tick(w, 3 * (int64_t)SECOND);
        assert_int_equal(b->count, 1);
        double truth = turns ? sqrt(2 * 0.1483 / 0.2) : 1.5; /* 10 sin(0.1483) = 2 cos(0.1483) - 0.5 */
        assert_true(b->events[0].impact.lo <= truth + 1e-6 && b->events[0].impact.lo > 0.9 * truth);
        world_destroy(w);
    }
}

/* What is fixed may be put elsewhere by a pose: that is swept, but it has no course. */
static void a_fixed_body_has_a_way_and_no_course(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_shape s = {.shape = {.type = SHAPE_BOX, .half = {0.05, 1, 1}}, .local = POSE_IDENTITY};
    world_body def = body_of("wall", &s, vec(-2, 0, 0), WORLD_CCD_LINEAR);
    def.fixed = true;
    uint32_t id = put(w, &def);
    ball(w, "ball", VEC_ZERO, 0.5, WORLD_CCD_OFF);
    world_subscription all = all_of(WORLD_IMPACT | WORLD_PREDICT, 2);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    move(w, id, vec(-0.6, 0, 0), UPRIGHT, 2 * (int64_t)SECOND, NULL, NULL); /* 5 cm before it */
    assert_null(scene_tick(w, 2 * (int64_t)SECOND));
    move(w, id, vec(2, 0, 0), UPRIGHT, 3 * (int64_t)SECOND, NULL, NULL);
    assert_int_equal(count(scene_tick(w, 3 * (int64_t)SECOND), EVENT_IMPACT), 1);
    assert_int_equal(world_get_figures(w).predicted, 0);
    world_destroy(w);
}

/* Another definition at the newest pose, in the tick of that pose: it keeps its way and its velocities. */
static void a_redefinition_underway_keeps_the_way(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = 0.1}, .local = POSE_IDENTITY};
    world_body def = body_of("bullet", &s, vec(-1, 0, 0), WORLD_CCD_FULL);
    uint32_t id = put(w, &def);
    ball(w, "post", VEC_ZERO, 0.1, WORLD_CCD_OFF);
    world_subscription all = all_of(WORLD_IMPACT, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    move(w, id, vec(1, 0, 0), UPRIGHT, 2 * (int64_t)SECOND, NULL, NULL);
    def.pose = world_body_pose(w, id);
    def.stamp_ns = world_body_stamp_ns(w, id);
    def.category = 3;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    assert_int_equal(count(scene_tick(w, 2 * (int64_t)SECOND), EVENT_IMPACT), 1);

    def.pose.p = vec(-1, 0, 0); /* elsewhere: no way leads there */
    def.stamp_ns = 3 * (int64_t)SECOND;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    assert_null(scene_tick(w, 3 * (int64_t)SECOND));
    world_destroy(w);
}

/* A pose beyond its deadline: what it is now is unknown, but that it flew through is not. */
static void a_pose_that_comes_too_late_is_swept(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = 0.1}, .local = POSE_IDENTITY};
    world_body def = body_of("bullet", &s, vec(-1, 0, 0), WORLD_CCD_FULL);
    def.deadline_ns = SECOND / 10;
    uint32_t id = put(w, &def);
    ball(w, "post", VEC_ZERO, 0.1, WORLD_CCD_OFF);
    world_subscription all = all_of(WORLD_IMPACT, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    move(w, id, vec(1, 0, 0), UPRIGHT, 2 * (int64_t)SECOND, NULL, NULL);
    const world_batch *b = scene_tick(w, 3 * (int64_t)SECOND);
    assert_int_equal(count(b, EVENT_IMPACT), 1);
    assert_int_equal(count(b, EVENT_UNKNOWN), 1);
    world_destroy(w);
}

/* Unknown and known again: told before the rest, and once, whether it is predicted still or not. */
static void what_is_predicted_is_known_again_first(void **state)
{
    (void)state;
    for (int still = 0; still < 2; still++) {
        world *w = scene_world(1, true);
        uint32_t a = ball(w, "a", vec(-3, 0, 0), 0.5, WORLD_CCD_OFF);
        ball(w, "b", vec(3, 0, 0), 0.5, WORLD_CCD_OFF);
        world_subscription all = all_of(WORLD_PREDICT, 2);
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        vec3 fast = {4, 0, 0}, slow = {2.49, 0, 0}; /* then 2 cm are left after 2 s */
        move(w, a, vec(-3, 0, 0), UPRIGHT, 2 * (int64_t)SECOND, &fast, NULL);
        int64_t id = scene_tick(w, 2 * (int64_t)SECOND)->events[0].contact;
        world_hold_body(w, a);
        assert_int_equal(count(scene_tick(w, 3 * (int64_t)SECOND), EVENT_UNKNOWN), 2); /* the body, and the pair */
        move(w, a, vec(-3, 0, 0), UPRIGHT, 4 * (int64_t)SECOND, still ? &slow : &fast, NULL);
        const world_batch *b = scene_tick(w, 4 * (int64_t)SECOND);
        assert_int_equal(b->count, 3);
        assert_true(b->events[1].kind == EVENT_KNOWN && b->events[1].contact == id);
        assert_true(b->events[2].kind == (still ? EVENT_AVERTED : EVENT_PREDICTED) && b->events[2].contact == id);
        world_destroy(w);
    }
}

/* The rate holds an update of a contact back; the contact ends before it is due, and the pair is still predicted. */
static void an_update_that_was_held_back_ends_with_its_contact(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = ball(w, "a", VEC_ZERO, 0.5, WORLD_CCD_OFF);
    ball(w, "b", vec(0.9, 0, 0), 0.5, WORLD_CCD_OFF);
    world_subscription all = all_of(WORLD_PREDICT | WORLD_TOUCH, 2);
    all.period_ns = 10;
    scene_subscription(w, &all);
    scene_tick(w, 1);
    vec3 fast = {4, 0, 0};
    move(w, a, VEC_ZERO, UPRIGHT, SECOND, &fast, NULL);
    scene_tick(w, 2);
    move(w, a, vec(0.01, 0, 0), UPRIGHT, SECOND, &fast, NULL);
    scene_tick(w, 3);
    move(w, a, vec(-1, 0, 0), UPRIGHT, SECOND, &fast, NULL);
    assert_int_equal(count(scene_tick(w, 4), EVENT_END), 1);
    const world_batch *b = scene_tick(w, 30);
    assert_non_null(b);
    for (size_t i = 0; i < b->count; i++) assert_true(b->events[i].kind == EVENT_PREDICTED && b->events[i].contact > 0);
    world_destroy(w);
}

/* Two subscriptions in a pair; a change of group takes it from one of them. */
static void a_pair_that_is_none_any_more_to_one_subscription_ends_there(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
    world_body def = body_of("a", &s, VEC_ZERO, WORLD_CCD_OFF);
    def.group = "robots";
    uint32_t id = put(w, &def);
    ball(w, "b", vec(0.9, 0, 0), 0.5, WORLD_CCD_OFF);
    world_subscription all = all_of(WORLD_TOUCH, 0), robots = all;
    robots.select_a = "group:robots";
    scene_subscription(w, &all);
    uint32_t theirs = scene_subscription(w, &robots);
    scene_tick(w, SECOND);
    assert_int_equal(world_get_figures(w).contacts, 2);
    def.group = "others";
    def.stamp_ns = 2 * (int64_t)SECOND;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    const world_batch *b = scene_tick(w, 2 * (int64_t)SECOND);
    assert_true(b->subscription == theirs && b->count == 1);
    assert_true(b->events[0].kind == EVENT_END && b->events[0].cause == CAUSE_SUBSCRIPTION);
    assert_int_equal(world_get_figures(w).contacts, 1);
    world_destroy(w);
}

static const world_event *first_impact(const world_batch *b)
{
    for (size_t i = 0; b && i < b->count; i++)
        if (b->events[i].kind == EVENT_IMPACT) return &b->events[i];
    return NULL;
}

/* Round a corner within one tick: what stands before the corner is met, what stands on the straight line is not; and
 * when, the stamps say. */
static void every_pose_between_two_ticks_is_on_the_way(void **state)
{
    (void)state;
    for (int stamped = 0; stamped <= 1; stamped++) {
        world *w = scene_world(1, true);
        uint32_t id = ball(w, "ball", VEC_ZERO, 0.1, WORLD_CCD_FULL);
        ball(w, "at the corner", vec(0, 2.5, 0), 0.5, WORLD_CCD_OFF); /* which it does not reach */
        ball(w, "before the corner", vec(0.5, 1, 0), 0.41, WORLD_CCD_OFF);
        ball(w, "on the straight line", vec(1, 1, 0), 0.05, WORLD_CCD_OFF);
        world_subscription all = all_of(WORLD_IMPACT, 0);
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        move(w, id, vec(0, 1.5, 0), UPRIGHT, stamped ? SECOND + SECOND / 4 : 0, NULL, NULL);
        move(w, id, vec(2, 2, 0), UPRIGHT, stamped ? 2 * (int64_t)SECOND : 0, NULL, NULL);
        const world_batch *b = scene_tick(w, 2 * (int64_t)SECOND);
        const world_event *e = first_impact(b);
        assert_int_equal(count(b, EVENT_IMPACT), 1);
        assert_non_null(e);
        bool is_it = strcmp(e->name_a, "before the corner") == 0 || strcmp(e->name_b, "before the corner") == 0;
        assert_true(is_it);
        double y = 1 - sqrt(0.51 * 0.51 - 0.25), leg = stamped ? 0.25 : 0.5; /* s, for the first 1.5 m */
        assert_true(e->impact.lo <= leg * y / 1.5 && e->impact.hi >= leg * y / 1.5 && e->impact.hi < leg);
        assert_int_equal(world_get_figures(w).coarse_motions, 0);
        world_destroy(w);
    }
}

/* A circle of so many poses about a post that every straight line between them misses, and then a dash into it. Of a
 * pose more than are kept, every other one goes, and that is counted. */
static void more_poses_than_are_kept_are_counted(void **state)
{
    (void)state;
    for (int more = 0; more <= 1; more++) {
        world *w = scene_world(1, true);
        uint32_t id = ball(w, "ball", vec(1, 0, 0), 0.1, WORLD_CCD_FULL);
        ball(w, "post", VEC_ZERO, 0.8, WORLD_CCD_OFF);
        world_subscription all = all_of(WORLD_IMPACT, 0);
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        int poses = WAYPOINTS + 1 + more;
        for (int k = 1; k <= poses; k++) {
            double angle = 6.2 * k / poses;
            move(w, id, vec(cos(angle), sin(angle), 0), UPRIGHT, SECOND + k, NULL, NULL);
        }
        assert_int_equal(count(scene_tick(w, 2 * (int64_t)SECOND), EVENT_IMPACT), 0);
        assert_int_equal(world_get_figures(w).coarse_motions, more);
        for (int k = 1; k <= 3; k++) /* through the post and back: neither end touches it */
            move(w, id, vec(k % 2 ? -1 : 1, 0, 0), UPRIGHT, 2 * (int64_t)SECOND + k, NULL, NULL);
        move(w, id, vec(1, 0, 0), UPRIGHT, 2 * (int64_t)SECOND + 4, NULL, NULL);
        assert_int_equal(count(scene_tick(w, 3 * (int64_t)SECOND), EVENT_IMPACT), 1);
        world_destroy(w);
    }
}

/* A ball that makes so many turns until the other one's pose that nobody can tell how it stands then: predicted as
 * open, not from where it was. `lag` s, at 1 m/s, of a horizon of 5 s more: they meet after about 1 s. */
static void what_turns_too_far_until_the_newest_pose_is_open(void **state)
{
    (void)state;
    static const double SPINS[] = {100, 2e5}; /* rad/s */
    const int64_t lag = 9;
    for (size_t k = 0; k < sizeof SPINS / sizeof *SPINS; k++) {
        world *w = scene_world(1, true);
        uint32_t a = ball(w, "a", VEC_ZERO, 0.5, WORLD_CCD_OFF);
        uint32_t b = ball(w, "b", vec((double)lag + 2, 0.3, 0), 0.5, WORLD_CCD_OFF);
        world_subscription all = all_of(WORLD_PREDICT, 0);
        all.horizon = (double)lag + 5;
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        vec3 ahead = {1, 0, 0}, spin = {0, 0, SPINS[k]}, none = VEC_ZERO;
        move(w, a, VEC_ZERO, UPRIGHT, SECOND + 1, &ahead, &spin);
        move(w, b, vec((double)lag + 2, 0.3, 0), UPRIGHT, SECOND + 1 + lag * SECOND, &none, &none);
        const world_batch *batch = scene_tick(w, SECOND + 2 + lag * SECOND);
        assert_int_equal(count(batch, EVENT_PREDICTED), 1);
        const world_impact *i = &batch->events[0].impact;
        if (k == 0) assert_true(i->lo > 1 && isfinite(i->hi));
        if (k > 0) assert_true(i->lo == 0 && isinf(i->hi));
        world_destroy(w);
    }
}

/* The same of a way: one leg of the one, four of the other, which crosses the first one's line just before the end. */
static void what_turns_too_far_on_its_way_is_open(void **state)
{
    (void)state;
    static const double SPINS[] = {0, 1000, 1e5}; /* rad/s, for 20 s */
    static const double STAMPS[] = {0.45, 0.9, 0.95, 0.97, 1}, AT[] = {9, 9, 9, -9, -9};
    const int64_t span = 20 * (int64_t)SECOND;
    for (size_t k = 0; k < sizeof SPINS / sizeof *SPINS; k++) {
        world *w = scene_world(1, true);
        uint32_t a = ball(w, "a", VEC_ZERO, 0.5, WORLD_CCD_FULL);
        uint32_t b = ball(w, "b", vec(9.6, 9, 0), 0.5, WORLD_CCD_FULL);
        world_subscription all = all_of(WORLD_IMPACT, 0);
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        vec3 none = VEC_ZERO, ahead = {0.5, 0, 0}, spin = {0, 0, SPINS[k]};
        for (size_t i = 0; i < sizeof AT / sizeof *AT; i++)
            move(w, b, vec(9.6, AT[i], 0), UPRIGHT, SECOND + (int64_t)(STAMPS[i] * (double)span), &none, &none);
        move(w, a, vec(10, 0, 0), UPRIGHT, SECOND + span, &ahead, &spin);
        assert_int_equal(count(scene_tick(w, SECOND + span), EVENT_IMPACT), 1);
        world_destroy(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_pose_between_two_ticks_is_on_the_way),
        cmocka_unit_test(more_poses_than_are_kept_are_counted),
        cmocka_unit_test(each_ways_turns_are_those_of_its_own_time),
        cmocka_unit_test(what_keeps_its_orientation_does_not_turn),
        cmocka_unit_test(a_linear_way_that_begins_in_contact_is_told),
        cmocka_unit_test(half_spaces_have_courses),
        cmocka_unit_test(a_fixed_body_has_a_way_and_no_course),
        cmocka_unit_test(a_redefinition_underway_keeps_the_way),
        cmocka_unit_test(a_pose_that_comes_too_late_is_swept),
        cmocka_unit_test(what_is_predicted_is_known_again_first),
        cmocka_unit_test(an_update_that_was_held_back_ends_with_its_contact),
        cmocka_unit_test(a_pair_that_is_none_any_more_to_one_subscription_ends_there),
        cmocka_unit_test(what_turns_too_far_until_the_newest_pose_is_open),
        cmocka_unit_test(what_turns_too_far_on_its_way_is_open),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
